//! Lights as they are seen from points side by side.

pub(super) mod plain;
pub(super) mod sample;

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};
use glam::Vec3;

pub(crate) use self::plain::PlainLight;
pub(crate) use self::sample::LightSamples;
use super::surface::lanes::Lamp;
use super::{LightTable, SceneLight};
use crate::lanes::{Colors, to_f32};
use crate::surface::lanes::Surfaces;

/// A light that is sampled side by side.
pub(crate) enum SampledLight<'s> {
    Plain(PlainLight),
    Lamp(Lamp<'s>),
    /// One that is asked one by one.
    Other,
}

impl LightTable {
    /// All lights.
    pub fn sampled_lights(&self) -> Vec<SampledLight<'_>> {
        self.lights.iter().map(|light| self.as_sampled(light)).collect()
    }

    fn as_sampled<'s>(&'s self, light: &'s SceneLight) -> SampledLight<'s> {
        match light {
            SceneLight::Surface(surface) => surface
                .lamp(self.primitive(surface), self.origin, self.labels)
                .map_or(SampledLight::Other, SampledLight::Lamp),
            _ => light.as_plain().map_or(SampledLight::Other, SampledLight::Plain),
        }
    }
}

/// As [`LightTable::weight`], of skies and of other lights.
#[inline(always)]
pub(crate) fn weights<S: Simd>(is_sky: mask64x8<S>, a: f64x8<S>, b: f64x8<S>) -> f32x8<S> {
    let ratio = b / a;
    to_f32(1.0 / (1.0 + is_sky.select(ratio, ratio * ratio)))
}

impl SampledLight<'_> {
    /// As [`LightTable::sample`], to the bit, but where it is open.
    #[inline(always)]
    pub fn samples<S: Simd>(&self, simd: S, from: &Surfaces<S>, u: [f64x8<S>; 2]) -> LightSamples<S> {
        match self {
            SampledLight::Plain(light) => light.samples(simd, from),
            SampledLight::Lamp(lamp) => lamp.samples(simd, from, u),
            SampledLight::Other => {
                let no = mask64x8::splat(simd, false);
                LightSamples {
                    is_there: no,
                    li: Colors::splat(simd, Vec3::ZERO),
                    pdf: 1.0.simd_into(simd),
                    has_pdf: no,
                    // Of no direction.
                    shadow: from.leave(from.n),
                    is_open: !no,
                }
            }
        }
    }
}
