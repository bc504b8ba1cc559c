//! `Shape "disk"`.

use super::limits::{Limits, PHI_MAX, radius};
use crate::params::Params;
use crate::schema::{Key, Kind, Range, Unit};

/// A disk or ring perpendicular to the z axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disk {
    /// Its z (`height`, default 0).
    pub height: f64,
    /// The outer radius, above `inner_radius` (`radius`, default 1).
    pub radius: f64,
    /// The radius of the hole, at least 0 (`innerradius`, default 0).
    pub inner_radius: f64,
}

const HEIGHT: Key<f64> = Key::float("height", 0.0, "the z of the disk").unit(Unit::ObjectSpace);
const RADIUS: Key<f64> = radius("the outer radius");
const INNER_RADIUS: Key<f64> = Key::float("innerradius", 0.0, "the radius of the hole, less than radius")
    .within(Range::at_least(0.0))
    .unit(Unit::ObjectSpace);

pub(super) const KIND: Kind = Kind::new(
    "Shape",
    "disk",
    "a disk or ring perpendicular to the z axis",
    &[&[&HEIGHT, &RADIUS, &INNER_RADIUS, &PHI_MAX]],
);

pub(super) fn disk(params: &mut Params, limits: &Limits) -> Disk {
    let height = params.take(&HEIGHT);
    limits.check(params, "height", &[height]);
    let radius = limits.length(params, &RADIUS);
    let inner_radius = params.take(&INNER_RADIUS);
    if params.usable() && inner_radius >= radius {
        let message = format!("the disk is empty: innerradius {inner_radius} is not below radius {radius}");
        params.reject("innerradius", message, None);
    }
    Disk { height, radius, inner_radius }
}
