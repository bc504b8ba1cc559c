//! Rays side by side against a sphere.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::DVec3;

use super::Sphere;
use crate::curved::{AT_ORIGIN, Curved};
use crate::number::Vec3x8;

/// Where rays may meet a sphere.
pub(crate) struct Meetings<S: Simd> {
    pub met: mask64x8<S>,
    pub t: f64x8<S>,
    /// Where the sphere has to be asked ray by ray.
    pub doubtful: mask64x8<S>,
}

impl Sphere {
    /// As [`Sphere::intersect`], to the bit, but where it is doubtful; of spheres that are not whole all hits are.
    #[inline(always)]
    pub fn meet<S: Simd>(
        &self,
        o: Vec3x8<S>,
        d: Vec3x8<S>,
        t_max: f64x8<S>,
        leaving: mask64x8<S>,
        active: mask64x8<S>,
    ) -> Meetings<S> {
        let radius = self.radius;
        let dd = d.length_squared();
        let k = -o.dot(d) / dd;
        let near = o + d * k;
        let correction = -near.dot(d) / dd;
        let near = near + d * correction;
        let distance = near.length_squared().sqrt();
        let squared = (radius - distance) * (radius + distance);
        let doubtful = (radius - distance).abs().simd_le(o.magnitude() * (8.0 * f64::EPSILON)) & active;
        let met = active & !squared.simd_lt(0.0);
        if !(met | doubtful).any_true() {
            return Meetings { met, t: k, doubtful };
        }
        if !self.is_whole() {
            return Meetings { met, t: k, doubtful: met | doubtful };
        }
        let half = (squared / dd).sqrt();
        let middle = k + correction;
        let (first, second) = (k + (correction - half), k + (correction + half));
        let is_first = first.simd_gt(0.0) & first.simd_le(t_max) & !leaving;
        let is_second = second.simd_gt(0.0) & second.simd_le(t_max) & !(leaving & middle.simd_le(0.0));
        let met = met & (is_first | is_second);
        let t = is_first.select(first, second);
        let is_at_origin = met & !leaving & (t * t * dd).simd_le(AT_ORIGIN * radius * radius);
        Meetings { met, t, doubtful: doubtful | is_at_origin }
    }
}

impl Curved {
    /// The points of a sphere nearest to some that are near it, and the normals there; as [`Curved::project`], to the bit.
    #[inline(always)]
    pub fn on_sphere<S: Simd>(&self, p: Vec3x8<S>) -> (Vec3x8<S>, Vec3x8<S>) {
        let simd = p.x.token();
        let radius: f64x8<S> = self.as_sphere().map_or(0.0, |sphere| sphere.radius).simd_into(simd);
        let center = Vec3x8::splat(simd, self.center);
        let own = (p - center).by(&self.own_from_world).normalize_or(DVec3::Z) * radius;
        let normal = own.by(&self.own_from_world.transpose());
        (center + own.by(&self.world_from_own), normal.normalize_or(DVec3::Z))
    }
}
