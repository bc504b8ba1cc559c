//! Parameters that several materials share.

use glam::Vec3;

use crate::schema::{ColorTexture, FloatTexture, GivenTexture, Key, Range, Unit};
use crate::texture::{Texture, TextureParams};

pub(super) const BUMP: Key<GivenTexture> =
    Key::given_texture("bumpmap", "the height above the surface, which changes the shading normal")
        .unit(Unit::WorldSpace);
pub(super) const INDEX: Key<FloatTexture> =
    Key::float_texture("index", 1.5, "another name of eta").within(Range::above(0.0));
pub(super) const ETA: Key<GivenTexture> =
    Key::given_texture("eta", "the index of refraction, inside over outside")
        .within(Range::above(0.0))
        .default_words("index");

pub(super) fn bump(params: &mut TextureParams) -> Option<Texture<f64>> {
    // A constant height of 0 has no effect.
    params.take_texture(&BUMP).filter(|bump| bump.constant() != Some(0.0))
}

/// A reflectance or transmittance. Negative values count as 0, as in pbrt-v3.
pub(super) fn share(params: &mut TextureParams, key: &Key<ColorTexture>) -> Texture<Vec3> {
    let share = params.take_texture(key);
    let name = key.name;
    let Texture::Constant(color) = share else { return share };
    // A spectrum with values up to 1 may give a color above 1, or negative components.
    let is_rgb = params.was_rgb(name) || params.was_texture(name);
    if color.max_element() > 1.0 && is_rgb {
        params.warn(
            name,
            &format!("{name} is above 1: the surface reflects more light than it receives"),
            "use colors from 0 to 1: divide by 255 if yours go to 255",
        );
    }
    if color.min_element() < 0.0 && is_rgb {
        params.warn(
            name,
            &format!("{name} is negative: it is used as 0, as in pbrt-v3"),
            "use colors from 0 to 1",
        );
    }
    Texture::Constant(color.max(Vec3::ZERO))
}

/// The index of refraction by either name. `eta` has precedence, as in pbrt-v3.
pub(super) fn index_of_refraction(params: &mut TextureParams) -> Texture<f64> {
    let eta = params.take_texture(&ETA);
    let range = if eta.is_some() { Range::ALL } else { INDEX.range };
    let index = params.take_texture(&Key { range, ..INDEX });
    params.replaced_by("index", &["eta"]);
    eta.unwrap_or(index)
}
