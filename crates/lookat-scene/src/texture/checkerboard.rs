//! `Texture "checkerboard"`: two alternating textures in unit squares or cubes.
//!
//! - `dimension`: 2 (default) or 3
//! - `tex1`: number, color or texture of even cells (by the sum of the cell coordinates), default 1
//! - `tex2`: number, color or texture of odd cells, default 0
//! - in two dimensions: `aamode`, `closedform` (default: the mean over the texture footprint) or
//!   `none`, and the parameters of [`Mapping`]

use super::mapping::{Mapping, mapping};
use super::{Parameter, Texture, TextureParams, Value, Varying};
use crate::transform::Transform;

/// Two alternating textures.
#[derive(Debug, Clone)]
pub struct Checkerboard<T: Value> {
    /// The textures of even and odd cells (`tex1`, `tex2`).
    pub textures: [Texture<T>; 2],
    /// The cells.
    pub cells: Cells,
}

/// The unit cells of a checkerboard.
#[derive(Debug, Clone)]
pub enum Cells {
    /// Squares.
    Plane {
        /// The texture coordinate mapping.
        mapping: Mapping,
        /// True to average over the texture footprint (`aamode`).
        filtered: bool,
    },
    /// Cubes.
    Space {
        /// The transformation of world positions.
        texture_from_world: Transform,
    },
}

pub(super) fn checkerboard<T: Parameter>(params: &mut TextureParams, ctm: Transform) -> Texture<T> {
    let dimension = params.integer("dimension", 2);
    let textures = [T::texture(params, "tex1", 1.0), T::texture(params, "tex2", 0.0)];
    let cells = match dimension {
        2 => {
            let filtered = params.choice("aamode", &["closedform", "none"]) == "closedform";
            Cells::Plane { mapping: mapping(params, ctm), filtered }
        }
        3 => Cells::Space { texture_from_world: ctm },
        other => {
            let message = format!("a checkerboard cannot have {other} dimensions");
            params.reject("dimension", message, Some("use 2 or 3"));
            params.ignore_rest();
            Cells::Space { texture_from_world: ctm }
        }
    };
    match textures {
        [Texture::Constant(a), Texture::Constant(b)] if a == b => Texture::Constant(a),
        _ => Texture::varying(Varying::Checkerboard(Checkerboard { textures, cells })),
    }
}
