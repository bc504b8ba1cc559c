//! `Material "translucent"`: diffuse and glossy reflection and transmission (materials/translucent.cpp).

use glam::Vec3;

use super::roughness::{self, REMAP};
use super::{Roughness, share};
use crate::schema::{ColorTexture, FloatTexture, Key, Keys};
use crate::texture::{Texture, TextureParams};

/// A thin surface of index 1.5 that reflects and transmits.
#[derive(Debug, Clone)]
pub struct Translucent {
    /// The factor on diffuse scattering (`Kd`, default 0.25).
    pub kd: Texture<Vec3>,
    /// The factor on glossy scattering (`Ks`, default 0.25).
    pub ks: Texture<Vec3>,
    /// The reflected part of both (`reflect`, default 0.5).
    pub reflect: Texture<Vec3>,
    /// The transmitted part of both (`transmit`, default 0.5).
    pub transmit: Texture<Vec3>,
    /// The roughness of the glossy lobe (`roughness`, default 0.1; `remaproughness`).
    pub roughness: Roughness,
}

const KD: Key<ColorTexture> = Key::color_texture("Kd", 0.25, "the factor of diffuse scattering");
const KS: Key<ColorTexture> = Key::color_texture("Ks", 0.25, "the factor of glossy scattering");
const REFLECT: Key<ColorTexture> = Key::color_texture("reflect", 0.5, "the share of both that is reflected");
const TRANSMIT: Key<ColorTexture> =
    Key::color_texture("transmit", 0.5, "the share of both that is transmitted");
const ROUGHNESS: Key<FloatTexture> = roughness::isotropic(0.1);

pub(super) const KEYS: Keys = &[&KD, &KS, &REFLECT, &TRANSMIT, &ROUGHNESS, &REMAP];

pub(super) fn translucent(params: &mut TextureParams) -> Translucent {
    Translucent {
        kd: share(params, &KD),
        ks: share(params, &KS),
        reflect: share(params, &REFLECT),
        transmit: share(params, &TRANSMIT),
        roughness: Roughness::isotropic(params, &ROUGHNESS),
    }
}
