//! The lobes of Disney's material (Burley 2012 and 2015; materials/disney.cpp), except the facets that reflect, which are
//! [`LobeKind::Microfacet`](super::lobe::LobeKind) with [`Fresnel::Disney`](super::lobe::Fresnel).

use std::f32::consts::{FRAC_1_PI, PI};

use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use glam::Vec3;

use super::fresnel::{dielectric, schlick, schlick_weight};
use super::lobe::{DisneyLobe, Lobes, cosine, cosine_direction};
use super::microfacet::{half, reflected, refracted};
use crate::number::{V3, Vec3fx8, exp_minus, ln, splat_f32, vectorized};
use crate::warp::at_turn;

/// The width of the distribution by which facets of the clearcoat are hidden.
const CLEARCOAT_MASKING: f32 = 0.25;
/// What a clearcoat of index 1.5 reflects along the normal.
const CLEARCOAT_REFLECTANCE: f32 = 0.04;

impl<S: Simd> Lobes<'_, S> {
    /// The reflectance at an angle: `colors` are that of metal along the normal, and the share of metal.
    #[inline(always)]
    pub fn disney_fresnel(&self, cos: f32x8<S>) -> Vec3fx8<S> {
        let [at_normal, V3 { x: metallic, .. }] = self.colors;
        let metal = schlick(at_normal, cos.max(0.0).min(1.0));
        let dielectric = Vec3fx8::splat(cos.token(), Vec3::ONE) * dielectric(cos, self.eta);
        self.color * (dielectric + (metal - dielectric) * metallic)
    }

    /// About what a lobe scatters of light from `wo`.
    #[inline(never)]
    pub fn disney_albedo(&self, lobe: DisneyLobe, cos_o: f32x8<S>) -> Vec3fx8<S> {
        let simd = cos_o.token();
        vectorized!(simd, {
            let white = Vec3fx8::splat(simd, Vec3::ONE);
            let all = match lobe {
                DisneyLobe::Diffuse { .. } => {
                    let [color, sheen] = self.colors;
                    color * self.eta + sheen * schlick_weight(cos_o.abs())
                }
                DisneyLobe::Clearcoat { .. } => {
                    white
                        * (0.25
                            * (CLEARCOAT_REFLECTANCE
                                + (1.0 - CLEARCOAT_REFLECTANCE) * schlick_weight(cos_o.abs())))
                }
                DisneyLobe::Transmission => white * (1.0 - dielectric(cos_o, self.eta)),
                DisneyLobe::ThinTransmission => white * (1.0 - dielectric(cos_o.abs(), self.eta)),
            };
            (self.color * all).keep_where(lobe.scatters(cos_o), Vec3fx8::splat(simd, Vec3::ZERO))
        })
    }

    /// The value of the BSDF, and the density of [`Lobes::disney_sample`].
    #[inline(never)]
    pub fn disney_f_pdf(&self, lobe: DisneyLobe, wo: Vec3fx8<S>, wi: Vec3fx8<S>) -> (Vec3fx8<S>, f32x8<S>) {
        let simd = wo.x.token();
        vectorized!(simd, {
            let none = splat_f32(simd, 0.0);
            let scatters = lobe.scatters(wo.z);
            let (wh, is_half) = half(wo, wi);
            match lobe {
                DisneyLobe::Diffuse { .. } => {
                    let value = self.disney_diffuse(wo, wi, wi.dot(wh));
                    let value = value.keep_where(is_half & scatters, Vec3fx8::splat(simd, Vec3::ZERO));
                    (self.color * value, scatters.select(cosine(wi), none))
                }
                DisneyLobe::Clearcoat { .. } => {
                    let (density, cos) = (self.clearcoat_density(wh), wo.dot(wh));
                    let fresnel = CLEARCOAT_REFLECTANCE + (1.0 - CLEARCOAT_REFLECTANCE) * schlick_weight(cos);
                    let masking = clearcoat_masking(wo.z) * clearcoat_masking(wi.z);
                    let is_valid = is_half & scatters;
                    let value = is_valid.select(0.25 * masking * fresnel * density, none);
                    (self.color * value, is_valid.select(density * wh.z.abs() / (4.0 * cos), none))
                }
                DisneyLobe::Transmission => {
                    let (value, pdf, _, is_valid) = self.facets().transmission(self.eta, wo, wi);
                    (self.color * is_valid.select(value, none), is_valid.select(pdf, none))
                }
                DisneyLobe::ThinTransmission => {
                    let wi = mirrored(wi);
                    let (wh, is_valid) = half(wo, wi);
                    let is_valid = is_valid & (wo.z * wi.z).simd_gt(0.0);
                    let (value, pdf) = self.facets().reflection(wo, wi, wh);
                    let value = value * (1.0 - dielectric(wi.dot(wh), self.eta));
                    (self.color * is_valid.select(value, none), is_valid.select(pdf, none))
                }
            }
        })
    }

    /// Diffuse light without its factor. `cos_d`: the cosine between a direction and the normal halfway to the other one.
    #[inline(always)]
    fn disney_diffuse(&self, wo: Vec3fx8<S>, wi: Vec3fx8<S>, cos_d: f32x8<S>) -> Vec3fx8<S> {
        let ([color, sheen], [roughness, flatness]) = (self.colors, self.roughness);
        let (cos_o, cos_i) = (wo.z.abs(), wi.z.abs());
        let (grazing_o, grazing_i) = (schlick_weight(cos_o), schlick_weight(cos_i));
        // Burley 2015, equation 4.
        let diffuse = (1.0 - 0.5 * grazing_o) * (1.0 - 0.5 * grazing_i);
        let retro = 2.0 * roughness * cos_d * cos_d;
        let retro = retro * (grazing_o + grazing_i + grazing_o * grazing_i * (retro - 1.0));
        // Hanrahan and Krueger's approximation of subsurface scattering, as in Burley 2012.
        let at_90 = cos_d * cos_d * roughness - 1.0;
        let inside = (1.0 + grazing_o * at_90) * (1.0 + grazing_i * at_90);
        let flat = 1.25 * (inside * (1.0 / (cos_o + cos_i) - 0.5) + 0.5);
        let reflected = self.eta * (diffuse + flatness * (flat - diffuse));
        color * ((reflected + retro) * FRAC_1_PI) + sheen * schlick_weight(cos_d)
    }

    /// Density of the normals of the clearcoat's facets (Burley's GTR1).
    #[inline(always)]
    fn clearcoat_density(&self, wh: Vec3fx8<S>) -> f32x8<S> {
        let squared = self.roughness[0] * self.roughness[0];
        let slope = wh.x * wh.x + wh.y * wh.y + squared * wh.z * wh.z;
        (1.0 - squared) / (-PI * ln(squared) * slope)
    }

    /// A direction, and where there is one.
    #[inline(never)]
    pub fn disney_sample(
        &self,
        lobe: DisneyLobe,
        wo: Vec3fx8<S>,
        [u, v]: [f32x8<S>; 2],
    ) -> (Vec3fx8<S>, mask32x8<S>) {
        vectorized!(wo.x.token(), {
            let scatters = lobe.scatters(wo.z);
            let (wi, is_valid) = match lobe {
                DisneyLobe::Diffuse { .. } => (cosine_direction(wo.z, [u, v]), scatters),
                DisneyLobe::Clearcoat { .. } => {
                    let squared = self.roughness[0] * self.roughness[0];
                    let sin2 = (exp_minus(-ln(squared) * (1.0 - u)) - squared) / (1.0 - squared);
                    let sin2 = sin2.max(0.0).min(1.0);
                    let ([cos, sin], radius) = (at_turn(v), sin2.sqrt());
                    let wh = V3 { x: cos * radius, y: sin * radius, z: (1.0 - sin2).sqrt().copysign(wo.z) };
                    reflected(wo, wh)
                }
                DisneyLobe::Transmission => refracted(self.eta, wo, self.facets().visible_normal(wo, [u, v])),
                DisneyLobe::ThinTransmission => {
                    let (wi, is_valid) = self.facets().reflected(wo, [u, v]);
                    (mirrored(wi), is_valid)
                }
            };
            (wi, is_valid & scatters)
        })
    }
}

impl DisneyLobe {
    /// Where it scatters light towards directions of these cosines.
    #[inline(always)]
    fn scatters<S: Simd>(self, cos_o: f32x8<S>) -> mask32x8<S> {
        let all = mask32x8::splat(cos_o.token(), true);
        match self {
            DisneyLobe::Diffuse { outside: true } | DisneyLobe::Clearcoat { outside: true } => {
                cos_o.simd_gt(0.0)
            }
            _ => all,
        }
    }
}

/// Smith's fraction of visible facets, by twice the cosine.
#[inline(always)]
fn clearcoat_masking<S: Simd>(cos: f32x8<S>) -> f32x8<S> {
    const SQUARED: f32 = CLEARCOAT_MASKING * CLEARCOAT_MASKING;
    let cos = cos.abs();
    1.0 / (cos + (SQUARED + (1.0 - SQUARED) * cos * cos).sqrt())
}

/// The direction on the other side of the surface.
#[inline(always)]
fn mirrored<S: Simd>(w: Vec3fx8<S>) -> Vec3fx8<S> {
    V3 { z: -w.z, ..w }
}
