//! `Shape "paraboloid"`.

use super::limits::{Limits, given};
use crate::params::Params;

/// A paraboloid around the z axis with its vertex at the origin, open at the top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Paraboloid {
    /// Radius at `z_max`, more than 0 (`radius`, default 1).
    pub radius: f64,
    /// Lowest z, where the texture coordinate v is 0; there is nothing below 0 (`zmin`, default 0).
    pub z_min: f64,
    /// Highest z, more than 0 and above `z_min` (`zmax`, default 1).
    pub z_max: f64,
}

pub(super) fn paraboloid(params: &mut Params, limits: &Limits) -> Paraboloid {
    let radius = limits.length(params, "radius", 1.0, "the radius of a paraboloid");
    let [z_min, z_max] = limits.heights(params, [0.0, 1.0]);
    if z_min < z_max && z_max <= 0.0 {
        let help = "its vertex is at z = 0 and it opens upward; to turn it round, use Scale 1 1 -1";
        params.reject(given(params), "nothing of the paraboloid lies between zmin and zmax", Some(help));
    } else if z_max > 0.0 {
        let curvature = z_max / radius / radius;
        if !(1e-100..=1e100).contains(&curvature) {
            params.reject(given(params), "the paraboloid is too flat or too narrow", None);
        }
    }
    Paraboloid { radius, z_min, z_max }
}
