//! From a material at a point to its lobes, as pbrt-v3's materials have them.

use glam::{DVec2, Vec3};
use lookat_scene::{
    Glass, Material, MaterialKind, Matte, Metal, Mix, Plastic, Roughness, Substrate, Texture, Translucent,
    Uber,
};

use super::LobeList;
use super::choice::LikelyLobe;
use super::fresnel::Fresnel;
use super::lobe::Lobe;
use super::microfacet::TrowbridgeReitz;
use crate::texture::TexturePoint;

/// Adds the lobes at a point.
pub(super) fn add_lobes(material: &MaterialKind, at: &TexturePoint, lobes: &mut LobeList) {
    Builder { at, lobes }.add(material, Vec3::ONE);
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
    let mut lobes = LobeList::new();
    add_lobes(material.kind(), &TexturePoint::default(), &mut lobes);
    MostLobes { all: lobes.len(), specular: lobes.iter().filter(|likely| likely.lobe.is_specular()).count() }
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
    lobes: &'a mut LobeList,
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
                let reflectance = weight * self.share(&mirror.kr);
                self.push(reflectance, Lobe::Mirror { reflectance, fresnel: Fresnel::Perfect });
            }
            MaterialKind::Metal(metal) => self.metal(metal, weight),
            MaterialKind::Substrate(layers) => self.substrate(layers, weight),
            MaterialKind::Uber(uber) => self.uber(uber, weight),
            MaterialKind::Mix(mix) => self.mix(mix, weight),
            MaterialKind::None => {}
        }
    }

    /// Adds a lobe, unless nothing comes of it.
    fn push(&mut self, factor: Vec3, lobe: Lobe) {
        if factor != Vec3::ZERO {
            self.lobes.push(LikelyLobe::alone(lobe));
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
            return self.push(reflectance, Lobe::Lambert { reflectance });
        }
        let squared = sigma.to_radians().powi(2);
        let a = 1.0 - squared / (2.0 * (squared + 0.33));
        let b = 0.45 * squared / (squared + 0.09);
        self.push(reflectance, Lobe::OrenNayar { reflectance, a, b });
    }

    fn plastic(&mut self, plastic: &Plastic, weight: Vec3) {
        let diffuse = weight * self.share(&plastic.kd);
        self.push(diffuse, Lobe::Lambert { reflectance: diffuse });
        let reflectance = weight * self.share(&plastic.ks);
        // pbrt-v3 has the inside out: the light comes from what has an index of 1.5.
        let fresnel = Fresnel::Dielectric { eta: 1.0 / PLASTIC };
        let facets = self.facets(&plastic.roughness);
        self.push(reflectance, Lobe::Microfacet { reflectance, facets, fresnel });
    }

    fn translucent(&mut self, translucent: &Translucent, weight: Vec3) {
        let reflect = weight * self.share(&translucent.reflect);
        let transmit = weight * self.share(&translucent.transmit);
        let (kd, ks) = (self.share(&translucent.kd), self.share(&translucent.ks));
        self.push(reflect * kd, Lobe::Lambert { reflectance: reflect * kd });
        self.push(transmit * kd, Lobe::LambertTransmission { transmittance: transmit * kd });
        let facets = self.facets(&translucent.roughness);
        self.rough_dielectric(reflect * ks, transmit * ks, facets, PLASTIC);
    }

    fn rough_dielectric(
        &mut self,
        reflectance: Vec3,
        transmittance: Vec3,
        facets: TrowbridgeReitz,
        eta: f64,
    ) {
        // Between alike media no facet reflects or bends light; pbrt-v3 ends there.
        if (eta - 1.0).abs() < ALIKE {
            return self.push(transmittance, Lobe::Refraction { transmittance, eta: 1.0 });
        }
        let fresnel = Fresnel::Dielectric { eta };
        self.push(reflectance, Lobe::Microfacet { reflectance, facets, fresnel });
        self.push(transmittance, Lobe::MicrofacetTransmission { transmittance, facets, eta });
    }

    fn glass(&mut self, glass: &Glass, weight: Vec3) {
        let (reflectance, transmittance) = (weight * self.share(&glass.kr), weight * self.share(&glass.kt));
        let eta = self.index(&glass.eta);
        let v = glass.roughness.v.as_ref().unwrap_or(&glass.roughness.u);
        if self.at.value(&glass.roughness.u) == 0.0 && self.at.value(v) == 0.0 {
            let lobe = Lobe::Glass { reflectance, transmittance, eta };
            return self.push(reflectance.max(transmittance), lobe);
        }
        let facets = self.facets(&glass.roughness);
        self.rough_dielectric(reflectance, transmittance, facets, eta);
    }

    fn metal(&mut self, metal: &Metal, weight: Vec3) {
        let (eta, k) = (self.at.value(&metal.eta), self.at.value(&metal.k));
        let facets = self.facets(&metal.roughness);
        let fresnel = Fresnel::Conductor { eta, k };
        self.push(weight, Lobe::Microfacet { reflectance: weight, facets, fresnel });
    }

    fn substrate(&mut self, substrate: &Substrate, weight: Vec3) {
        let (diffuse, specular) = (self.share(&substrate.kd), self.share(&substrate.ks));
        if diffuse != Vec3::ZERO || specular != Vec3::ZERO {
            let facets = self.facets(&substrate.roughness);
            self.push(weight, Lobe::Substrate { weight, diffuse, specular, facets });
        }
    }

    fn uber(&mut self, uber: &Uber, weight: Vec3) {
        let opacity = self.share(&uber.opacity);
        let clear = weight * (Vec3::ONE - opacity).max(Vec3::ZERO);
        self.push(clear, Lobe::Refraction { transmittance: clear, eta: 1.0 });
        let share = |builder: &Self, texture| weight * opacity * builder.share(texture);
        let diffuse = share(self, &uber.kd);
        self.push(diffuse, Lobe::Lambert { reflectance: diffuse });
        let eta = self.index(&uber.eta);
        let fresnel = Fresnel::Dielectric { eta };
        let glossy = share(self, &uber.ks);
        if glossy != Vec3::ZERO {
            let facets = self.facets(&uber.roughness);
            self.push(glossy, Lobe::Microfacet { reflectance: glossy, facets, fresnel });
        }
        let mirrored = share(self, &uber.kr);
        self.push(mirrored, Lobe::Mirror { reflectance: mirrored, fresnel });
        let refracted = share(self, &uber.kt);
        self.push(refracted, Lobe::Refraction { transmittance: refracted, eta });
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

    fn facets(&self, roughness: &Roughness) -> TrowbridgeReitz {
        let width = |texture: &Texture<f64>| {
            let roughness_here = self.at.value(texture);
            if roughness.remap { TrowbridgeReitz::alpha_of(roughness_here) } else { roughness_here }
        };
        let u = width(&roughness.u);
        TrowbridgeReitz::new(DVec2::new(u, roughness.v.as_ref().map_or(u, width)))
    }
}

/// The index of refraction of plastic and translucent surfaces.
const PLASTIC: f64 = 1.5;
/// Indices that differ by less are the same: the direction of a facet that bends light so little is lost in rounding.
const ALIKE: f64 = 1e-9;
