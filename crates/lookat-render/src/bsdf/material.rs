//! From a material at a point to its lobes, as pbrt-v3's materials have them.

use glam::Vec3;
use lookat_scene::{
    Glass, Material, MaterialKind, Matte, Metal, Mix, Plastic, Roughness, Substrate, Texture, Translucent,
    Uber,
};

use super::fresnel::Fresnel;
use super::lobe::{Kind, PointLobe};
use super::microfacet::{alpha, alpha_of_roughness};
use super::slots::PointLobes;
use crate::texture::TexturePoint;

impl PointLobes {
    /// Those of a material at a point.
    pub fn new(material: &MaterialKind, at: &TexturePoint) -> Self {
        let mut lobes = PointLobes::default();
        Builder { at, lobes: &mut lobes }.add(material, Vec3::ONE);
        lobes
    }
}

/// The most lobes that a material has at any point, and how many of them are specular at most.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct MostLobes {
    pub all: usize,
    pub specular: usize,
}

/// The most lobes of a material: exact where it is everywhere alike, else a bound.
pub(crate) fn most_lobes(material: &Material) -> MostLobes {
    if material.needs().coordinates {
        return bound(material.kind());
    }
    let PointLobes(lobes) = PointLobes::new(material.kind(), &TexturePoint::default());
    MostLobes { all: lobes.len(), specular: lobes.iter().filter(|lobe| lobe.kind.is_specular()).count() }
}

/// What [`Builder`] adds at most, whatever the textures give.
fn bound(material: &MaterialKind) -> MostLobes {
    let most = |all, specular| MostLobes { all, specular };
    match material {
        MaterialKind::None => most(0, 0),
        MaterialKind::Matte(_) | MaterialKind::Metal(_) | MaterialKind::Substrate(_) => most(1, 0),
        MaterialKind::Mirror(_) => most(1, 1),
        MaterialKind::Plastic(_) => most(2, 0),
        MaterialKind::Translucent(_) => most(4, 0),
        // Smooth it has one lobe, and so between alike media.
        MaterialKind::Glass(_) => most(2, 1),
        MaterialKind::Uber(_) => most(5, 3),
        MaterialKind::Mix(mix) => {
            let [a, b] = [0, 1].map(|part: usize| bound(mix.materials[part].kind()));
            most(a.all + b.all, a.specular + b.specular)
        }
    }
}

/// Collects the lobes of a material.
struct Builder<'a> {
    at: &'a TexturePoint,
    lobes: &'a mut PointLobes,
}

impl Builder<'_> {
    /// The lobes of a material, times `weight`.
    fn add(&mut self, material: &MaterialKind, weight: Vec3) {
        match material {
            MaterialKind::Matte(matte) => self.matte(matte, weight),
            MaterialKind::Plastic(plastic) => self.plastic(plastic, weight),
            MaterialKind::Translucent(translucent) => self.translucent(translucent, weight),
            MaterialKind::Glass(glass) => self.glass(glass, weight),
            MaterialKind::Mirror(mirror) => {
                self.push(Kind::Mirror(Fresnel::Perfect), weight * self.share(&mirror.kr));
            }
            MaterialKind::Metal(metal) => self.metal(metal, weight),
            MaterialKind::Substrate(layers) => self.substrate(layers, weight),
            MaterialKind::Uber(uber) => self.uber(uber, weight),
            MaterialKind::Mix(mix) => self.mix(mix, weight),
            MaterialKind::None => {}
        }
    }

    /// Adds a lobe, unless nothing comes of it.
    fn push(&mut self, kind: Kind, color: Vec3) {
        self.push_lobe(PointLobe::new(kind, color));
    }

    fn push_lobe(&mut self, lobe: PointLobe) {
        if lobe.color != Vec3::ZERO {
            self.lobes.0.push(lobe);
        }
    }

    /// A share of light: at least 0.
    fn share(&self, texture: &Texture<Vec3>) -> Vec3 {
        self.at.value(texture).max(Vec3::ZERO)
    }

    fn matte(&mut self, matte: &Matte, weight: Vec3) {
        let reflectance = weight * self.share(&matte.kd);
        let sigma = self.at.value(&matte.sigma).clamp(0.0, 90.0);
        if sigma == 0.0 {
            return self.push(Kind::Lambert, reflectance);
        }
        let squared = sigma.to_radians().powi(2);
        let a = 1.0 - squared / (2.0 * (squared + 0.33));
        let b = 0.45 * squared / (squared + 0.09);
        let roughness = [a as f32, b as f32];
        self.push_lobe(PointLobe { roughness, ..PointLobe::new(Kind::OrenNayar, reflectance) });
    }

    fn plastic(&mut self, plastic: &Plastic, weight: Vec3) {
        self.push(Kind::Lambert, weight * self.share(&plastic.kd));
        // pbrt-v3 has the inside out: the light comes from what has an index of 1.5.
        let eta = (1.0 / PLASTIC) as f32;
        self.glossy(weight * self.share(&plastic.ks), self.alpha(&plastic.roughness), eta);
    }

    /// Facets of a dielectric that reflect.
    fn glossy(&mut self, reflectance: Vec3, roughness: [f32; 2], eta: f32) {
        let lobe = PointLobe::new(Kind::Microfacet(Fresnel::Dielectric), reflectance);
        self.push_lobe(PointLobe { roughness, eta, ..lobe });
    }

    fn translucent(&mut self, translucent: &Translucent, weight: Vec3) {
        let reflect = weight * self.share(&translucent.reflect);
        let transmit = weight * self.share(&translucent.transmit);
        let (kd, ks) = (self.share(&translucent.kd), self.share(&translucent.ks));
        self.push(Kind::Lambert, reflect * kd);
        self.push(Kind::LambertTransmission, transmit * kd);
        self.rough_dielectric([reflect * ks, transmit * ks], self.alpha(&translucent.roughness), PLASTIC);
    }

    fn rough_dielectric(&mut self, [reflectance, transmittance]: [Vec3; 2], roughness: [f32; 2], eta: f64) {
        // Between alike media no facet reflects or bends light; pbrt-v3 ends there.
        if (eta - 1.0).abs() < ALIKE {
            return self.refraction(transmittance, 1.0);
        }
        self.glossy(reflectance, roughness, eta as f32);
        let lobe = PointLobe::new(Kind::MicrofacetTransmission, transmittance);
        self.push_lobe(PointLobe { roughness, eta: eta as f32, ..lobe });
    }

    fn refraction(&mut self, transmittance: Vec3, eta: f64) {
        self.push_lobe(PointLobe { eta: eta as f32, ..PointLobe::new(Kind::Refraction, transmittance) });
    }

    fn glass(&mut self, glass: &Glass, weight: Vec3) {
        let colors = [weight * self.share(&glass.kr), weight * self.share(&glass.kt)];
        let eta = self.index(&glass.eta);
        let v = glass.roughness.v.as_ref().unwrap_or(&glass.roughness.u);
        if self.at.value(&glass.roughness.u) == 0.0 && self.at.value(v) == 0.0 {
            let lobe = PointLobe::new(Kind::Glass, colors[0].max(colors[1]));
            return self.push_lobe(PointLobe { colors, eta: eta as f32, ..lobe });
        }
        self.rough_dielectric(colors, self.alpha(&glass.roughness), eta);
    }

    fn metal(&mut self, metal: &Metal, weight: Vec3) {
        let colors = [self.at.value(&metal.eta), self.at.value(&metal.k)];
        let roughness = self.alpha(&metal.roughness);
        let lobe = PointLobe::new(Kind::Microfacet(Fresnel::Conductor), weight);
        self.push_lobe(PointLobe { colors, roughness, ..lobe });
    }

    fn substrate(&mut self, substrate: &Substrate, weight: Vec3) {
        let colors = [self.share(&substrate.kd), self.share(&substrate.ks)];
        if colors != [Vec3::ZERO; 2] {
            let roughness = self.alpha(&substrate.roughness);
            self.push_lobe(PointLobe { colors, roughness, ..PointLobe::new(Kind::Substrate, weight) });
        }
    }

    fn uber(&mut self, uber: &Uber, weight: Vec3) {
        let opacity = self.share(&uber.opacity);
        self.refraction(weight * (Vec3::ONE - opacity).max(Vec3::ZERO), 1.0);
        let share = |builder: &Self, texture| weight * opacity * builder.share(texture);
        self.push(Kind::Lambert, share(self, &uber.kd));
        let eta = self.index(&uber.eta);
        let glossy = share(self, &uber.ks);
        if glossy != Vec3::ZERO {
            self.glossy(glossy, self.alpha(&uber.roughness), eta as f32);
        }
        let mirror = PointLobe::new(Kind::Mirror(Fresnel::Dielectric), share(self, &uber.kr));
        self.push_lobe(PointLobe { eta: eta as f32, ..mirror });
        self.refraction(share(self, &uber.kt), eta);
    }

    fn mix(&mut self, mix: &Mix, weight: Vec3) {
        let first = self.share(&mix.amount);
        let shares = [first, (Vec3::ONE - first).max(Vec3::ZERO)];
        for (material, share) in mix.materials.iter().zip(shares) {
            // What has no share costs nothing.
            if share != Vec3::ZERO {
                self.add(material.kind(), weight * share);
            }
        }
    }

    /// An index of refraction. Textures may give what no substance has.
    fn index(&self, texture: &Texture<f64>) -> f64 {
        self.at.value(texture).max(1e-3)
    }

    /// The widths of the distribution of facets.
    fn alpha(&self, roughness: &Roughness) -> [f32; 2] {
        let width = |texture: &Texture<f64>| {
            let here = self.at.value(texture);
            alpha(if roughness.remap { alpha_of_roughness(here) } else { here })
        };
        let u = width(&roughness.u);
        [u, roughness.v.as_ref().map_or(u, width)]
    }
}

/// The index of refraction of plastic and translucent surfaces.
const PLASTIC: f64 = 1.5;
/// Indices that differ by less are the same: the direction of a facet that bends light so little is lost in rounding.
const ALIKE: f64 = 1e-4;
