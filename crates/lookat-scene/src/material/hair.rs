//! `Material "hair"`: hair and fur (Chiang et al., "A Practical and Controllable Hair and Fur Model for Production Path Tracing",
//! EGSR 2016; materials/hair.cpp).

use glam::Vec3;

use crate::material::models::{not_negative, reflectance};
use crate::params::Params;
use crate::params::value::{ColorTexture, FloatTexture};
use crate::schema::{Key, Keys, Range, Unit};
use crate::texture::Texture;

/// Hair and fur.
#[derive(Debug, Clone)]
pub struct Hair {
    /// What decides the color.
    pub color: HairColor,
    /// The index of refraction inside, at least 1 (`eta`, default 1.55).
    pub eta: Texture<f64>,
    /// The roughness along a hair, 0 to 1 (`beta_m`, default 0.3).
    pub beta_m: Texture<f64>,
    /// The roughness around a hair, 0 to 1 (`beta_n`, default 0.3).
    pub beta_n: Texture<f64>,
    /// The angle of the scales in degrees (`alpha`, default 2).
    pub alpha: Texture<f64>,
}

/// The absorption inside a hair. Negative values count as 0.
#[derive(Debug, Clone)]
pub enum HairColor {
    /// The absorption coefficient, for a hair of radius 1 (`sigma_a`).
    Absorption(Texture<Vec3>),
    /// The color of a mass of hair (`color`).
    Reflectance(Texture<Vec3>),
    /// Concentrations of the brown and the red pigment (`eumelanin`, `pheomelanin`; by default 1.3 and 0).
    Pigments {
        /// The brown pigment.
        eumelanin: Texture<f64>,
        /// The red pigment.
        pheomelanin: Texture<f64>,
    },
}

impl HairColor {
    /// The color that can be a texture.
    pub(super) fn color(&self) -> Option<&Texture<Vec3>> {
        match self {
            HairColor::Absorption(color) | HairColor::Reflectance(color) => Some(color),
            HairColor::Pigments { .. } => None,
        }
    }
}

impl Hair {
    /// The numbers that can be textures.
    pub(super) fn numbers(&self) -> Vec<&Texture<f64>> {
        let mut all = vec![&self.eta, &self.beta_m, &self.beta_n, &self.alpha];
        if let HairColor::Pigments { eumelanin, pheomelanin } = &self.color {
            all.extend([eumelanin, pheomelanin]);
        }
        all
    }
}

const SIGMA_A: Key<ColorTexture> =
    Key::color_texture("sigma_a", 0.0, "the absorption coefficient inside a hair of radius 1")
        .default_words("from color or the pigments");
const COLOR: Key<ColorTexture> =
    Key::color_texture("color", 0.0, "the color of a mass of hair").default_words("from the pigments");
const EUMELANIN: Key<FloatTexture> =
    Key::float_texture("eumelanin", 1.3, "the concentration of the brown pigment")
        .default_words("1.3; 0 with pheomelanin");
const PHEOMELANIN: Key<FloatTexture> =
    Key::float_texture("pheomelanin", 0.0, "the concentration of the red pigment");
const INDEX: Key<FloatTexture> =
    Key::float_texture("eta", 1.55, "the index of refraction inside a hair").within(Range::at_least(1.0));
const BETA_M: Key<FloatTexture> =
    Key::float_texture("beta_m", 0.3, "the roughness along a hair").within(Range::from_to(0.0, 1.0));
const BETA_N: Key<FloatTexture> =
    Key::float_texture("beta_n", 0.3, "the roughness around a hair").within(Range::from_to(0.0, 1.0));
const ALPHA: Key<FloatTexture> =
    Key::float_texture("alpha", 2.0, "the angle of the scales of a hair").unit(Unit::Degrees);

pub(super) const KEYS: Keys = &[&SIGMA_A, &COLOR, &EUMELANIN, &PHEOMELANIN, &INDEX, &BETA_M, &BETA_N, &ALPHA];

pub(super) fn hair(params: &mut Params) -> Hair {
    let absorption = params.take(&SIGMA_A);
    let absorption = not_negative(params, SIGMA_A.name, absorption, "write coefficients of 0 or more");
    let reflectance = reflectance(params, &COLOR);
    let [mut eumelanin, pheomelanin] = [&EUMELANIN, &PHEOMELANIN].map(|key| params.take(key));
    for (name, number) in [(EUMELANIN.name, &eumelanin), (PHEOMELANIN.name, &pheomelanin)] {
        if number.constant().is_some_and(|value| value < 0.0) {
            let message = format!("{name} is negative: it is used as 0, as in pbrt-v3");
            params.warn(name, &message, "write a concentration of 0 or more");
        }
    }
    let color = if params.was_taken(SIGMA_A.name) {
        for name in [COLOR.name, EUMELANIN.name, PHEOMELANIN.name] {
            params.replaced_by(name, &[SIGMA_A.name]);
        }
        HairColor::Absorption(absorption)
    } else if params.was_taken(COLOR.name) {
        for name in [EUMELANIN.name, PHEOMELANIN.name] {
            params.replaced_by(name, &[COLOR.name]);
        }
        HairColor::Reflectance(reflectance)
    } else {
        if params.was_taken(PHEOMELANIN.name) && !params.was_taken(EUMELANIN.name) {
            eumelanin = Texture::Constant(0.0);
        }
        HairColor::Pigments { eumelanin, pheomelanin }
    };
    let [eta, beta_m, beta_n, alpha] = [&INDEX, &BETA_M, &BETA_N, &ALPHA].map(|key| params.take(key));
    Hair { color, eta, beta_m, beta_n, alpha }
}
