//! `Texture "scale"`: the product of two textures.

use super::{Parameter, Texture, TextureParams};
use crate::schema::{ColorTexture, Key, Keys};

const TEX1: Key<ColorTexture> =
    Key::color_texture("tex1", 1.0, "a factor; a number or float texture in a float texture");
const TEX2: Key<ColorTexture> = Key { name: "tex2", ..TEX1 };

pub(super) const KEYS: Keys = &[&TEX1, &TEX2];

pub(super) fn scale<T: Parameter>(params: &mut TextureParams) -> Texture<T> {
    Texture::product([&TEX1, &TEX2].map(|key| T::texture(params, key)))
}
