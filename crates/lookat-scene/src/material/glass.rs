//! `Material "glass"`: reflection and refraction at a dielectric boundary (PBR3 8.2, 8.4; materials/glass.cpp).

use glam::Vec3;

use super::keys::{ETA, INDEX};
use super::roughness::{self, REMAP};
use super::{Roughness, index_of_refraction, share};
use crate::schema::{ColorTexture, FloatTexture, Key, Keys};
use crate::texture::{Texture, TextureParams};

/// Smooth or rough glass.
#[derive(Debug, Clone)]
pub struct Glass {
    /// The factor on reflection (`Kr`, default 1).
    pub kr: Texture<Vec3>,
    /// The factor on transmission (`Kt`, default 1).
    pub kt: Texture<Vec3>,
    /// The roughness; smooth where both values are 0 (`uroughness`, `vroughness`, default 0; `remaproughness`).
    pub roughness: Roughness,
    /// The relative index of refraction, inside over outside (the side of the normal), above 0 (`eta` or `index`,
    /// default 1.5).
    pub eta: Texture<f64>,
}

const KR: Key<ColorTexture> = Key::color_texture("Kr", 1.0, "the factor of reflection");
const KT: Key<ColorTexture> = Key::color_texture("Kt", 1.0, "the factor of refraction");
const ROUGHNESS_U: Key<FloatTexture> = roughness::along_u(0.0);
const ROUGHNESS_V: Key<FloatTexture> = roughness::along_v(0.0);

pub(super) const KEYS: Keys = &[&KR, &KT, &ETA, &INDEX, &ROUGHNESS_U, &ROUGHNESS_V, &REMAP];

pub(super) fn glass(params: &mut TextureParams) -> Glass {
    let [kr, kt] = [&KR, &KT].map(|key| share(params, key));
    let (roughness, eta) =
        (Roughness::of_two(params, [&ROUGHNESS_U, &ROUGHNESS_V]), index_of_refraction(params));
    let is_smooth = |width: &Texture<f64>| width.constant() == Some(0.0);
    if eta.constant() == Some(1.0)
        && !(is_smooth(&roughness.u) && roughness.v.as_ref().is_some_and(is_smooth))
    {
        let name = if params.was_taken("eta") { "eta" } else { "index" };
        let message = "pbrt-v3 aborts at rough glass of index 1; lookat lets light pass straight through";
        params.warn(name, message, "write an index of 1.001: it looks the same and renders in both programs");
    }
    Glass { kr, kt, roughness, eta }
}
