//! `Texture "checkerboard"`: two textures in turn, in squares or cubes of size one.
//!
//! - `dimension`: 2 (default) or 3
//! - `tex1`: number, color or texture where the sum of the cell's numbers is even, default 1
//! - `tex2`: the same where it is odd, default 0
//! - of two dimensions: `aamode`, `closedform` (default: the mean over the distance to neighbouring camera rays) or
//!   `none`, and the parameters of [`Mapping`]

use super::mapping::{Mapping, mapping};
use super::{Parameter, Texture, TextureParams, Value, Varying};
use crate::transform::Transform;

/// Two textures in turn.
#[derive(Debug, Clone)]
pub struct Checkerboard<T: Value> {
    /// The texture of even cells and that of odd ones (`tex1`, `tex2`).
    pub textures: [Texture<T>; 2],
    /// The cells.
    pub cells: Cells,
}

/// The cells of a checkerboard, one unit wide.
#[derive(Debug, Clone)]
pub enum Cells {
    /// Squares.
    Plane {
        /// How they lie on surfaces.
        mapping: Mapping,
        /// Whether the mean over the distance to neighbouring camera rays is taken (`aamode`).
        filtered: bool,
    },
    /// Cubes.
    Space {
        /// What is applied to positions in the world.
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
            let message = format!("there is no checkerboard of {other} dimensions");
            params.reject("dimension", message, Some("it has 2 or 3"));
            params.ignore_rest();
            Cells::Space { texture_from_world: ctm }
        }
    };
    match textures {
        [Texture::Constant(a), Texture::Constant(b)] if a == b => Texture::Constant(a),
        _ => Texture::varying(Varying::Checkerboard(Checkerboard { textures, cells })),
    }
}
