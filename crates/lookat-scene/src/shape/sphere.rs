//! `Shape "sphere"`.

use super::limits::{Limits, given};
use crate::params::Params;

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

pub(super) fn sphere(params: &mut Params, limits: &Limits) -> Sphere {
    let radius = limits.length(params, "radius", 1.0, "the radius of a sphere");
    if !params.usable() {
        // The heights depend on the radius. Take them, so that they are not reported as unknown.
        let (z_min, z_max) = (params.float("zmin", 0.0), params.float("zmax", 0.0));
        return Sphere { radius, z_min, z_max };
    }
    let [z_min, z_max] = limits.heights(params, [-radius, radius]);
    if z_min < z_max && (z_min >= radius || z_max <= -radius) {
        params.reject(given(params), "the sphere is empty between zmin and zmax", None);
    }
    Sphere { radius, z_min: z_min.max(-radius), z_max: z_max.min(radius) }
}
