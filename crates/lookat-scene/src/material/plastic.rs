//! `Material "plastic"`: a diffuse base under a rough dielectric coating (PBR 9.2.2).

use glam::Vec3;

use super::{Roughness, share};
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

pub(super) fn plastic(params: &mut TextureParams) -> Plastic {
    Plastic {
        kd: share(params, "Kd", 0.25),
        ks: share(params, "Ks", 0.25),
        roughness: Roughness::isotropic(params, 0.1),
    }
}
