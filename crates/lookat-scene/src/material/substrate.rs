//! `Material "substrate"`: a diffuse base under a glossy coating with Fresnel reflection (Ashikhmin and Shirley, PBR
//! 8.5).

use glam::Vec3;

use super::roughness::{self, REMAP};
use super::{Roughness, share};
use crate::schema::{ColorTexture, FloatTexture, Key, Keys};
use crate::texture::{Texture, TextureParams};

/// A diffuse base under a coating.
#[derive(Debug, Clone)]
pub struct Substrate {
    /// The diffuse reflectance (`Kd`, default 0.5).
    pub kd: Texture<Vec3>,
    /// The specular reflectance at normal incidence (`Ks`, default 0.5).
    pub ks: Texture<Vec3>,
    /// The roughness of the coating (`uroughness`, `vroughness`, default 0.1; `remaproughness`).
    pub roughness: Roughness,
}

const KD: Key<ColorTexture> = Key::color_texture("Kd", 0.5, "the diffuse reflectance of the base");
const KS: Key<ColorTexture> =
    Key::color_texture("Ks", 0.5, "the specular reflectance of the coating at normal incidence");
const ROUGHNESS_U: Key<FloatTexture> = roughness::along_u(0.1);
const ROUGHNESS_V: Key<FloatTexture> = roughness::along_v(0.1);

pub(super) const KEYS: Keys = &[&KD, &KS, &ROUGHNESS_U, &ROUGHNESS_V, &REMAP];

pub(super) fn substrate(params: &mut TextureParams) -> Substrate {
    Substrate {
        kd: share(params, &KD),
        ks: share(params, &KS),
        roughness: Roughness::of_two(params, [&ROUGHNESS_U, &ROUGHNESS_V]),
    }
}
