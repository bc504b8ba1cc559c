//! `Shape "paraboloid"`.

use super::limits::{Limits, PHI_MAX, given, radius, z_max, z_min};
use crate::params::Params;
use crate::schema::{Key, Kind};

/// A paraboloid around the z axis with its vertex at the origin, open at the top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Paraboloid {
    /// The radius at `z_max`, above 0 (`radius`, default 1).
    pub radius: f64,
    /// The lowest z, with texture coordinate v = 0, at least 0 (`zmin`, default 0).
    pub z_min: f64,
    /// The highest z, above 0 and above `z_min` (`zmax`, default 1).
    pub z_max: f64,
}

impl Paraboloid {
    /// True if it is neither too flat nor too narrow.
    pub(crate) fn is_curved(&self) -> bool {
        (1e-100..=1e100).contains(&(self.z_max / self.radius / self.radius))
    }
}

const RADIUS: Key<f64> = radius("the radius at zmax");
const Z_MIN: Key<f64> = z_min(0.0);
const Z_MAX: Key<f64> = z_max(1.0);

pub(super) const KIND: Kind = Kind::new(
    "Shape",
    "paraboloid",
    "a paraboloid around the z axis with its vertex at the origin, open at the top",
    &[&[&RADIUS, &Z_MIN, &Z_MAX, &PHI_MAX]],
);

pub(super) fn paraboloid(params: &mut Params, limits: &Limits) -> Paraboloid {
    let radius = limits.length(params, &RADIUS);
    let [z_min, z_max] = limits.heights(params, [Z_MIN, Z_MAX]);
    if z_min < z_max && z_max <= 0.0 {
        let help = "its vertex is at z = 0 and it opens upward: to turn it over, use Scale 1 1 -1";
        params.reject(given(params), "the paraboloid is empty between zmin and zmax", Some(help));
    }
    let paraboloid = Paraboloid { radius, z_min, z_max };
    if z_max > 0.0 && !paraboloid.is_curved() {
        params.reject(given(params), "the paraboloid is too flat or too narrow", None);
    }
    paraboloid
}
