//! `Shape "hyperboloid"`.

use glam::{DVec2, DVec3};

use super::limits::{Limits, PHI_MAX};
use crate::params::Params;
use crate::schema::{Key, Kind, Unit};

/// A line segment rotated about the z axis. If both ends have the same angle about the axis, it is a cone or a part
/// of one. If it is parallel to the axis, it is a cylinder.
///
/// pbrt-v3 renders another surface unless the waist, the point of the line closest to the axis, is at z = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hyperboloid {
    /// The end with texture coordinate v = 0 (`p1`, default 0 0 0).
    pub p1: DVec3,
    /// The end with v = 1. Its z is not 0 and differs from the z of `p1` (`p2`, default 1 1 1).
    pub p2: DVec3,
}

const P1: Key<[f64; 3]> =
    Key::point("p1", [0.0; 3], "one end of the segment, with v = 0").unit(Unit::ObjectSpace);
const P2: Key<[f64; 3]> =
    Key::point("p2", [1.0; 3], "the other end, with v = 1, at another z").unit(Unit::ObjectSpace);

pub(super) const KIND: Kind =
    Kind::new("Shape", "hyperboloid", "a line segment rotated about the z axis", &[&[&P1, &P2, &PHI_MAX]]);

pub(super) fn hyperboloid(params: &mut Params, limits: &Limits) -> Hyperboloid {
    let (p1, p2) = (params.take(&P1), params.take(&P2));
    limits.check(params, "p1", &p1.to_array());
    limits.check(params, "p2", &p2.to_array());
    let given = if params.was_taken("p2") { "p2" } else { "p1" };
    if p1.z == p2.z {
        let help = "for a flat ring, use Shape \"disk\" with \"float innerradius\"";
        params.reject(given, "p1 and p2 of a hyperboloid must have different z", Some(help));
    } else if p1.truncate() == DVec2::ZERO && p2.truncate() == DVec2::ZERO {
        params.reject(given, "p1 and p2 of a hyperboloid must not both lie on its axis", None);
    }
    if params.usable() && !has_waist_at_zero(p1, p2) {
        let message = "pbrt-v3 renders this hyperboloid as another surface that misses p1 (a known defect)";
        let help =
            "lookat rotates the segment from p1 to p2; the two programs agree if the waist is at z = 0";
        params.warn(given, message, help);
    }
    // The order determines the outer side and the direction of v.
    if p2.z == 0.0 { Hyperboloid { p1: p2, p2: p1 } } else { Hyperboloid { p1, p2 } }
}

/// True if the point of the line closest to the axis is at z = 0.
fn has_waist_at_zero(p1: DVec3, p2: DVec3) -> bool {
    let along = p2 - p1;
    let at_zero = p1 - along * (p1.z / along.z);
    let [p, d] = [at_zero, along].map(DVec3::truncate);
    p.dot(d).abs() <= 1e-6 * p.length() * d.length()
}
