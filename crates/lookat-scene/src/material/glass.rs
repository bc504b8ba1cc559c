//! `Material "glass"`: a surface between dielectrics that reflects and refracts as Fresnel's equations say (PBR 9.2.3
//! of the third edition's source).

use glam::Vec3;

use super::{Roughness, index_of_refraction, share};
use crate::texture::{Texture, TextureParams};

/// Smooth or rough glass.
#[derive(Debug, Clone)]
pub struct Glass {
    /// Factor of reflected light (`Kr`, default 1).
    pub kr: Texture<Vec3>,
    /// Factor of light that passes (`Kt`, default 1).
    pub kt: Texture<Vec3>,
    /// Smooth where both are 0 (`uroughness`, `vroughness`, default 0; `remaproughness`).
    pub roughness: Roughness,
    /// Index of refraction behind the surface by that before it, where its normal points; more than 0 (`eta` or `index`,
    /// default 1.5).
    pub eta: Texture<f64>,
}

pub(super) fn glass(params: &mut TextureParams) -> Glass {
    Glass {
        kr: share(params, "Kr", 1.0),
        kt: share(params, "Kt", 1.0),
        roughness: Roughness::of_two(params, 0.0),
        eta: index_of_refraction(params),
    }
}
