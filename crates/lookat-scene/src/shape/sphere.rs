//! `Shape "sphere"`.

use super::limits::{Limits, PHI_MAX, given, radius, z_max, z_min};
use crate::params::Params;
use crate::schema::{Key, Kind};

/// A sphere around the origin, clipped in z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// The radius, above 0 (`radius`, default 1).
    pub radius: f64,
    /// The lowest z, at least -radius (`zmin`, default -radius).
    pub z_min: f64,
    /// The highest z, at most radius, above `z_min` (`zmax`, default radius).
    pub z_max: f64,
}

const RADIUS: Key<f64> = radius("the radius of the sphere");
const Z_MIN: Key<f64> = z_min(-1.0).default_words("-radius");
const Z_MAX: Key<f64> = z_max(1.0).default_words("radius");

pub(super) const KIND: Kind = Kind::new(
    "Shape",
    "sphere",
    "a sphere around the origin, clipped in z",
    &[&[&RADIUS, &Z_MIN, &Z_MAX, &PHI_MAX]],
);

pub(super) fn sphere(params: &mut Params, limits: &Limits) -> Sphere {
    let radius = limits.length(params, &RADIUS);
    if !params.usable() {
        // The heights depend on the radius. Take them, so that they are not reported as unknown.
        let (z_min, z_max) = (params.take(&Z_MIN), params.take(&Z_MAX));
        return Sphere { radius, z_min, z_max };
    }
    let [z_min, z_max] =
        limits.heights(params, [Key { default: -radius, ..Z_MIN }, Key { default: radius, ..Z_MAX }]);
    if z_min < z_max && (z_min >= radius || z_max <= -radius) {
        params.reject(given(params), "the sphere is empty between zmin and zmax", None);
    }
    Sphere { radius, z_min: z_min.max(-radius), z_max: z_max.min(radius) }
}
