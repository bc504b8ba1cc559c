//! `Shape "cylinder"`.

use super::limits::Limits;
use crate::params::Params;

/// A cylinder around the z axis, open at both ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    /// The radius, above 0 (`radius`, default 1).
    pub radius: f64,
    /// Lowest z (`zmin`, default -1).
    pub z_min: f64,
    /// Highest z, above `z_min` (`zmax`, default 1).
    pub z_max: f64,
}

pub(super) fn cylinder(params: &mut Params, limits: &Limits) -> Cylinder {
    let radius = limits.length(params, "radius", 1.0, "the radius of a cylinder");
    let [z_min, z_max] = limits.heights(params, [-1.0, 1.0]);
    Cylinder { radius, z_min, z_max }
}
