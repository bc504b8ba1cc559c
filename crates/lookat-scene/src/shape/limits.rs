//! Checks that curved shapes have in common. Values that fail are reported; what is returned then does not count.

use glam::DMat3;

use crate::Transform;
use crate::params::Params;
use crate::transform::LARGEST;

/// What the lengths of a shape may be in its place.
pub(super) struct Limits {
    largest: f64,
}

impl Limits {
    pub fn new(world_from_object: &Transform) -> Self {
        let linear = DMat3::from_mat4(world_from_object.m).to_cols_array();
        Limits { largest: LARGEST / linear.iter().fold(1.0_f64, |max, x| max.max(x.abs())) }
    }

    /// A length that must be more than 0. `what` is it in messages: "the radius of a sphere".
    pub fn length(&self, params: &mut Params, name: &'static str, default: f64, what: &str) -> f64 {
        let length = params.float(name, default);
        if length <= 0.0 {
            params.reject(name, format!("{what} must be more than 0"), None);
        } else if !(LARGEST.recip()..=self.largest).contains(&length) {
            let (least, largest) = (LARGEST.recip(), self.largest);
            params.reject(name, format!("{what} must be from {least:.1e} to {largest:.1e} here"), None);
        }
        length
    }

    /// Rejects a parameter with a coordinate too large for this place.
    pub fn check(&self, params: &mut Params, name: &str, coordinates: &[f64]) {
        if coordinates.iter().any(|x| x.abs() > self.largest) {
            params.reject(name, format!("{name} must be at most {:.1e} here", self.largest), None);
        }
    }

    /// `zmin` and `zmax` in order, as pbrt-v3 brings them. Equal ones leave nothing.
    pub fn heights(&self, params: &mut Params, default: [f64; 2]) -> [f64; 2] {
        let (z0, z1) = (params.float("zmin", default[0]), params.float("zmax", default[1]));
        self.check(params, "zmin", &[z0]);
        self.check(params, "zmax", &[z1]);
        if z0 == z1 {
            params.reject(given(params), format!("nothing lies between zmin {z0} and zmax {z1}"), None);
        }
        [z0.min(z1), z0.max(z1)]
    }
}

/// The one of `zmin` and `zmax` to underline: the one that is given, where only one is.
pub(super) fn given(params: &Params) -> &'static str {
    if params.was_taken("zmin") { "zmin" } else { "zmax" }
}

/// `phimax`, in radians.
pub(super) fn sweep(params: &mut Params) -> f64 {
    let phi_max = params.angle("phimax", 360.0);
    if phi_max <= 0.0 {
        params.reject("phimax", "phimax must be more than 0 degrees", None);
    } else if phi_max > 360.0 {
        params.note(
            "phimax",
            "phimax of more than 360 degrees counts as 360, as in pbrt-v3",
            "360 is all around",
        );
    }
    phi_max.min(360.0).to_radians()
}
