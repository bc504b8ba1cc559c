//! Lights that are points or directions, as they are seen from points side by side.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::{DVec3, Vec3};

use super::{LightTable, SceneLight};
use crate::lanes::{Colors, Vec3x8, to_f32};
use crate::surface::lanes::Surfaces;
use crate::trace::lanes::Rays;

/// As [`super::LightSample`], where there is one.
pub(crate) struct LightSamples<S: Simd> {
    pub is_there: mask64x8<S>,
    pub li: Colors<S>,
    pub shadow: Rays<S>,
}

impl LightTable<'_> {
    /// Whether [`LightTable::samples_of`] serves for all lights but skies that are everywhere alike, and there is no other.
    pub fn are_plain(&self) -> bool {
        self.lights.iter().all(|light| {
            matches!(
                light,
                SceneLight::Point { .. }
                    | SceneLight::Spot { .. }
                    | SceneLight::Distant { .. }
                    | SceneLight::Infinite { .. }
            )
        })
    }

    /// As [`LightTable::sample`], to the bit.
    #[inline(always)]
    pub fn samples_of<S: Simd>(&self, simd: S, light: usize, from: &Surfaces<S>) -> LightSamples<S> {
        let all = mask64x8::splat(simd, true);
        match &self.lights[light] {
            SceneLight::Distant { direction, radiance } => {
                let shadow = from.leave(Vec3x8::splat(simd, *direction));
                LightSamples { is_there: all, li: Colors::splat(simd, *radiance), shadow }
            }
            light => {
                let to_light = Vec3x8::splat(simd, light.position()) - from.p;
                let squared_distance = to_light.length_squared();
                let (wi, is_apart) = to_light.try_normalize();
                let intensity = light.intensities(wi);
                let t_max = from.reach(squared_distance.sqrt(), light.position().abs().max_element());
                let shadow = Rays { t_max, ..from.leave(wi) };
                let li = intensity / to_f32(squared_distance);
                LightSamples { is_there: is_apart & intensity.is_light(), li, shadow }
            }
        }
    }
}

impl SceneLight<'_> {
    /// Of a point or spot.
    fn position(&self) -> DVec3 {
        match self {
            SceneLight::Point { position, .. } | SceneLight::Spot { position, .. } => *position,
            _ => DVec3::ZERO,
        }
    }

    /// Those of a point or spot, seen in directions `wi`; as in [`SceneLight::seen_from`].
    #[inline(always)]
    fn intensities<S: Simd>(&self, wi: Vec3x8<S>) -> Colors<S> {
        let simd = wi.x.token();
        match self {
            SceneLight::Point { intensity, .. } => Colors::splat(simd, *intensity),
            SceneLight::Spot { light_from_world, intensity, cos_total_width, cos_falloff_start, .. } => {
                let cos_theta = (-wi).by(light_from_world).normalize_or(DVec3::ZERO).z;
                let factor = falloff(simd, cos_theta, *cos_total_width, *cos_falloff_start);
                Colors::splat(simd, *intensity) * to_f32(factor)
            }
            _ => Colors::splat(simd, Vec3::ZERO),
        }
    }
}

/// As [`super::falloff`], to the bit.
#[inline(always)]
fn falloff<S: Simd>(simd: S, cos_theta: f64x8<S>, cos_total_width: f64, cos_falloff_start: f64) -> f64x8<S> {
    let within = (cos_theta - cos_total_width) / (cos_falloff_start - cos_total_width);
    let squared = within * within;
    let (zero, one) = (0.0.simd_into(simd), 1.0.simd_into(simd));
    let inside = cos_theta.simd_ge(cos_falloff_start).select(one, squared * squared);
    cos_theta.simd_lt(cos_total_width).select(zero, inside)
}
