//! `Texture "dots"`: round dots, one in about two of five squares of size one.
//!
//! - `inside`: number, color or texture around the dots, default 1
//! - `outside`: the same of the dots themselves, default 0
//! - the parameters of [`Mapping`]
//!
//! pbrt-v3 means each of the two where its name says the other, and so do its pictures.

use super::mapping::{Mapping, mapping};
use super::{Parameter, Texture, TextureParams, Value, Varying};
use crate::transform::Transform;

/// Dots at random places.
#[derive(Debug, Clone)]
pub struct Dots<T: Value> {
    /// How they lie on surfaces.
    pub mapping: Mapping,
    /// The texture of the dots (`outside`).
    pub dots: Texture<T>,
    /// The texture around them (`inside`).
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
