//! From a material at points to its lobes, as pbrt-v3's materials have them.

use std::array;

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};
use glam::{DVec3, Vec3};
use lookat_scene::{
    Disney, Glass, Hair, HairColor, LUMINANCE, Material, MaterialKind, Matte, Metal, Mix, Plastic, Roughness,
    Substrate, Subsurface, Texture, ThinDisney, Translucent, Uber,
};

use super::fourier::Table;
use super::hair::{absorption, logistic_scale, variance};
use super::lobe::{DisneyLobe, LobeKind, Lobes};
use super::microfacet::{alpha, alpha_of_roughness, in_range};
use crate::bsdf::lobe::Fresnel;
use crate::bsdf::{Inside, LobeSlots, PointLobes};
use crate::number::{LANES, Vec3fx8, baseline, bits, narrow, splat_f32, to_f32, vectorized, widen};
use crate::texture::TexturePoint;

impl<'m, S: Simd> LobeSlots<'m, S> {
    /// Adds the lobes of a material at points, which have none yet.
    pub fn build(&mut self, material: &'m MaterialKind, at: &TexturePoint<S>, points: mask64x8<S>) {
        Builder { at, slots: self, from: 0 }.add(material, Vec3fx8::splat(points.token(), Vec3::ONE), points);
    }
}

impl<'m> PointLobes<'m> {
    /// The lobes of a material without textures.
    pub fn new(material: &'m MaterialKind) -> Self {
        baseline!(simd => {
            let mut slots = LobeSlots::new();
            slots.build(material, &TexturePoint::splat(simd, DVec3::ZERO, [0.0; 2]), bits(simd, 1));
            slots.first()
        })
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
    let PointLobes { lobes, .. } = PointLobes::new(material.kind());
    MostLobes { all: lobes.len(), specular: lobes.iter().filter(|lobe| lobe.kind.is_delta()).count() }
}

/// The most lobes that [`Builder`] adds for any values of the textures.
fn bound(material: &MaterialKind) -> MostLobes {
    let most = |all, specular| MostLobes { all, specular };
    match material {
        MaterialKind::None => most(0, 0),
        MaterialKind::Matte(_)
        | MaterialKind::Metal(_)
        | MaterialKind::Substrate(_)
        | MaterialKind::Hair(_)
        | MaterialKind::Fourier(_) => most(1, 0),
        MaterialKind::Mirror(_) => most(1, 1),
        MaterialKind::Plastic(_) => most(2, 0),
        MaterialKind::Translucent(_) => most(3, 0),
        MaterialKind::Glass(_) | MaterialKind::Subsurface(_) => most(1, 1),
        MaterialKind::Uber(_) => most(5, 3),
        MaterialKind::Disney(disney) => most(
            4 + usize::from(disney.thin.is_some()) + usize::from(disney.scatters_inside()),
            1 + usize::from(disney.scatters_inside()),
        ),
        MaterialKind::Mix(mix) => {
            let [a, b] = [0, 1].map(|part: usize| bound(mix.materials[part].kind()));
            most(a.all + b.all, a.specular + b.specular)
        }
    }
}

/// Collects the lobes of a material, at points that are active.
struct Builder<'a, 'm, S: Simd> {
    at: &'a TexturePoint<'a, S>,
    slots: &'a mut LobeSlots<'m, S>,
    /// The lobes so far are in slots before this one.
    from: usize,
}

impl<'m, S: Simd> Builder<'_, 'm, S> {
    /// The lobes of a material, times `weight`.
    #[inline(never)]
    fn add(&mut self, material: &'m MaterialKind, weight: Vec3fx8<S>, active: mask64x8<S>) {
        vectorized!(active.token(), {
            match material {
                MaterialKind::Matte(matte) => self.matte(matte, weight, active),
                MaterialKind::Plastic(plastic) => self.plastic(plastic, weight, active),
                MaterialKind::Translucent(translucent) => self.translucent(translucent, weight, active),
                MaterialKind::Glass(glass) => self.glass(glass, weight, active),
                MaterialKind::Mirror(mirror) => {
                    let color = weight * self.reflectance(&mirror.kr, active);
                    self.push(Lobes::new(LobeKind::Mirror(Fresnel::Perfect), color), active);
                }
                MaterialKind::Metal(metal) => self.metal(metal, weight, active),
                MaterialKind::Substrate(layers) => self.substrate(layers, weight, active),
                MaterialKind::Uber(uber) => self.uber(uber, weight, active),
                MaterialKind::Disney(disney) => self.disney(disney, weight, active),
                MaterialKind::Subsurface(subsurface) => self.subsurface(subsurface, weight, active),
                MaterialKind::Hair(hair) => self.hair(hair, weight, active),
                MaterialKind::Fourier(table) => {
                    self.push(Lobes::new(LobeKind::Fourier(Table(table)), weight), active);
                }
                MaterialKind::Mix(mix) => self.mix(mix, weight, active),
                MaterialKind::None => {}
            }
        })
    }

    /// Adds a lobe where its color is not black.
    #[inline(never)]
    fn push(&mut self, lobe: Lobes<'m, S>, active: mask64x8<S>) {
        vectorized!(active.token(), {
            let own = active & lobe.color.is_light();
            if own.any_true() {
                self.slots.push(lobe, narrow(own), &mut self.from);
            }
        })
    }

    /// Reflectances: at least 0.
    #[inline(always)]
    fn reflectance(&self, texture: &Texture<Vec3>, active: mask64x8<S>) -> Vec3fx8<S> {
        not_negative(self.at.value(texture, active))
    }

    #[inline(always)]
    fn matte(&mut self, matte: &Matte, weight: Vec3fx8<S>, active: mask64x8<S>) {
        let reflectance = weight * self.reflectance(&matte.kd, active);
        let sigma = at_least(self.at.value(&matte.sigma, active), 0.0).min(90.0);
        let is_smooth = sigma.simd_eq(0.0);
        self.push(Lobes::new(LobeKind::Lambert, reflectance), active & is_smooth);
        let rough = active & !is_smooth;
        if rough.any_true() {
            let squared = sigma.to_radians() * sigma.to_radians();
            let a = 1.0 - squared / (2.0 * (squared + 0.33));
            let b = 0.45 * squared / (squared + 0.09);
            let roughness = [to_f32(a), to_f32(b)];
            self.push(Lobes { roughness, ..Lobes::new(LobeKind::OrenNayar, reflectance) }, rough);
        }
    }

    #[inline(always)]
    fn plastic(&mut self, plastic: &Plastic, weight: Vec3fx8<S>, active: mask64x8<S>) {
        self.push(Lobes::new(LobeKind::Lambert, weight * self.reflectance(&plastic.kd, active)), active);
        // pbrt-v3 swaps inside and outside here: light arrives from the side of index 1.5.
        let eta = splat_f32(active.token(), (1.0 / COATING_INDEX) as f32);
        let reflectance = weight * self.reflectance(&plastic.ks, active);
        self.glossy(reflectance, self.alpha(&plastic.roughness, active), eta, active);
    }

    /// Facets of a dielectric that reflect.
    #[inline(always)]
    fn glossy(
        &mut self,
        reflectance: Vec3fx8<S>,
        roughness: [f32x8<S>; 2],
        eta: f32x8<S>,
        active: mask64x8<S>,
    ) {
        let lobe = Lobes::new(LobeKind::Microfacet(Fresnel::Dielectric), reflectance);
        self.push(Lobes { roughness, eta, ..lobe }, active);
    }

    #[inline(always)]
    fn translucent(&mut self, translucent: &Translucent, weight: Vec3fx8<S>, active: mask64x8<S>) {
        let reflect = weight * self.reflectance(&translucent.reflect, active);
        let transmit = weight * self.reflectance(&translucent.transmit, active);
        let (kd, ks) = (self.reflectance(&translucent.kd, active), self.reflectance(&translucent.ks, active));
        self.push(Lobes::new(LobeKind::Lambert, reflect * kd), active);
        self.push(Lobes::new(LobeKind::LambertTransmission, transmit * kd), active);
        let roughness = self.alpha(&translucent.roughness, active);
        let eta = f64x8::splat(active.token(), COATING_INDEX);
        self.rough_dielectric([reflect * ks, transmit * ks], roughness, eta, active);
    }

    #[inline(always)]
    fn rough_dielectric(
        &mut self,
        [reflectance, transmittance]: [Vec3fx8<S>; 2],
        roughness: [f32x8<S>; 2],
        eta: f64x8<S>,
        active: mask64x8<S>,
    ) {
        // Between alike media no facet reflects or bends light; pbrt-v3 ends there.
        let is_alike = (eta - 1.0).abs().simd_lt(SAME_INDEX);
        let one = splat_f32(active.token(), 1.0);
        self.refraction(transmittance, one, active & is_alike);
        let (active, eta) = (active & !is_alike, to_f32(eta));
        let lobe = Lobes::new(LobeKind::RoughGlass, larger(reflectance, transmittance));
        let colors = [reflectance, transmittance];
        self.push(Lobes { colors, roughness, eta, ..lobe }, active);
    }

    #[inline(always)]
    fn refraction(&mut self, transmittance: Vec3fx8<S>, eta: f32x8<S>, active: mask64x8<S>) {
        self.push(Lobes { eta, ..Lobes::new(LobeKind::Refraction, transmittance) }, active);
    }

    #[inline(always)]
    fn glass(&mut self, glass: &Glass, weight: Vec3fx8<S>, active: mask64x8<S>) {
        let colors =
            [weight * self.reflectance(&glass.kr, active), weight * self.reflectance(&glass.kt, active)];
        let eta = self.index(&glass.eta, active);
        let is_smooth = |texture: &Texture<f64>| self.at.value(texture, active).simd_eq(0.0);
        let v = glass.roughness.v.as_ref().unwrap_or(&glass.roughness.u);
        let is_smooth = is_smooth(&glass.roughness.u) & is_smooth(v);
        let lobe = Lobes::new(LobeKind::Glass, larger(colors[0], colors[1]));
        self.push(Lobes { colors, eta: to_f32(eta), ..lobe }, active & is_smooth);
        let rough = active & !is_smooth;
        if rough.any_true() {
            self.rough_dielectric(colors, self.alpha(&glass.roughness, rough), eta, rough);
        }
    }

    /// The boundary is that of glass.
    #[inline(never)]
    fn subsurface(&mut self, subsurface: &Subsurface, weight: Vec3fx8<S>, active: mask64x8<S>) {
        vectorized!(active.token(), {
            self.glass(&subsurface.surface, weight, active);
            let [a, b] = subsurface.interior.colors();
            let colors = [self.reflectance(a, active), self.reflectance(b, active)];
            let eta = splat_f32(active.token(), subsurface.eta as f32);
            self.slots.set_inside(Inside { mask: narrow(active), colors, eta });
        })
    }

    #[inline(always)]
    fn metal(&mut self, metal: &Metal, weight: Vec3fx8<S>, active: mask64x8<S>) {
        let colors = [self.at.value(&metal.eta, active), self.at.value(&metal.k, active)];
        let roughness = self.alpha(&metal.roughness, active);
        let lobe = Lobes::new(LobeKind::Microfacet(Fresnel::Conductor), weight);
        self.push(Lobes { colors, roughness, ..lobe }, active);
    }

    #[inline(always)]
    fn substrate(&mut self, substrate: &Substrate, weight: Vec3fx8<S>, active: mask64x8<S>) {
        let colors = [self.reflectance(&substrate.kd, active), self.reflectance(&substrate.ks, active)];
        let active = active & (colors[0].is_light() | colors[1].is_light());
        let roughness = self.alpha(&substrate.roughness, active);
        self.push(Lobes { colors, roughness, ..Lobes::new(LobeKind::Substrate, weight) }, active);
    }

    #[inline(always)]
    fn uber(&mut self, uber: &Uber, weight: Vec3fx8<S>, active: mask64x8<S>) {
        let white = Vec3fx8::splat(active.token(), Vec3::ONE);
        let opacity = self.reflectance(&uber.opacity, active);
        self.refraction(weight * not_negative(white - opacity), white.x, active);
        let weight = weight * opacity;
        self.push(Lobes::new(LobeKind::Lambert, weight * self.reflectance(&uber.kd, active)), active);
        let eta = to_f32(self.index(&uber.eta, active));
        let glossy = weight * self.reflectance(&uber.ks, active);
        let is_glossy = active & glossy.is_light();
        if is_glossy.any_true() {
            self.glossy(glossy, self.alpha(&uber.roughness, is_glossy), eta, is_glossy);
        }
        let mirror =
            Lobes::new(LobeKind::Mirror(Fresnel::Dielectric), weight * self.reflectance(&uber.kr, active));
        self.push(Lobes { eta, ..mirror }, active);
        self.refraction(weight * self.reflectance(&uber.kt, active), eta, active);
    }

    #[inline(never)]
    fn disney(&mut self, disney: &Disney, weight: Vec3fx8<S>, active: mask64x8<S>) {
        let simd = active.token();
        vectorized!(simd, {
            let white = Vec3fx8::splat(simd, Vec3::ONE);
            let one = white.x;
            let color = self.reflectance(&disney.color, active);
            let metallic = self.share(&disney.metallic, active);
            let clear = self.share(&disney.spec_trans, active);
            let eta = self.index(&disney.eta, active);
            let roughness = self.amount(&disney.roughness, 1e6, active);
            // The hue: the color over its luminance.
            let luminance =
                color.x * LUMINANCE.x as f32 + color.y * LUMINANCE.y as f32 + color.z * LUMINANCE.z as f32;
            let tint = (color / luminance).keep_where(luminance.simd_gt(0.0), white);

            // In a thin sheet, a part of the diffuse light is transmitted.
            let (mut flatness, mut transmitted) = (splat_f32(simd, 0.0), splat_f32(simd, 0.0));
            if let Some(ThinDisney { flatness: flat, diff_trans }) = &disney.thin {
                flatness = self.share(flat, active);
                transmitted = self.amount(diff_trans, 2.0, active) * 0.5;
            }
            let share = (1.0 - metallic) * (1.0 - clear);
            let diffuse = weight * share;
            // Or it leaves a solid elsewhere.
            let mut reflected = 1.0 - transmitted;
            if disney.scatters_inside() {
                let distance = self.reflectance(&disney.scatter_distance, active);
                let own = active & distance.is_light() & diffuse.is_light();
                let lobe = Lobes::new(LobeKind::Refraction, weight);
                self.push(Lobes { eta: to_f32(eta), ..lobe }, own);
                let mask = narrow(own);
                // The lobe has the weight.
                self.slots.set_inside(Inside { mask, colors: [color * share, distance], eta: to_f32(eta) });
                reflected = mask.select(splat_f32(simd, 0.0), reflected);
            }
            let sheen = self.amount(&disney.sheen, 1e6, active);
            let sheen_tint = self.share(&disney.sheen_tint, active);
            let sheen = (white + (tint - white) * sheen_tint) * sheen;
            let clear_solid =
                if disney.thin.is_some() { !active } else { active & widen(clear.simd_gt(0.0)) };
            for (outside, own) in [(true, active & clear_solid), (false, active & !clear_solid)] {
                let lobe = Lobes::new(LobeKind::Disney(DisneyLobe::Diffuse { outside }), diffuse);
                let own = own & (color.is_light() | sheen.is_light());
                let colors = [color, sheen];
                self.push(Lobes { colors, roughness: [roughness, flatness], eta: reflected, ..lobe }, own);
            }

            let aspect = (1.0 - 0.9 * self.share(&disney.anisotropic, active)).sqrt();
            let specular_tint = self.share(&disney.specular_tint, active);
            let at_normal = to_f32((eta - 1.0) / (eta + 1.0));
            let at_normal = (white + (tint - white) * specular_tint) * (at_normal * at_normal);
            let at_normal = at_normal + (color - at_normal) * metallic;
            let fresnel = Fresnel::Disney { is_thin: disney.thin.is_some() };
            let lobe = Lobes::new(LobeKind::Microfacet(fresnel), weight);
            let colors = [at_normal, white * metallic];
            self.push(
                Lobes { colors, roughness: stretched(roughness, aspect), eta: to_f32(eta), ..lobe },
                active,
            );

            let clearcoat = self.amount(&disney.clearcoat, 1e6, active);
            let gloss = self.share(&disney.clearcoat_gloss, active);
            let width = 0.1 + (0.001 - 0.1) * gloss;
            for (outside, own) in [(true, active & clear_solid), (false, active & !clear_solid)] {
                let lobe =
                    Lobes::new(LobeKind::Disney(DisneyLobe::Clearcoat { outside }), weight * clearcoat);
                self.push(Lobes { roughness: [width, one], ..lobe }, own);
            }

            let clear = clear * (1.0 - metallic);
            let root = Vec3fx8 { x: color.x.sqrt(), y: color.y.sqrt(), z: color.z.sqrt() };
            let transmittance = weight * root * clear;
            if disney.thin.is_some() {
                // A thin sheet seems smoother where its index is low (Burley 2015, figure 15).
                let scaled = (to_f32(eta) * 0.65 - 0.35) * roughness;
                let lobe = Lobes::new(LobeKind::Disney(DisneyLobe::ThinTransmission), transmittance);
                self.push(Lobes { roughness: stretched(scaled, aspect), eta: to_f32(eta), ..lobe }, active);
                let transmitted = diffuse * color * transmitted;
                self.push(Lobes::new(LobeKind::LambertTransmission, transmitted), active);
            } else {
                let is_alike = (eta - 1.0).abs().simd_lt(SAME_INDEX);
                self.refraction(transmittance, one, active & is_alike);
                let lobe = Lobes::new(LobeKind::Disney(DisneyLobe::Transmission), transmittance);
                self.push(
                    Lobes { roughness: stretched(roughness, aspect), eta: to_f32(eta), ..lobe },
                    active & !is_alike,
                );
            }
        })
    }

    #[inline(never)]
    fn hair(&mut self, hair: &Hair, weight: Vec3fx8<S>, active: mask64x8<S>) {
        let simd = active.token();
        vectorized!(simd, {
            let [beta_m, beta_n] = [&hair.beta_m, &hair.beta_n].map(
                #[inline(always)]
                |texture| self.share(texture, active),
            );
            let absorption = match &hair.color {
                HairColor::Absorption(sigma_a) => self.reflectance(sigma_a, active),
                HairColor::Reflectance(color) => absorption(self.reflectance(color, active), beta_n),
                HairColor::Pigments { eumelanin, pheomelanin } => {
                    let [brown, red] = [eumelanin, pheomelanin].map(
                        #[inline(always)]
                        |texture| to_f32(at_least(self.at.value(texture, active), 0.0)),
                    );
                    Vec3fx8::splat(simd, EUMELANIN) * brown + Vec3fx8::splat(simd, PHEOMELANIN) * red
                }
            };
            let h = to_f32(at_least(self.at.uv[1] * 2.0 - 1.0, -1.0).min(1.0));
            let angles = self.at.value(&hair.alpha, active);
            let alpha: [[f64; 2]; LANES] = array::from_fn(|lane| {
                let (sin, cos) = libm::sincos(angles[lane].to_radians());
                if sin.is_finite() { [sin, cos] } else { [0.0, 1.0] }
            });
            let [sin, cos] = [0, 1].map(
                #[inline(always)]
                |at: usize| f32x8::from_fn(simd, |lane| alpha[lane][at] as f32),
            );
            let lobe = Lobes {
                colors: [absorption, Vec3fx8 { x: h, y: sin, z: cos }],
                roughness: [variance(beta_m), logistic_scale(beta_n)],
                eta: to_f32(at_least(self.at.value(&hair.eta, active), 1.0).min(1e6)),
                ..Lobes::new(LobeKind::Hair, weight)
            };
            self.push(lobe, active);
        })
    }

    /// A number from 0 to 1.
    #[inline(never)]
    fn share(&self, texture: &Texture<f64>, active: mask64x8<S>) -> f32x8<S> {
        vectorized!(active.token(), to_f32(at_least(self.at.value(texture, active), 0.0).min(1.0)))
    }

    /// A number that counts as 0 below that, and as `most` above it.
    #[inline(never)]
    fn amount(&self, texture: &Texture<f64>, most: f64, active: mask64x8<S>) -> f32x8<S> {
        vectorized!(active.token(), to_f32(at_least(self.at.value(texture, active), 0.0).min(most)))
    }

    #[inline(always)]
    fn mix(&mut self, mix: &'m Mix, weight: Vec3fx8<S>, active: mask64x8<S>) {
        let first = self.reflectance(&mix.amount, active);
        let second = not_negative(Vec3fx8::splat(active.token(), Vec3::ONE) - first);
        for (material, share) in mix.materials.iter().zip([first, second]) {
            // What has no share costs nothing.
            let own = active & share.is_light();
            if own.any_true() {
                self.add(material.kind(), weight * share, own);
            }
        }
    }

    /// Indices of refraction. Textures may give what no substance has, and squares must stay finite.
    #[inline(always)]
    fn index(&self, texture: &Texture<f64>, active: mask64x8<S>) -> f64x8<S> {
        at_least(self.at.value(texture, active), 1e-3).min(1e9)
    }

    /// The widths of distributions of facets.
    #[inline(always)]
    fn alpha(&self, roughness: &Roughness, active: mask64x8<S>) -> [f32x8<S>; 2] {
        let u = self.width(&roughness.u, roughness.remap, active);
        let v = match &roughness.v {
            Some(v) => self.width(v, roughness.remap, active),
            None => u,
        };
        [u, v]
    }

    #[inline(never)]
    fn width(&self, texture: &Texture<f64>, remap: bool, active: mask64x8<S>) -> f32x8<S> {
        let of = |width| alpha(if remap { alpha_of_roughness(width) } else { width });
        if let Some(width) = texture.constant() {
            return splat_f32(active.token(), of(width));
        }
        let widths = self.at.value(texture, active);
        let widths: [f32; LANES] = array::from_fn(|lane| match active.to_bitmask() >> lane & 1 {
            1 => of(widths[lane]),
            _ => 1.0,
        });
        widths.simd_into(active.token())
    }
}

/// The widths of Disney's distribution of facets, along and across.
#[inline(always)]
fn stretched<S: Simd>(roughness: f32x8<S>, aspect: f32x8<S>) -> [f32x8<S>; 2] {
    let squared = roughness * roughness;
    [in_range(squared / aspect), in_range(squared * aspect)]
}

/// The larger of two numbers; `least` for NaN, in which processors differ.
#[inline(always)]
fn at_least<S: Simd>(x: f64x8<S>, least: f64) -> f64x8<S> {
    x.simd_gt(least).select(x, least.simd_into(x.token()))
}

/// The larger of two colors in each channel.
#[inline(always)]
fn larger<S: Simd>(a: Vec3fx8<S>, b: Vec3fx8<S>) -> Vec3fx8<S> {
    let larger = |a: f32x8<S>, b: f32x8<S>| a.simd_gt(b).select(a, b);
    Vec3fx8 { x: larger(a.x, b.x), y: larger(a.y, b.y), z: larger(a.z, b.z) }
}

#[inline(always)]
fn not_negative<S: Simd>(color: Vec3fx8<S>) -> Vec3fx8<S> {
    larger(color, Vec3fx8::splat(color.x.token(), Vec3::ZERO))
}

/// The absorption by the brown and the red pigment of hair (HairBSDF::SigmaAFromConcentration).
const EUMELANIN: Vec3 = Vec3::new(0.419, 0.697, 1.37);
const PHEOMELANIN: Vec3 = Vec3::new(0.187, 0.4, 1.05);
/// The index of refraction of plastic and translucent surfaces.
const COATING_INDEX: f64 = 1.5;
/// Indices that differ by less are the same: the direction of a facet that bends light so little is lost in rounding.
const SAME_INDEX: f64 = 1e-4;
