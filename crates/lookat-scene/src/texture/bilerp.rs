//! `Texture "bilerp"`: four values at the corners of the unit square, and what lies between.
//!
//! - `v00`, `v10`: numbers or colors where t is 0 and s is 0 or 1, default 0
//! - `v01`, `v11`: the same where t is 1, default 1
//! - the parameters of [`Mapping`]

use super::mapping::{Mapping, mapping};
use super::{Parameter, Texture, Varying};
use crate::params::Params;
use crate::transform::Transform;

/// Values at four corners. Outside of the square they go on in the same way.
#[derive(Debug, Clone)]
pub struct Bilerp<T> {
    /// How it lies on surfaces.
    pub mapping: Mapping,
    /// The values where s is 0, at t of 0 and 1; then those where s is 1.
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
