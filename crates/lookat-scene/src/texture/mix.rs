//! `Texture "mix"`: a blend of two textures.
//!
//! - `tex1`: number, color or texture, default 0
//! - `tex2`: number, color or texture, default 1
//! - `amount`: weight of the second, number or float texture, default 0.5

use super::{Parameter, Texture, TextureParams, Varying};

pub(super) fn mix<T: Parameter>(params: &mut TextureParams) -> Texture<T> {
    let textures = [T::texture(params, "tex1", 0.0), T::texture(params, "tex2", 1.0)];
    let amount = params.float_texture("amount", 0.5);
    match (&textures, &amount) {
        ([Texture::Constant(a), Texture::Constant(b)], Texture::Constant(amount)) => {
            Texture::Constant(T::mix(*a, *b, *amount))
        }
        _ => Texture::varying(Varying::Mix { textures, amount }),
    }
}
