//! Lights that are points or directions, as they are seen from points side by side.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::{DMat3, DVec3, Vec3};

use super::sample::LightSamples;
use crate::lanes::{Colors, Vec3x8, to_f32};
use crate::light::SceneLight;
use crate::surface::lanes::Surfaces;
use crate::trace::lanes::{POINT_LIGHT, Rays};

/// A light that is a point or a direction.
#[derive(Debug, Clone, Copy)]
pub(crate) enum PlainLight {
    Distant { direction: DVec3, radiance: Vec3 },
    Point { position: DVec3, intensity: Vec3, cone: Option<Cone> },
}

/// That of a spot.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cone {
    light_from_world: DMat3,
    cos_total_width: f64,
    cos_falloff_start: f64,
}

impl SceneLight {
    pub(super) fn as_plain(&self) -> Option<PlainLight> {
        match *self {
            SceneLight::Distant { direction, radiance } => Some(PlainLight::Distant { direction, radiance }),
            SceneLight::Point { position, intensity } => {
                Some(PlainLight::Point { position, intensity, cone: None })
            }
            SceneLight::Spot {
                position,
                light_from_world,
                intensity,
                cos_total_width,
                cos_falloff_start,
            } => {
                let cone = Some(Cone { light_from_world, cos_total_width, cos_falloff_start });
                Some(PlainLight::Point { position, intensity, cone })
            }
            SceneLight::Infinite { .. }
            | SceneLight::Environment(_)
            | SceneLight::Goniometric(_)
            | SceneLight::Projection(_)
            | SceneLight::Surface(_) => None,
        }
    }
}

impl PlainLight {
    /// As [`crate::light::LightTable::sample`], to the bit.
    #[inline(always)]
    pub fn samples<S: Simd>(&self, simd: S, from: &Surfaces<S>) -> LightSamples<S> {
        match self {
            PlainLight::Distant { direction, radiance } => {
                let shadow = from.leave(Vec3x8::splat(simd, *direction));
                sample_of(mask64x8::splat(simd, true), Colors::splat(simd, *radiance), shadow)
            }
            PlainLight::Point { position, intensity, cone } => {
                let to_light = Vec3x8::splat(simd, *position) - from.p;
                let squared_distance = to_light.length_squared();
                let is_apart = squared_distance.simd_gt(0.0) & squared_distance.is_finite();
                let mut intensity = Colors::splat(simd, *intensity);
                if let Some(cone) = cone {
                    intensity = intensity * to_f32(cone.falloff(to_light.try_normalize().0));
                }
                let target = POINT_LIGHT.simd_into(simd);
                let shadow = Rays { target, ..from.towards(Vec3x8::splat(simd, *position)) };
                let li = intensity / to_f32(squared_distance);
                sample_of(is_apart & intensity.is_light(), li, shadow)
            }
        }
    }
}

/// Of a light that no other direction can hit.
#[inline(always)]
fn sample_of<S: Simd>(is_there: mask64x8<S>, li: Colors<S>, shadow: Rays<S>) -> LightSamples<S> {
    let simd = shadow.t_max.token();
    let no = mask64x8::splat(simd, false);
    LightSamples { is_there, li, pdf: 1.0.simd_into(simd), has_pdf: no, shadow, is_open: no }
}

impl Cone {
    /// What of the intensity goes to points from which the light is seen in directions `wi`; as [`crate::light::falloff`], to the
    /// bit.
    #[inline(always)]
    fn falloff<S: Simd>(&self, wi: Vec3x8<S>) -> f64x8<S> {
        let Cone { light_from_world, cos_total_width, cos_falloff_start } = self;
        let simd = wi.x.token();
        let cos_theta = (-wi).by(light_from_world).normalize_or(DVec3::ZERO).z;
        let within = (cos_theta - *cos_total_width) / (cos_falloff_start - cos_total_width);
        let squared = within * within;
        let (zero, one) = (0.0.simd_into(simd), 1.0.simd_into(simd));
        let inside = cos_theta.simd_ge(*cos_falloff_start).select(one, squared * squared);
        cos_theta.simd_lt(*cos_total_width).select(zero, inside)
    }
}
