//! From a point of a surface to a place on a picture (PBR 10.2).
//!
//! - `mapping`: `uv` (the default), `spherical`, `cylindrical` or `planar`
//! - `uscale`, `vscale`: of `uv`, factors of the surface's coordinates, default 1
//! - `v1`, `v2`: of `planar`, the directions along which s and t grow, default 1 0 0 and 0 1 0
//! - `udelta`, `vdelta`: of `uv` and `planar`, added to s and t, default 0

use glam::{DVec2, DVec3};
use lookat_syntax::ParamType;

use crate::Transform;
use crate::params::Params;

/// What gives a point of a surface its place on a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mapping {
    /// The coordinates of the surface.
    Uv {
        /// Their factors (`uscale`, `vscale`).
        scale: DVec2,
        /// What is added then (`udelta`, `vdelta`).
        delta: DVec2,
    },
    /// The latitude from +z and the longitude from +x in texture space, each from 0 to 1.
    Spherical {
        /// Takes the world to texture space: the current transformation at the directive.
        texture_from_world: Transform,
    },
    /// The longitude from -x, from 0 to 1, and the cosine of the latitude in texture space.
    Cylindrical {
        /// Takes the world to texture space.
        texture_from_world: Transform,
    },
    /// World positions by dot products.
    Planar {
        /// Along which s grows, and t (`v1`, `v2`).
        axes: [DVec3; 2],
        /// What is added (`udelta`, `vdelta`).
        delta: DVec2,
    },
}

const NAMES: &[&str] = &["uv", "spherical", "cylindrical", "planar"];

/// The parameters of a mapping.
pub(super) fn mapping(params: &mut Params, world_from_texture: Transform) -> Mapping {
    let texture_from_world = world_from_texture.inverse();
    let name = params.string("mapping");
    match name.as_ref().map_or("uv", |name| name.value.as_str()) {
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
            Mapping::Planar {
                axes: [axis(params, "v1", DVec3::X), axis(params, "v2", DVec3::Y)],
                delta: DVec2::new(number(params, "udelta", 0.0), number(params, "vdelta", 0.0)),
            }
        }
        other => {
            if !NAMES.contains(&other) {
                let help = "there are \"uv\", \"spherical\", \"cylindrical\" and \"planar\"";
                params.reject("mapping", format!("unknown mapping \"{other}\""), Some(help));
            }
            Mapping::Uv {
                scale: DVec2::new(number(params, "uscale", 1.0), number(params, "vscale", 1.0)),
                delta: DVec2::new(number(params, "udelta", 0.0), number(params, "vdelta", 0.0)),
            }
        }
    }
}

/// Warns about parameters that belong to other mappings.
fn idle(params: &mut Params, names: &[&'static str], mapping: &str) {
    for name in names.iter().filter(|name| params.given(name)).copied().collect::<Vec<_>>() {
        params.float(name, 0.0);
        let message = format!("{name} has no meaning for the mapping \"{mapping}\"; it is ignored");
        params.warn(
            name,
            &message,
            "the current transformation, or v1 and v2 of \"planar\", scale such mappings",
        );
    }
}

fn number(params: &mut Params, name: &'static str, default: f64) -> f64 {
    let number = params.float(name, default);
    params.check_range(name, &[number]);
    number
}

fn axis(params: &mut Params, name: &'static str, default: DVec3) -> DVec3 {
    let given = params.triples(name, ParamType::Vector3);
    if given.as_ref().is_some_and(|vectors| vectors.len() != 1) {
        params.reject(name, format!("{name} takes 1 value"), None);
    }
    let axis = given.and_then(|vectors| vectors.first().copied()).map_or(default, DVec3::from);
    params.check_range(name, &axis.to_array());
    axis
}
