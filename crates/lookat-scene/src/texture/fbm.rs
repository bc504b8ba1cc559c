//! `Texture "fbm"`: a sum of noise, like clouds, about -1..1 (fractional Brownian motion).

use super::octaves::octaves;
use super::{Texture, Value, Varying};
use crate::params::Params;
use crate::transform::Transform;

pub(super) fn fbm<T: Value>(params: &mut Params, ctm: Transform) -> Texture<T> {
    Texture::varying(Varying::Fbm(octaves(params, ctm)))
}
