//! `Texture "bilerp"`: bilinear interpolation between the corners of the unit square.

use super::mapping::{Mapping, mapping};
use super::{Parameter, Texture, Varying};
use crate::params::Params;
use crate::schema::{Color, Key, Keys};
use crate::transform::Transform;

/// The values at four corners. They are extrapolated outside the square.
#[derive(Debug, Clone)]
pub struct Bilerp<T> {
    /// The texture coordinate mapping.
    pub mapping: Mapping,
    /// The values at s = 0 for t = 0 and 1, then at s = 1.
    pub corners: [[T; 2]; 2],
}

const V00: Key<Color> = Key::color("v00", 0.0, "the value at s = 0, t = 0; a number in a float texture");
const V01: Key<Color> = Key::color("v01", 1.0, "the value at s = 0, t = 1; a number in a float texture");
const V10: Key<Color> = Key::color("v10", 0.0, "the value at s = 1, t = 0; a number in a float texture");
const V11: Key<Color> = Key::color("v11", 1.0, "the value at s = 1, t = 1; a number in a float texture");

pub(super) const KEYS: Keys = &[&V00, &V01, &V10, &V11];

pub(super) fn bilerp<T: Parameter>(params: &mut Params, world_from_texture: Transform) -> Texture<T> {
    let corners = [[&V00, &V01], [&V10, &V11]].map(|keys| keys.map(|key| T::value(params, key)));
    let mapping = mapping(params, world_from_texture);
    let [[first, a], [b, c]] = corners;
    if [a, b, c] == [first; 3] {
        return Texture::Constant(first);
    }
    Texture::varying(Varying::Bilerp(Bilerp { mapping, corners }))
}
