//! `Texture "checkerboard"`: two alternating textures in unit squares or cubes.

use super::mapping::{Mapping, idle, mapping, no_mapping};
use super::{Parameter, Texture, TextureParams, Value, Varying};
use crate::schema::{ColorTexture, Key, Keys, Range};
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

const DIMENSION: Key<i32> =
    Key::integer("dimension", 2, "2 for squares of the texture coordinates, 3 for cubes in space")
        .within(Range::from_to(2.0, 3.0));
const TEX1: Key<ColorTexture> = Key::color_texture(
    "tex1",
    1.0,
    "the value of cells with an even sum of coordinates; a number or float texture in a float texture",
);
const TEX2: Key<ColorTexture> = Key::color_texture(
    "tex2",
    0.0,
    "the value of cells with an odd sum of coordinates; a number or float texture in a float texture",
);
const AA_MODE: Key<&[&str]> = Key::choice(
    "aamode",
    &["closedform", "none"],
    "for dimension 2, whether squares are averaged over the texture footprint",
);

pub(super) const KEYS: Keys = &[&DIMENSION, &TEX1, &TEX2, &AA_MODE];

pub(super) fn checkerboard<T: Parameter>(params: &mut TextureParams, ctm: Transform) -> Texture<T> {
    let dimension = params.take(&DIMENSION);
    let textures = [&TEX1, &TEX2].map(|key| T::texture(params, key));
    let cells = match dimension {
        3 => {
            idle(params, &[&AA_MODE], "dimension 3", "cubes are not averaged over the texture footprint");
            no_mapping(params, "dimension 3");
            Cells::Space { texture_from_world: ctm }
        }
        _ => {
            let filtered = params.take(&AA_MODE) == "closedform";
            Cells::Plane { mapping: mapping(params, ctm), filtered }
        }
    };
    match textures {
        [Texture::Constant(a), Texture::Constant(b)] if a == b => Texture::Constant(a),
        _ => Texture::varying(Varying::Checkerboard(Checkerboard { textures, cells })),
    }
}
