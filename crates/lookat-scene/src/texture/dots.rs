//! `Texture "dots"`: round dots in about two of five unit squares.
//!
//! - `inside`: number, color or texture around the dots, default 1
//! - `outside`: number, color or texture of the dots, default 0
//! - the parameters of [`Mapping`]
//!
//! pbrt-v3 swaps these names, and lookat follows pbrt-v3.

use super::mapping::{Mapping, mapping};
use super::{Parameter, Texture, TextureParams, Value, Varying};
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

pub(super) fn dots<T: Parameter>(params: &mut TextureParams, ctm: Transform) -> Texture<T> {
    let around = T::texture(params, "inside", 1.0);
    let dots = T::texture(params, "outside", 0.0);
    let mapping = mapping(params, ctm);
    match (&dots, &around) {
        (Texture::Constant(a), Texture::Constant(b)) if a == b => Texture::Constant(*a),
        _ => Texture::varying(Varying::Dots(Dots { mapping, dots, around })),
    }
}
