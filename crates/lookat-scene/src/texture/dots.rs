//! `Texture "dots"`: round dots in about two of five unit squares.
//!
//! pbrt-v3 swaps the names `inside` and `outside`, and lookat follows pbrt-v3.

use super::mapping::{Mapping, mapping};
use super::{Parameter, Texture, TextureParams, Value, Varying};
use crate::schema::{ColorTexture, Key, Keys};
use crate::transform::Transform;

/// Dots at random places.
#[derive(Debug, Clone)]
pub struct Dots<T: Value> {
    /// The texture coordinate mapping.
    pub mapping: Mapping,
    /// The texture of the dots (`outside`).
    pub dots: Texture<T>,
    /// The texture around the dots (`inside`).
    pub around: Texture<T>,
}

const INSIDE: Key<ColorTexture> = Key::color_texture(
    "inside",
    1.0,
    "the value around the dots, as in pbrt-v3; a number or float texture in a float texture",
);
const OUTSIDE: Key<ColorTexture> = Key::color_texture(
    "outside",
    0.0,
    "the value of the dots, as in pbrt-v3; a number or float texture in a float texture",
);

pub(super) const KEYS: Keys = &[&INSIDE, &OUTSIDE];

pub(super) fn dots<T: Parameter>(params: &mut TextureParams, ctm: Transform) -> Texture<T> {
    let around = T::texture(params, &INSIDE);
    let dots = T::texture(params, &OUTSIDE);
    let mapping = mapping(params, ctm);
    match (&dots, &around) {
        (Texture::Constant(a), Texture::Constant(b)) if a == b => Texture::Constant(*a),
        _ => Texture::varying(Varying::Dots(Dots { mapping, dots, around })),
    }
}
