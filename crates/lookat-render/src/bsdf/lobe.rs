//! One way of scattering light. Directions are in the shading frame, where z is the shading normal, and point away from
//! the surface.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::{DVec2, DVec3, Vec3};

use super::fresnel::{Fresnel, dielectric};
use super::microfacet::TrowbridgeReitz;
use crate::warp::{square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf};

/// A way of scattering light. Reflectances and transmittances are factors of at least 0, most at most 1.
#[derive(Debug, Clone, Copy)]
pub(super) enum Lobe {
    /// PBR 8.3.
    Lambert { reflectance: Vec3 },
    /// PBR 8.3: to the other side.
    LambertTransmission { transmittance: Vec3 },
    /// PBR 8.4.1.
    OrenNayar { reflectance: Vec3, a: f64, b: f64 },
    /// Torrance and Sparrow's model (PBR 8.4.4).
    Microfacet { reflectance: Vec3, facets: TrowbridgeReitz, fresnel: Fresnel },
    /// Walter et al.'s model of rough refraction (PBR 8.4.4). `eta`: index behind the surface by that before it.
    MicrofacetTransmission { transmittance: Vec3, facets: TrowbridgeReitz, eta: f64 },
    /// Ashikhmin and Shirley's model (PBR 8.5), times `weight`.
    Substrate { weight: Vec3, diffuse: Vec3, specular: Vec3, facets: TrowbridgeReitz },
    /// PBR 8.2.2.
    Mirror { reflectance: Vec3, fresnel: Fresnel },
    /// PBR 8.2.3.
    Refraction { transmittance: Vec3, eta: f64 },
    /// Reflection and refraction in one, chosen as Fresnel's equations say (PBR 8.2.3, FresnelSpecular).
    Glass { reflectance: Vec3, transmittance: Vec3, eta: f64 },
}

/// A direction of a lobe that has only single ones.
#[derive(Debug, Clone, Copy)]
pub(super) struct Single {
    pub wi: DVec3,
    /// Radiance from `wi` times this comes along `wo`.
    pub factor: Vec3,
    /// The probability of this direction among those of the lobe.
    pub probability: f64,
    /// What refraction alone does to radiance: the ratio of the squared indices, or 1.
    pub compression: f32,
}

impl Lobe {
    /// Whether it has only single directions.
    #[inline]
    pub fn is_specular(&self) -> bool {
        matches!(self, Lobe::Mirror { .. } | Lobe::Refraction { .. } | Lobe::Glass { .. })
    }

    /// Whether it scatters to the other side.
    #[inline]
    pub fn transmits(&self) -> bool {
        matches!(self, Lobe::LambertTransmission { .. } | Lobe::MicrofacetTransmission { .. })
    }

    /// About what it scatters, in all, of light that comes along `wo`: exact where it does not depend on roughness.
    pub fn albedo(&self, wo: DVec3) -> Vec3 {
        let share = |eta| dielectric(wo.z, eta) as f32;
        match *self {
            Lobe::Lambert { reflectance } | Lobe::OrenNayar { reflectance, .. } => reflectance,
            Lobe::LambertTransmission { transmittance } => transmittance,
            Lobe::Microfacet { reflectance, fresnel, .. } | Lobe::Mirror { reflectance, fresnel } => {
                reflectance * fresnel.reflected(wo.z)
            }
            Lobe::MicrofacetTransmission { transmittance, eta, .. }
            | Lobe::Refraction { transmittance, eta } => transmittance * (1.0 - share(eta)),
            Lobe::Substrate { weight, diffuse, specular, .. } => {
                weight * (diffuse * (Vec3::ONE - specular) + schlick(specular, wo.z.abs()))
            }
            Lobe::Glass { reflectance, transmittance, eta } => {
                reflectance * share(eta) + transmittance * (1.0 - share(eta))
            }
        }
    }

    /// The value of the BSDF; 0 for single directions.
    #[inline]
    pub fn f(&self, wo: DVec3, wi: DVec3) -> Vec3 {
        match *self {
            Lobe::Lambert { reflectance } => reflectance * FRAC_1_PI as f32,
            Lobe::LambertTransmission { transmittance } => transmittance * FRAC_1_PI as f32,
            Lobe::OrenNayar { reflectance, a, b } => {
                reflectance * (FRAC_1_PI * (a + b * oren_nayar(wo, wi))) as f32
            }
            Lobe::Microfacet { reflectance, facets, fresnel } => {
                reflectance * microfacet(&facets, &fresnel, wo, wi)
            }
            Lobe::MicrofacetTransmission { transmittance, facets, eta } => {
                transmittance * microfacet_transmission(&facets, eta, wo, wi)
            }
            Lobe::Substrate { weight, diffuse, specular, facets } => {
                weight * substrate(diffuse, specular, &facets, wo, wi)
            }
            Lobe::Mirror { .. } | Lobe::Refraction { .. } | Lobe::Glass { .. } => Vec3::ZERO,
        }
    }

    /// Density by solid angle of [`Lobe::sample`]; 0 for single directions.
    #[inline]
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let same_side = wo.z * wi.z > 0.0;
        match self {
            Lobe::Lambert { .. } | Lobe::OrenNayar { .. } if same_side => cosine_pdf(wi),
            Lobe::LambertTransmission { .. } if !same_side => cosine_pdf(wi),
            Lobe::Microfacet { facets, .. } if same_side => reflected_pdf(facets, wo, wi),
            Lobe::Substrate { facets, .. } if same_side => {
                0.5 * (cosine_pdf(wi) + reflected_pdf(facets, wo, wi))
            }
            Lobe::MicrofacetTransmission { facets, eta, .. } if !same_side => {
                refracted_pdf(facets, *eta, wo, wi)
            }
            _ => 0.0,
        }
    }

    /// A direction; `None` where there is none, and for single directions.
    #[inline]
    pub fn sample(&self, wo: DVec3, u: DVec2) -> Option<DVec3> {
        match self {
            Lobe::Lambert { .. } | Lobe::OrenNayar { .. } => Some(cosine(wo.z, u)),
            Lobe::LambertTransmission { .. } => Some(cosine(-wo.z, u)),
            Lobe::Microfacet { facets, .. } => reflected(facets, wo, u),
            Lobe::Substrate { facets, .. } if u.x >= 0.5 => {
                reflected(facets, wo, DVec2::new(2.0 * u.x - 1.0, u.y))
            }
            Lobe::Substrate { .. } => Some(cosine(wo.z, DVec2::new(2.0 * u.x, u.y))),
            Lobe::MicrofacetTransmission { facets, eta, .. } => {
                let (wi, _) = refract(wo, facets.sample(wo, u), *eta)?;
                (wo.z * wi.z < 0.0).then_some(wi)
            }
            Lobe::Mirror { .. } | Lobe::Refraction { .. } | Lobe::Glass { .. } => None,
        }
    }

    /// What refraction alone does to radiance on the way from `wi` to `wo`.
    pub fn compression(&self, wo: DVec3, wi: DVec3) -> f32 {
        match self {
            Lobe::MicrofacetTransmission { eta, .. } if wo.z * wi.z < 0.0 => ratio(wo, *eta).powi(-2) as f32,
            _ => 1.0,
        }
    }

    /// One of the single directions; `None` where there is none.
    pub fn single(&self, wo: DVec3, u: f64) -> Option<Single> {
        let mirrored = |factor, probability| Single {
            wi: DVec3::new(-wo.x, -wo.y, wo.z),
            factor,
            probability,
            compression: 1.0,
        };
        match *self {
            Lobe::Mirror { reflectance, fresnel } => {
                Some(mirrored(reflectance * fresnel.reflected(wo.z), 1.0))
            }
            Lobe::Refraction { transmittance, eta } => {
                let share = 1.0 - dielectric(wo.z, eta);
                refracted(wo, eta, transmittance * share as f32, 1.0)
            }
            Lobe::Glass { reflectance, transmittance, eta } => {
                let share = dielectric(wo.z, eta);
                if u < share {
                    return Some(mirrored(reflectance * share as f32, share));
                }
                refracted(wo, eta, transmittance * (1.0 - share) as f32, 1.0 - share)
            }
            _ => None,
        }
    }
}

fn cosine_pdf(w: DVec3) -> f64 {
    square_to_cosine_hemisphere_pdf(w.z.abs())
}

fn cosine(side: f64, u: DVec2) -> DVec3 {
    let w = square_to_cosine_hemisphere(u);
    w.with_z(w.z.copysign(side))
}

/// The term of Oren and Nayar's model that depends on the directions.
fn oren_nayar(wo: DVec3, wi: DVec3) -> f64 {
    let (sin_i, sin_o) = (wi.truncate().length(), wo.truncate().length());
    let across = wi.truncate().dot(wo.truncate());
    let cos_phi = if sin_i * sin_o > 1e-8 { (across / (sin_i * sin_o)).max(0.0) } else { 0.0 };
    // The larger angle to the normal is alpha, the smaller one beta.
    let (sin_alpha, tan_beta) =
        if wi.z.abs() > wo.z.abs() { (sin_o, sin_i / wi.z.abs()) } else { (sin_i, sin_o / wo.z.abs()) };
    cos_phi * sin_alpha * tan_beta
}

/// Normals of facets are on the side of the surface's, so that light from within is told from light from outside.
fn upward(wh: DVec3) -> DVec3 {
    if wh.z < 0.0 { -wh } else { wh }
}

fn microfacet(facets: &TrowbridgeReitz, fresnel: &Fresnel, wo: DVec3, wi: DVec3) -> Vec3 {
    let Some(wh) = half(wo, wi) else { return Vec3::ZERO };
    let shape = facets.density(wh) * facets.masking_shadowing(wo, wi) / (4.0 * wi.z * wo.z).abs();
    fresnel.reflected(wi.dot(upward(wh))) * shape as f32
}

/// The normal that reflects one direction into the other; `None` where a direction is in the plane of the surface.
fn half(wo: DVec3, wi: DVec3) -> Option<DVec3> {
    if wo.z == 0.0 || wi.z == 0.0 { None } else { (wo + wi).try_normalize() }
}

fn reflected(facets: &TrowbridgeReitz, wo: DVec3, u: DVec2) -> Option<DVec3> {
    let wh = facets.sample(wo, u);
    let wi = wh * (2.0 * wo.dot(wh)) - wo;
    (wi.z * wo.z > 0.0).then_some(wi)
}

fn reflected_pdf(facets: &TrowbridgeReitz, wo: DVec3, wi: DVec3) -> f64 {
    half(wo, wi).map_or(0.0, |wh| facets.pdf(wo, wh) / (4.0 * wo.dot(wh).abs()))
}

/// The index on the side of `wi` by that on the side of `wo`.
fn ratio(wo: DVec3, eta: f64) -> f64 {
    if wo.z > 0.0 { eta } else { 1.0 / eta }
}

/// The direction that a boundary of normal `wh`, on the side of `wo`, refracts into, and the ratio of the indices there by
/// those here. `None` where all is reflected.
fn refract(wo: DVec3, wh: DVec3, eta: f64) -> Option<(DVec3, f64)> {
    let (ratio, cos) = (ratio(wo, eta), wo.dot(wh));
    let along = (wo - wh * cos) / -ratio;
    let squared = 1.0 - along.length_squared();
    (squared > 0.0 && cos > 0.0).then(|| ((along - wh * squared.sqrt()).normalize(), ratio))
}

/// Light that a smooth boundary refracts.
fn refracted(wo: DVec3, eta: f64, factor: Vec3, probability: f64) -> Option<Single> {
    let (wi, ratio) = refract(wo, DVec3::new(0.0, 0.0, wo.z.signum()), eta)?;
    let compression = (1.0 / (ratio * ratio)) as f32;
    Some(Single { wi, factor: factor * compression, probability, compression })
}

/// The normal of the facet that refracts `wo` into `wi`, upward, and the ratio of the indices; `None` where none does, or
/// where one direction sees it from behind (which pbrt-v3 counts, but never samples).
fn refracting(wo: DVec3, wi: DVec3, eta: f64) -> Option<(DVec3, f64)> {
    if wo.z * wi.z >= 0.0 {
        return None;
    }
    let ratio = ratio(wo, eta);
    let wh = upward((wo + wi * ratio).try_normalize()?);
    (wo.dot(wh) * wo.z > 0.0 && wi.dot(wh) * wi.z > 0.0).then_some((wh, ratio))
}

/// By how much solid angle around `wi` is larger than that of the normals, times the cosine between them.
fn spread(wo: DVec3, wi: DVec3, wh: DVec3, ratio: f64) -> f64 {
    let sum = wo.dot(wh) + ratio * wi.dot(wh);
    ratio * ratio * wi.dot(wh).abs() / (sum * sum)
}

fn microfacet_transmission(facets: &TrowbridgeReitz, eta: f64, wo: DVec3, wi: DVec3) -> f32 {
    let Some((wh, ratio)) = refracting(wo, wi, eta) else { return 0.0 };
    let shape = facets.density(wh) * facets.masking_shadowing(wo, wi) * spread(wo, wi, wh, ratio);
    let passes = 1.0 - dielectric(wo.dot(wh), eta);
    // Radiance is denser where the index is larger.
    (passes * shape * wo.dot(wh).abs() / (ratio * ratio * (wi.z * wo.z).abs())) as f32
}

fn refracted_pdf(facets: &TrowbridgeReitz, eta: f64, wo: DVec3, wi: DVec3) -> f64 {
    refracting(wo, wi, eta).map_or(0.0, |(wh, ratio)| facets.pdf(wo, wh) * spread(wo, wi, wh, ratio))
}

fn substrate(diffuse: Vec3, specular: Vec3, facets: &TrowbridgeReitz, wo: DVec3, wi: DVec3) -> Vec3 {
    let flat = |w: DVec3| 1.0 - (1.0 - 0.5 * w.z.abs()).powi(5);
    let base = diffuse * (Vec3::ONE - specular) * (28.0 / (23.0 * PI) * flat(wi) * flat(wo)) as f32;
    let Some(wh) = half(wo, wi) else { return Vec3::ZERO };
    let cos = wi.dot(wh);
    let shape = facets.density(wh) / (4.0 * cos.abs() * wi.z.abs().max(wo.z.abs()));
    base + schlick(specular, cos) * shape as f32
}

/// Schlick's approximation of what is reflected, of light at an angle of cosine `cos` to the normal.
fn schlick(specular: Vec3, cos: f64) -> Vec3 {
    specular + (Vec3::ONE - specular) * (1.0 - cos).powi(5) as f32
}
