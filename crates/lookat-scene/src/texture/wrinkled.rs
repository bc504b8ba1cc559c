//! `Texture "wrinkled"`: turbulence, a sum of absolute noise values with creases at 0.

use super::octaves::octaves;
use super::{Texture, Value, Varying};
use crate::params::Params;
use crate::transform::Transform;

pub(super) fn wrinkled<T: Value>(params: &mut Params, ctm: Transform) -> Texture<T> {
    Texture::varying(Varying::Wrinkled(octaves(params, ctm)))
}
