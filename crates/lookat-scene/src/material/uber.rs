//! `Material "uber"`: diffuse, glossy, mirroring and clear at once (materials/uber.cpp).

use glam::Vec3;

use super::{Roughness, index_of_refraction, share};
use crate::texture::{Texture, TextureParams};

/// Diffuse, glossy, mirroring and clear at once.
#[derive(Debug, Clone)]
pub struct Uber {
    /// Share of the diffuse reflection (`Kd`, default 0.25).
    pub kd: Texture<Vec3>,
    /// Factor of the glossy reflection (`Ks`, default 0.25).
    pub ks: Texture<Vec3>,
    /// Factor of the mirror reflection (`Kr`, default 0).
    pub kr: Texture<Vec3>,
    /// Factor of refracted light (`Kt`, default 0).
    pub kt: Texture<Vec3>,
    /// Of the gloss (`roughness`, default 0.1, where `uroughness` is not given; `vroughness`, default the same as u;
    /// `remaproughness`).
    pub roughness: Roughness,
    /// Index of refraction behind the surface by that before it; more than 0 (`eta` or `index`, default 1.5).
    pub eta: Texture<f64>,
    /// The share of the surface that is there; light passes straight through the rest (`opacity`, default 1).
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
