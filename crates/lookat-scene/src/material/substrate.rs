//! `Material "substrate"`: a diffuse base under a glossy coating with Fresnel reflection (Ashikhmin and Shirley, PBR
//! 8.5).

use glam::Vec3;

use super::{Roughness, share};
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

pub(super) fn substrate(params: &mut TextureParams) -> Substrate {
    Substrate {
        kd: share(params, "Kd", 0.5),
        ks: share(params, "Ks", 0.5),
        roughness: Roughness::of_two(params, 0.1),
    }
}
