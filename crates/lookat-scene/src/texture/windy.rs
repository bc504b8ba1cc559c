//! `Texture "windy"`: the height of waves under varying wind. It has no parameters.

use super::{Texture, Value, Varying};
use crate::transform::Transform;

pub(super) fn windy<T: Value>(ctm: Transform) -> Texture<T> {
    Texture::varying(Varying::Windy { texture_from_world: ctm })
}
