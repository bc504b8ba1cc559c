//! `Shape "cylinder"`.

use super::limits::{Limits, PHI_MAX, radius, z_max, z_min};
use crate::params::Params;
use crate::schema::{Key, Kind};

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

const RADIUS: Key<f64> = radius("the radius of the cylinder");
const Z_MIN: Key<f64> = z_min(-1.0);
const Z_MAX: Key<f64> = z_max(1.0);

pub(super) const KIND: Kind = Kind::new(
    "Shape",
    "cylinder",
    "a cylinder around the z axis, open at both ends",
    &[&[&RADIUS, &Z_MIN, &Z_MAX, &PHI_MAX]],
);

pub(super) fn cylinder(params: &mut Params, limits: &Limits) -> Cylinder {
    let radius = limits.length(params, &RADIUS);
    let [z_min, z_max] = limits.heights(params, [Z_MIN, Z_MAX]);
    Cylinder { radius, z_min, z_max }
}
