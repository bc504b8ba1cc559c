//! Common checks of curved shapes. They report invalid values; the value returned then has no meaning.

use std::ops::RangeInclusive;

use glam::DMat3;

use crate::Transform;
use crate::params::Params;
use crate::schema::{Key, Range, Unit};
use crate::transform::LARGEST;

pub(super) const fn radius(meaning: &'static str) -> Key<f64> {
    Key::float("radius", 1.0, meaning).within(Range::above(0.0)).unit(Unit::ObjectSpace)
}

pub(super) const fn z_min(default: f64) -> Key<f64> {
    Key::float("zmin", default, "the lowest z; zmin and zmax may be swapped").unit(Unit::ObjectSpace)
}

pub(super) const fn z_max(default: f64) -> Key<f64> {
    Key::float("zmax", default, "the highest z, different from zmin").unit(Unit::ObjectSpace)
}

pub(super) const PHI_MAX: Key<f64> =
    Key::float("phimax", 360.0, "the angle of the sweep around the z axis; over 360 counts as 360")
        .within(Range::above(0.0))
        .unit(Unit::Degrees);

/// The valid lengths of a shape under its transformation.
pub(crate) struct Limits {
    largest: f64,
}

impl Limits {
    pub fn new(world_from_object: &Transform) -> Self {
        let linear = DMat3::from_mat4(world_from_object.matrix()).to_cols_array();
        Limits { largest: LARGEST / linear.iter().fold(1.0_f64, |max, x| max.max(x.abs())) }
    }

    /// The valid lengths.
    pub fn lengths(&self) -> RangeInclusive<f64> {
        LARGEST.recip()..=self.largest
    }

    /// True if no coordinate is too large.
    pub fn contain(&self, coordinates: &[f64]) -> bool {
        coordinates.iter().all(|x| x.abs() <= self.largest)
    }

    /// A length above 0.
    pub fn length(&self, params: &mut Params, key: &Key<f64>) -> f64 {
        let length = params.take(key);
        let (least, largest) = self.lengths().into_inner();
        if !self.lengths().contains(&length) {
            let range = format!("from {least:.1e} to {largest:.1e} under this transformation");
            params.reject(key.name, format!("{} must be {range}", key.name), None);
        }
        length
    }

    /// Rejects a parameter with a coordinate that is too large under this transformation.
    pub fn check(&self, params: &mut Params, name: &str, coordinates: &[f64]) {
        if !self.contain(coordinates) {
            params.reject(
                name,
                format!("{name} must be at most {:.1e} under this transformation", self.largest),
                None,
            );
        }
    }

    /// `zmin` and `zmax` in ascending order, as in pbrt-v3. Equal values are an error.
    pub fn heights(&self, params: &mut Params, keys: [Key<f64>; 2]) -> [f64; 2] {
        let [z0, z1] = keys.map(|key| params.take(&key));
        self.check(params, "zmin", &[z0]);
        self.check(params, "zmax", &[z1]);
        if z0 == z1 {
            params.reject(
                given(params),
                format!("the shape is empty: zmin {z0} is not below zmax {z1}"),
                None,
            );
        }
        [z0.min(z1), z0.max(z1)]
    }
}

/// The parameter to underline: `zmin` or `zmax`, preferably one that is given.
pub(super) fn given(params: &Params) -> &'static str {
    if params.was_taken("zmin") { "zmin" } else { "zmax" }
}

/// `phimax`, in radians.
pub(super) fn sweep(params: &mut Params) -> f64 {
    let phi_max = params.take(&PHI_MAX);
    if phi_max > 360.0 {
        params.note("phimax", "phimax above 360 degrees is used as 360, as in pbrt-v3", "360 is a full turn");
    }
    phi_max.min(360.0).to_radians()
}
