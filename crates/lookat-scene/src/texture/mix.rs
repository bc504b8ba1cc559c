//! `Texture "scale"` and `"mix"`: the product and the blend of two textures.

use super::{Parameter, Texture, TextureParams, Varying};
use crate::schema::{ColorTexture, FloatTexture, Key, Keys};

const FIRST_FACTOR: Key<ColorTexture> =
    Key::color_texture("tex1", 1.0, "a factor; a number or float texture in a float texture");
const SECOND_FACTOR: Key<ColorTexture> = Key { name: "tex2", ..FIRST_FACTOR };

pub(super) const SCALE_KEYS: Keys = &[&FIRST_FACTOR, &SECOND_FACTOR];

pub(super) fn scale<T: Parameter>(params: &mut TextureParams) -> Texture<T> {
    Texture::product([&FIRST_FACTOR, &SECOND_FACTOR].map(|key| T::texture(params, key)))
}

const TEX1: Key<ColorTexture> = Key::color_texture(
    "tex1",
    0.0,
    "the value where amount is 0; a number or float texture in a float texture",
);
const TEX2: Key<ColorTexture> = Key::color_texture(
    "tex2",
    1.0,
    "the value where amount is 1; a number or float texture in a float texture",
);
const AMOUNT: Key<FloatTexture> = Key::float_texture("amount", 0.5, "the share of tex2");

pub(super) const MIX_KEYS: Keys = &[&TEX1, &TEX2, &AMOUNT];

pub(super) fn mix<T: Parameter>(params: &mut TextureParams) -> Texture<T> {
    let textures = [&TEX1, &TEX2].map(|key| T::texture(params, key));
    let amount = params.take_texture(&AMOUNT);
    match (&textures, &amount) {
        ([Texture::Constant(a), Texture::Constant(b)], Texture::Constant(amount)) => {
            Texture::Constant(T::mix(*a, *b, *amount))
        }
        _ => Texture::varying(Varying::Mix { textures, amount }),
    }
}
