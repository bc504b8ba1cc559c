//! Lights as they are seen from points side by side.

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};
use glam::{DMat3, DVec3, Vec3};

use super::surface::lanes::Lamp;
use super::{LightSample, LightTable, SceneLight};
use crate::lanes::{Colors, Vec3x8, to_f32};
use crate::ray::ElementId;
use crate::surface::lanes::Surfaces;
use crate::trace::lanes::{NONE, Rays, label};

/// As [`super::LightSample`], where there is one.
pub(crate) struct LightSamples<S: Simd> {
    pub is_there: mask64x8<S>,
    pub li: Colors<S>,
    pub pdf: f64x8<S>,
    pub has_pdf: mask64x8<S>,
    pub shadow: Rays<S>,
    /// Where the light has to be asked one by one.
    pub is_open: mask64x8<S>,
}

impl<S: Simd> LightSamples<S> {
    /// These where `mask` says so, and the others elsewhere.
    #[inline(always)]
    pub fn or(self, mask: mask64x8<S>, others: Self) -> Self {
        LightSamples {
            is_there: mask & self.is_there | !mask & others.is_there,
            li: self.li.or(mask, others.li),
            pdf: mask.select(self.pdf, others.pdf),
            has_pdf: mask & self.has_pdf | !mask & others.has_pdf,
            shadow: self.shadow.or(mask, others.shadow),
            is_open: mask & self.is_open | !mask & others.is_open,
        }
    }

    /// Puts what one of them is in its place.
    pub fn put(&mut self, lane: usize, sample: Option<&LightSample>) {
        let simd = self.pdf.token();
        let lane_bit = mask64x8::from_bitmask(simd, 1 << lane);
        self.is_open &= !lane_bit;
        self.is_there &= !lane_bit;
        let Some(LightSample { li, pdf, shadow }) = sample else { return };
        self.is_there |= lane_bit;
        self.has_pdf = if pdf.is_some() { self.has_pdf | lane_bit } else { self.has_pdf & !lane_bit };
        self.pdf[lane] = pdf.unwrap_or(1.0);
        self.li.put(lane, *li);
        self.shadow.o.put(lane, shadow.o);
        self.shadow.d.put(lane, shadow.d);
        self.shadow.t_max[lane] = shadow.t_max;
        self.shadow.target[lane] = match shadow.target {
            ElementId::NONE => NONE,
            target => label(target),
        };
    }
}

/// A light that is sampled side by side.
pub(crate) enum SampledLight<'s> {
    Plain(PlainLight),
    Lamp(Lamp<'s>),
    /// One that is asked one by one.
    Other,
}

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

impl LightTable<'_> {
    /// All lights but skies that are everywhere alike; `None` where any is not plain.
    pub fn plain_lights(&self) -> Option<Vec<PlainLight>> {
        self.lights[..self.uneven].iter().map(SceneLight::as_plain).collect()
    }

    /// All lights but skies that are everywhere alike.
    pub fn sampled_lights(&self) -> Vec<SampledLight<'_>> {
        self.lights[..self.uneven].iter().map(|light| light.as_sampled(self.eye)).collect()
    }
}

/// As [`LightTable::weight`], of skies and of other lights.
#[inline(always)]
pub(crate) fn weights<S: Simd>(is_sky: mask64x8<S>, a: f64x8<S>, b: f64x8<S>) -> f32x8<S> {
    let ratio = b / a;
    to_f32(1.0 / (1.0 + is_sky.select(ratio, ratio * ratio)))
}

impl SceneLight<'_> {
    fn as_sampled(&self, eye: DVec3) -> SampledLight<'_> {
        match self {
            SceneLight::Surface(surface) => surface.lamp(eye).map_or(SampledLight::Other, SampledLight::Lamp),
            _ => self.as_plain().map_or(SampledLight::Other, SampledLight::Plain),
        }
    }

    fn as_plain(&self) -> Option<PlainLight> {
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

impl PlainLight {
    /// As [`LightTable::sample`], to the bit.
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
                let (wi, is_apart) = to_light.try_normalize();
                let mut intensity = Colors::splat(simd, *intensity);
                if let Some(cone) = cone {
                    intensity = intensity * to_f32(cone.falloff(wi));
                }
                let magnitude = position.abs().max_element().simd_into(simd);
                let t_max = from.reach(squared_distance.sqrt(), magnitude);
                let shadow = Rays { t_max, ..from.leave(wi) };
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
    /// What of the intensity goes to points from which the light is seen in directions `wi`; as [`super::falloff`], to the
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
