//! `Shape "cone"`.

use super::limits::Limits;
use crate::params::Params;

/// A cone around the z axis, open at its base in the plane z = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// The radius of the base, above 0 (`radius`, default 1).
    pub radius: f64,
    /// The z of the apex, above 0 (`height`, default 1).
    pub height: f64,
}

pub(super) fn cone(params: &mut Params, limits: &Limits) -> Cone {
    Cone {
        radius: limits.length(params, "radius", 1.0, "the radius of a cone"),
        height: limits.length(params, "height", 1.0, "the height of a cone"),
    }
}
