//! `Material "uber"`: diffuse, glossy and specular lobes in one material (materials/uber.cpp).

use glam::Vec3;

use super::keys::{ETA, INDEX};
use super::roughness::{self, GIVEN_U, REMAP};
use super::{Roughness, index_of_refraction, share};
use crate::schema::{ColorTexture, FloatTexture, GivenTexture, Key, Keys};
use crate::texture::{Texture, TextureParams};

/// Diffuse, glossy and specular lobes in one material.
#[derive(Debug, Clone)]
pub struct Uber {
    /// The diffuse reflectance (`Kd`, default 0.25).
    pub kd: Texture<Vec3>,
    /// The factor on glossy reflection (`Ks`, default 0.25).
    pub ks: Texture<Vec3>,
    /// The factor on specular reflection (`Kr`, default 0).
    pub kr: Texture<Vec3>,
    /// The factor on specular transmission (`Kt`, default 0).
    pub kt: Texture<Vec3>,
    /// The roughness of the glossy lobe (`uroughness`, or `roughness`, default 0.1; `vroughness`, default the same as
    /// u; `remaproughness`).
    pub roughness: Roughness,
    /// The relative index of refraction, inside over outside, above 0 (`eta` or `index`, default 1.5).
    pub eta: Texture<f64>,
    /// The opacity; the rest of the light passes straight through (`opacity`, default 1).
    pub opacity: Texture<Vec3>,
}

const KD: Key<ColorTexture> = Key::color_texture("Kd", 0.25, "the diffuse reflectance");
const KS: Key<ColorTexture> = Key::color_texture("Ks", 0.25, "the factor of glossy reflection");
const KR: Key<ColorTexture> = Key::color_texture("Kr", 0.0, "the factor of specular reflection");
const KT: Key<ColorTexture> = Key::color_texture("Kt", 0.0, "the factor of specular refraction");
const OPACITY: Key<ColorTexture> =
    Key::color_texture("opacity", 1.0, "the share of light that meets the surface; the rest passes straight");
const ROUGHNESS: Key<FloatTexture> = roughness::isotropic(0.1);
const ROUGHNESS_V: Key<GivenTexture> = roughness::given_v("uroughness");

pub(super) const KEYS: Keys =
    &[&KD, &KS, &KR, &KT, &OPACITY, &ETA, &INDEX, &ROUGHNESS, &GIVEN_U, &ROUGHNESS_V, &REMAP];

pub(super) fn uber(params: &mut TextureParams) -> Uber {
    Uber {
        kd: share(params, &KD),
        ks: share(params, &KS),
        kr: share(params, &KR),
        kt: share(params, &KT),
        roughness: Roughness::of_uber(params, &ROUGHNESS, &ROUGHNESS_V),
        eta: index_of_refraction(params),
        opacity: share(params, &OPACITY),
    }
}
