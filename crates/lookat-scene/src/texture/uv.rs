//! `Texture "uv"`: the fractional part of s as red and of t as green. It has color values only.

use super::mapping::mapping;
use super::{Value, Varying};
use crate::params::Params;
use crate::transform::Transform;

pub(super) fn uv<T: Value>(params: &mut Params, world_from_texture: Transform) -> Varying<T> {
    Varying::Uv(mapping(params, world_from_texture))
}
