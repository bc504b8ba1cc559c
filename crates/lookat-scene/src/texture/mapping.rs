//! Mappings from surface points to the texture coordinates s and t (PBR 10.2).
//!
//! The poles of `spherical` and the axis of `cylindrical` are the z axis of the space where the texture is defined.

use glam::{DVec2, DVec3};
use lookat_syntax::ParamType;

use crate::params::{ParamValue, Params};
use crate::schema::{Key, Keys};
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

const MAPPING: Key<&[&str]> = Key::choice(
    "mapping",
    &["uv", "spherical", "cylindrical", "planar"],
    "the texture coordinates: of the surface, around the z axis where the texture is defined, or on a plane",
);
const U_SCALE: Key<f64> = Key::float("uscale", 1.0, "for uv, the factor of u");
const V_SCALE: Key<f64> = Key::float("vscale", 1.0, "for uv, the factor of v");
const U_DELTA: Key<f64> = Key::float("udelta", 0.0, "for uv and planar, the offset of s");
const V_DELTA: Key<f64> = Key::float("vdelta", 0.0, "for uv and planar, the offset of t");
const V1: Key<[f64; 3]> =
    Key::new("v1", ParamType::Vector3, [1.0, 0.0, 0.0], "for planar, the direction of s in world space");
const V2: Key<[f64; 3]> =
    Key::new("v2", ParamType::Vector3, [0.0, 1.0, 0.0], "for planar, the direction of t in world space");

pub(super) const KEYS: Keys = &[&MAPPING, &U_SCALE, &V_SCALE, &U_DELTA, &V_DELTA, &V1, &V2];

/// Takes the mapping parameters of 2D textures. Call it after taking the other parameters.
pub(super) fn mapping(params: &mut Params, world_from_texture: Transform) -> Mapping {
    let texture_from_world = world_from_texture.inverse();
    let name = params.take(&MAPPING);
    if !params.usable() || params.may_lack("mapping") {
        // An unknown mapping may have any parameters.
        params.ignore_rest();
    }
    let mapping = &format!("the mapping \"{name}\"");
    match name {
        "planar" => {
            idle(params, &[&U_SCALE, &V_SCALE], mapping, SCALING);
            let axes = [axis(params, &V1), axis(params, &V2)];
            Mapping::Planar { axes, offset: pair(params, [&U_DELTA, &V_DELTA]) }
        }
        "spherical" | "cylindrical" => {
            idle(params, &[&U_SCALE, &V_SCALE, &U_DELTA, &V_DELTA], mapping, SCALING);
            idle(params, &[&V1, &V2], mapping, DIRECTIONS);
            match name {
                "spherical" => Mapping::Spherical { texture_from_world },
                _ => Mapping::Cylindrical { texture_from_world },
            }
        }
        _ => {
            idle(params, &[&V1, &V2], mapping, DIRECTIONS);
            Mapping::Uv {
                scale: pair(params, [&U_SCALE, &V_SCALE]),
                offset: pair(params, [&U_DELTA, &V_DELTA]),
            }
        }
    }
}

const SCALING: &str = "to scale this mapping, use the current transformation, or v1 and v2 of \"planar\"";
const DIRECTIONS: &str = "v1 and v2 are directions of the mapping \"planar\"";

/// Warns about mapping parameters of a texture in space.
pub(super) fn no_mapping(params: &mut Params, texture: &str) {
    let help = "to scale or move it, use the current transformation where the texture is defined";
    idle(params, &[&MAPPING], texture, help);
    idle(params, &[&U_SCALE, &V_SCALE, &U_DELTA, &V_DELTA], texture, help);
    idle(params, &[&V1, &V2], texture, help);
}

/// Warns about parameters that do not apply.
pub(super) fn idle<T: ParamValue>(params: &mut Params, keys: &[&Key<T>], to: &str, help: &str) {
    for key in keys {
        params.take(key);
        if params.was_taken(key.name) {
            let message = format!("{} does not apply to {to}: it is ignored", key.name);
            params.warn(key.name, &message, help);
        }
    }
}

fn pair(params: &mut Params, keys: [&Key<f64>; 2]) -> DVec2 {
    keys.map(|key| number(params, key)).into()
}

/// A number in the range of computation.
pub(super) fn number(params: &mut Params, key: &Key<f64>) -> f64 {
    let value = params.take(key);
    params.check_range(key.name, &[value]);
    value
}

fn axis(params: &mut Params, key: &Key<[f64; 3]>) -> DVec3 {
    let axis = params.take(key);
    params.check_range(key.name, &axis.to_array());
    axis
}
