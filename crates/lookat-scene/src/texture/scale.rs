//! `Texture "scale"`: the product of two textures.
//!
//! - `tex1`, `tex2`: numbers, colors or textures, default 1

use super::{Parameter, Texture, TextureParams};

pub(super) fn scale<T: Parameter>(params: &mut TextureParams) -> Texture<T> {
    Texture::product(["tex1", "tex2"].map(|name| T::texture(params, name, 1.0)))
}
