//! Whole spheres, sampled by the solid angle at which points see them (PBR 14.2.2).

use std::f64::consts::TAU;

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};

use crate::frame::Frames;
use crate::light::{LightSample, Receivers};
use crate::number::{V3, Vec2x8, Vec3fx8, Vec3x8, to_f32};
use crate::trace::rays::Rays;
use crate::warp::at_turn;

/// From so many radii on a point is outside of a sphere, in spite of rounding.
pub(super) const OUTSIDE: f64 = 1.0 + 1e-9;

/// Whole spheres, one for each point.
pub(super) struct Spheres<S: Simd> {
    pub center: Vec3x8<S>,
    pub radius: f64x8<S>,
    pub magnitude: f64x8<S>,
    pub label: f64x8<S>,
    pub radiance: Vec3fx8<S>,
    /// The points that emit outwards.
    pub shines: mask64x8<S>,
}

impl<S: Simd> Spheres<S> {
    /// Directions in which they are seen from outside, and from where they are.
    #[inline(always)]
    pub fn sample(&self, at: &Receivers<S>, [u, v]: Vec2x8<S>) -> (LightSample<S>, mask64x8<S>) {
        let radius = self.radius;
        let to_center = self.center - at.surfaces.p;
        let distance = to_center.length_squared().sqrt();
        let sine = radius / distance;
        // One minus the cosine of half the angle at which the sphere is seen, without cancellation.
        let one_minus_cos_max = sine * sine / (1.0 + (1.0 - sine * sine).max(0.0).sqrt());
        let one_minus_cos = u * one_minus_cos_max;
        let sin_squared = one_minus_cos * (2.0 - one_minus_cos);
        let sin = sin_squared.max(0.0).sqrt();
        let [x, y] = at_turn(v);
        let local = V3 { x: x * sin, y: y * sin, z: 1.0 - one_minus_cos };
        let wi = Frames::from_z(to_center * (1.0 / distance)).to_world(local);
        // By the law of sines.
        let half = (radius * radius - distance * distance * sin_squared).max(0.0).sqrt();
        let t_max = at.surfaces.reach(distance * local.z - half, self.magnitude);
        let shadow = Rays { t_max, target: self.label, ..at.surfaces.spawn_ray(wi) };
        let is_outside = distance.simd_gt(radius * OUTSIDE);
        let pdf = to_f32(1.0 / (one_minus_cos_max * TAU));
        let sample = LightSample::with_pdf(is_outside & self.shines, self.radiance, pdf, shadow);
        (sample, is_outside)
    }
}
