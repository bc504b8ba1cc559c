//! `Texture "scale"`: the product of two textures.
//!
//! - `tex1`, `tex2`: numbers, colors or textures, default 1

use super::{Parameter, Texture, TextureParams, Varying};

pub(super) fn scale<T: Parameter>(params: &mut TextureParams) -> Texture<T> {
    let factors = ["tex1", "tex2"].map(|name| T::texture(params, name, 1.0));
    match &factors {
        [Texture::Constant(a), Texture::Constant(b)] => Texture::Constant(*a * *b),
        _ => Texture::varying(Varying::Scale(factors)),
    }
}
