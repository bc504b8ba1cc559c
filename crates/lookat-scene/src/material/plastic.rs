//! `Material "plastic"`: a diffuse base under a rough dielectric coating (PBR 9.2.2).

use glam::Vec3;

use super::roughness::{self, REMAP};
use super::{Roughness, share};
use crate::schema::{ColorTexture, FloatTexture, Key, Keys};
use crate::texture::{Texture, TextureParams};

/// A diffuse base under a rough dielectric coating of index 1.5.
#[derive(Debug, Clone)]
pub struct Plastic {
    /// The diffuse reflectance (`Kd`, default 0.25).
    pub kd: Texture<Vec3>,
    /// The factor on glossy reflection (`Ks`, default 0.25).
    pub ks: Texture<Vec3>,
    /// The roughness of the glossy lobe (`roughness`, default 0.1; `remaproughness`).
    pub roughness: Roughness,
}

const KD: Key<ColorTexture> = Key::color_texture("Kd", 0.25, "the diffuse reflectance");
const KS: Key<ColorTexture> = Key::color_texture("Ks", 0.25, "the factor of glossy reflection");
const ROUGHNESS: Key<FloatTexture> = roughness::isotropic(0.1);

pub(super) const KEYS: Keys = &[&KD, &KS, &ROUGHNESS, &REMAP];

pub(super) fn plastic(params: &mut TextureParams) -> Plastic {
    Plastic {
        kd: share(params, &KD),
        ks: share(params, &KS),
        roughness: Roughness::isotropic(params, &ROUGHNESS),
    }
}
