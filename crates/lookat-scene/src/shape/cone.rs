//! `Shape "cone"`.

use super::limits::{Limits, PHI_MAX, radius};
use crate::params::Params;
use crate::schema::{Key, Kind, Range, Unit};

/// A cone around the z axis, open at its base in the plane z = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// The radius of the base, above 0 (`radius`, default 1).
    pub radius: f64,
    /// The z of the apex, above 0 (`height`, default 1).
    pub height: f64,
}

const RADIUS: Key<f64> = radius("the radius of the open base at z = 0");
const HEIGHT: Key<f64> =
    Key::float("height", 1.0, "the z of the tip").within(Range::above(0.0)).unit(Unit::ObjectSpace);

pub(super) const KIND: Kind = Kind::new(
    "Shape",
    "cone",
    "a cone around the z axis, open at its base",
    &[&[&RADIUS, &HEIGHT, &PHI_MAX]],
);

pub(super) fn cone(params: &mut Params, limits: &Limits) -> Cone {
    Cone { radius: limits.length(params, &RADIUS), height: limits.length(params, &HEIGHT) }
}
