//! `Shape "disk"`.

use super::limits::Limits;
use crate::params::Params;

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

pub(super) fn disk(params: &mut Params, limits: &Limits) -> Disk {
    let height = params.float("height", 0.0);
    limits.check(params, "height", &[height]);
    let radius = limits.length(params, "radius", 1.0, "the radius of a disk");
    let inner_radius = params.float("innerradius", 0.0);
    if inner_radius < 0.0 {
        params.reject("innerradius", "innerradius must be at least 0", None);
    } else if radius > 0.0 && inner_radius >= radius {
        let message = format!("the disk is empty: innerradius {inner_radius} is not below radius {radius}");
        params.reject("innerradius", message, None);
    }
    Disk { height, radius, inner_radius }
}
