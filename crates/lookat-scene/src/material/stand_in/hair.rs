//! `hair` as a diffuse surface of the color of a mass of hair, by its absorption and the other way round, after Chiang et al.
//! 2016 (HairBSDF in materials/hair.cpp).

use glam::Vec3;

use super::{constant, constant_color, polynomial, share};
use crate::schema::{ColorTexture, Effect, FloatTexture, Key, Keys, Unit};
use crate::texture::{Texture, TextureParams};

const SIGMA_A: Key<ColorTexture> =
    Key::color_texture("sigma_a", 0.0, "the absorption coefficient inside a hair")
        .default_words("from color or the pigments");
const COLOR: Key<ColorTexture> =
    Key::color_texture("color", 0.0, "the color of a mass of hair").default_words("none");
const EUMELANIN: Key<FloatTexture> =
    Key::float_texture("eumelanin", 1.3, "the concentration of the brown pigment")
        .default_words("1.3; 0 with pheomelanin");
const PHEOMELANIN: Key<FloatTexture> =
    Key::float_texture("pheomelanin", 0.0, "the concentration of the red pigment");
const BETA_N: Key<FloatTexture> = Key::float_texture("beta_n", 0.3, "the roughness around a hair");
const BETA_M: Key<FloatTexture> =
    Key::float_texture("beta_m", 0.3, "the roughness along a hair").effect(Effect::NotRendered);
const ETA: Key<FloatTexture> =
    Key::float_texture("eta", 1.55, "the index of refraction inside a hair").effect(Effect::NotRendered);
const ALPHA: Key<FloatTexture> = Key::float_texture("alpha", 2.0, "the angle of the scales of a hair")
    .unit(Unit::Degrees)
    .effect(Effect::NotRendered);

pub(in crate::material) const KEYS: Keys =
    &[&SIGMA_A, &COLOR, &EUMELANIN, &PHEOMELANIN, &BETA_N, &BETA_M, &ETA, &ALPHA];

pub(super) fn color(params: &mut TextureParams) -> Texture<Vec3> {
    let color = share(params, &COLOR);
    let absorption = absorption(params);
    let beta = constant(params, &BETA_N);
    if params.was_taken("color") && !params.was_taken("sigma_a") {
        return color;
    }
    let of_beta = polynomial([0.245, 5.574, -10.73, 2.532, -0.215, 5.969], beta) as f32;
    Texture::Constant(absorption.map(|channel| libm::expf(-channel.sqrt() * of_beta)))
}

/// The absorption inside a hair, by default of brown hair.
fn absorption(params: &mut TextureParams) -> Vec3 {
    const OF_EUMELANIN: Vec3 = Vec3::new(0.419, 0.697, 1.37);
    const OF_PHEOMELANIN: Vec3 = Vec3::new(0.187, 0.4, 1.05);
    let [eumelanin, pheomelanin] =
        [&EUMELANIN, &PHEOMELANIN].map(|key| constant(params, key).max(0.0) as f32);
    let is_red = params.was_taken("pheomelanin") && !params.was_taken("eumelanin");
    let eumelanin = if is_red { 0.0 } else { eumelanin };
    let default = ColorTexture(eumelanin * OF_EUMELANIN + pheomelanin * OF_PHEOMELANIN);
    constant_color(params, &Key { default, ..SIGMA_A })
}
