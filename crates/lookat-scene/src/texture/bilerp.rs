//! `Texture "bilerp"`: bilinear interpolation between the corners of the unit square.
//!
//! - `v00`, `v10`: numbers or colors at t = 0 for s = 0 and 1, default 0
//! - `v01`, `v11`: the same at t = 1, default 1
//! - the parameters of [`Mapping`]

use super::mapping::{Mapping, mapping};
use super::{Parameter, Texture, Varying};
use crate::params::Params;
use crate::transform::Transform;

/// The values at four corners. They are extrapolated outside the square.
#[derive(Debug, Clone)]
pub struct Bilerp<T> {
    /// The texture coordinate mapping.
    pub mapping: Mapping,
    /// The values at s = 0 for t = 0 and 1, then at s = 1.
    pub corners: [[T; 2]; 2],
}

pub(super) fn bilerp<T: Parameter>(params: &mut Params, world_from_texture: Transform) -> Texture<T> {
    let corners = [["v00", "v01"], ["v10", "v11"]]
        .map(|[low, high]| [T::value(params, low, 0.0), T::value(params, high, 1.0)]);
    let mapping = mapping(params, world_from_texture);
    let [[first, a], [b, c]] = corners;
    if [a, b, c] == [first; 3] {
        return Texture::Constant(first);
    }
    Texture::varying(Varying::Bilerp(Bilerp { mapping, corners }))
}
