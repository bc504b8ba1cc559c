//! `Material "uber"`: diffuse, glossy and specular lobes in one material (materials/uber.cpp).

use glam::Vec3;

use super::{Roughness, index_of_refraction, share};
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

pub(super) fn uber(params: &mut TextureParams) -> Uber {
    Uber {
        kd: share(params, "Kd", 0.25),
        ks: share(params, "Ks", 0.25),
        kr: share(params, "Kr", 0.0),
        kt: share(params, "Kt", 0.0),
        roughness: Roughness::of_uber(params),
        eta: index_of_refraction(params),
        opacity: share(params, "opacity", 1.0),
    }
}
