//! `Material "metal"`: a rough conductor (PBR 8.2.1, 9.2 of the source, materials/metal.cpp).

use glam::Vec3;
use lookat_syntax::ParamType;

use super::Roughness;
use super::roughness::{self, GIVEN_U, REMAP};
use crate::schema::{ColorTexture, FloatTexture, GivenTexture, Key, Keys};
use crate::texture::{Texture, TextureParams};

/// A rough conductor in air.
#[derive(Debug, Clone)]
pub struct Metal {
    /// The index of refraction, linear RGB (`eta`, default copper).
    pub eta: Texture<Vec3>,
    /// The absorption coefficient, linear RGB (`k`, default copper).
    pub k: Texture<Vec3>,
    /// The roughness (`roughness`, default 0.01; `uroughness`, `vroughness`, `remaproughness`).
    pub roughness: Roughness,
}

/// The index of refraction and absorption of copper: the spectra of pbrt-v3 (materials/metal.cpp), converted to RGB.
const COPPER: [Vec3; 2] = [Vec3::new(0.199990, 0.922086, 1.099876), Vec3::new(3.904638, 2.447633, 2.137651)];

const fn of_copper(name: &'static str, default: Vec3, meaning: &'static str) -> Key<ColorTexture> {
    Key::new(name, ParamType::Rgb, ColorTexture(default), meaning).default_words("copper")
}

const ETA: Key<ColorTexture> = of_copper("eta", COPPER[0], "the index of refraction");
const K: Key<ColorTexture> = of_copper("k", COPPER[1], "the absorption coefficient");
const ROUGHNESS: Key<FloatTexture> = roughness::isotropic(0.01);
const ROUGHNESS_V: Key<GivenTexture> = roughness::given_v("roughness");

pub(super) const KEYS: Keys = &[&ETA, &K, &ROUGHNESS, &GIVEN_U, &ROUGHNESS_V, &REMAP];

pub(super) fn metal(params: &mut TextureParams) -> Metal {
    let [eta, k] = [&ETA, &K].map(|key| {
        let (name, value) = (key.name, params.take_texture(key));
        // Spectra may give negative color components.
        if value.constant().is_some_and(|color| color.min_element() < 0.0) && params.was_rgb(name) {
            let message = format!("{name} is negative, which is not physical");
            params.warn(name, &message, "use eta and k above 0; the defaults are copper");
        }
        value
    });
    Metal { eta, k, roughness: Roughness::of_metal(params, &ROUGHNESS, &ROUGHNESS_V) }
}
