//! From points of surfaces to the two coordinates s and t of a texture (PBR 10.2).
//!
//! - `mapping`: `uv` (default), `spherical`, `cylindrical` or `planar`
//! - of `uv`: `uscale`, `vscale`, factors of the coordinates of the surface, default 1; `udelta`, `vdelta`, added to
//!   them, default 0
//! - of `planar`: `v1`, `v2`, directions in the world, default 1 0 0 and 0 1 0; `udelta`, `vdelta`, default 0
//!
//! The poles of `spherical` and the axis of `cylindrical` are the z axis of the space where the texture is defined.

use glam::{DVec2, DVec3};

use crate::params::Params;
use crate::transform::Transform;

/// How a texture lies on surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mapping {
    /// The coordinates of the surface, scaled and then moved.
    Uv {
        /// Factors (`uscale`, `vscale`).
        scale: DVec2,
        /// What is added (`udelta`, `vdelta`).
        offset: DVec2,
    },
    /// s: the angle from the z axis, over pi. t: the angle around it from the x axis, over 2 pi, 0..1.
    Spherical {
        /// To the space with that axis.
        texture_from_world: Transform,
    },
    /// s: the angle around the z axis from the negative x axis, over 2 pi, 0..1. t: the cosine of the angle from it.
    Cylindrical {
        /// To the space with that axis.
        texture_from_world: Transform,
    },
    /// The position in the world, measured along two directions.
    Planar {
        /// The directions, in the world (`v1`, `v2`).
        axes: [DVec3; 2],
        /// What is added (`udelta`, `vdelta`).
        offset: DVec2,
    },
}

const NAMES: &[&str] = &["uv", "spherical", "cylindrical", "planar"];

/// The parameters of all textures with two coordinates; to be called when the others are taken.
pub(super) fn mapping(params: &mut Params, world_from_texture: Transform) -> Mapping {
    let texture_from_world = world_from_texture.inverse();
    let name = params.choice("mapping", NAMES);
    if !params.usable() || params.may_lack("mapping") {
        // Which of the others belong to it is not known.
        params.ignore_rest();
    }
    match name {
        "spherical" => {
            idle(params, &["uscale", "vscale", "udelta", "vdelta"], "spherical");
            Mapping::Spherical { texture_from_world }
        }
        "cylindrical" => {
            idle(params, &["uscale", "vscale", "udelta", "vdelta"], "cylindrical");
            Mapping::Cylindrical { texture_from_world }
        }
        "planar" => {
            idle(params, &["uscale", "vscale"], "planar");
            let axes = [axis(params, "v1", DVec3::X), axis(params, "v2", DVec3::Y)];
            Mapping::Planar { axes, offset: offset(params) }
        }
        _ => Mapping::Uv { scale: pair(params, ["uscale", "vscale"], 1.0), offset: offset(params) },
    }
}

/// Warns about parameters that belong to other mappings.
fn idle(params: &mut Params, names: &[&'static str], mapping: &str) {
    for name in names.iter().filter(|name| params.given(name)).copied().collect::<Vec<_>>() {
        params.float(name, 0.0);
        let message = format!("{name} has no meaning for the mapping \"{mapping}\"; it is ignored");
        let help = "the current transformation, or v1 and v2 of \"planar\", scale such mappings";
        params.warn(name, &message, help);
    }
}

fn offset(params: &mut Params) -> DVec2 {
    pair(params, ["udelta", "vdelta"], 0.0)
}

fn pair(params: &mut Params, names: [&'static str; 2], default: f64) -> DVec2 {
    let pair = names.map(|name| {
        let value = params.float(name, default);
        params.check_range(name, &[value]);
        value
    });
    pair.into()
}

fn axis(params: &mut Params, name: &'static str, default: DVec3) -> DVec3 {
    let axis = params.vector(name, default);
    params.check_range(name, &axis.to_array());
    axis
}
