//! Mappings from surface points to the texture coordinates s and t (PBR 10.2).
//!
//! - `mapping`: `uv` (default), `spherical`, `cylindrical` or `planar`
//! - for `uv`: `uscale`, `vscale`, factors on the surface coordinates, default 1; `udelta`, `vdelta`, added to
//!   them, default 0
//! - for `planar`: `v1`, `v2`, world directions, default 1 0 0 and 0 1 0; `udelta`, `vdelta`, default 0
//!
//! The poles of `spherical` and the axis of `cylindrical` are the z axis of the space where the texture is defined.

use glam::{DVec2, DVec3};

use crate::params::Params;
use crate::transform::Transform;

/// A texture coordinate mapping.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mapping {
    /// The surface coordinates, scaled and then shifted.
    Uv {
        /// The factors (`uscale`, `vscale`).
        scale: DVec2,
        /// The offset (`udelta`, `vdelta`).
        offset: DVec2,
    },
    /// s is the angle from the z axis, divided by pi. t is the angle around the z axis from the x axis, divided by 2
    /// pi, from 0 to 1.
    Spherical {
        /// The transformation to the space of the z axis.
        texture_from_world: Transform,
    },
    /// s is the angle around the z axis from the negative x axis, divided by 2 pi, from 0 to 1. t is the cosine of the
    /// angle from the z axis.
    Cylindrical {
        /// The transformation to the space of the z axis.
        texture_from_world: Transform,
    },
    /// The world position along two directions.
    Planar {
        /// The world directions (`v1`, `v2`).
        axes: [DVec3; 2],
        /// The offset (`udelta`, `vdelta`).
        offset: DVec2,
    },
}

const NAMES: &[&str] = &["uv", "spherical", "cylindrical", "planar"];

/// Takes the mapping parameters of 2D textures. Call it after taking the other parameters.
pub(super) fn mapping(params: &mut Params, world_from_texture: Transform) -> Mapping {
    let texture_from_world = world_from_texture.inverse();
    let name = params.choice("mapping", NAMES);
    if !params.usable() || params.may_lack("mapping") {
        // An unknown mapping may have any parameters.
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

/// Warns about parameters of other mappings.
fn idle(params: &mut Params, names: &[&'static str], mapping: &str) {
    for name in names.iter().filter(|name| params.given(name)).copied().collect::<Vec<_>>() {
        params.float(name, 0.0);
        let message = format!("{name} does not apply to the mapping \"{mapping}\": it is ignored");
        let help = "to scale this mapping, use the current transformation, or v1 and v2 of \"planar\"";
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
    let axis = params.triple(name, lookat_syntax::ParamType::Vector3, default.into());
    params.check_range(name, &axis.to_array());
    axis
}
