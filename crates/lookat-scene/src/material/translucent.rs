//! `Material "translucent"`: diffuse and glossy, on both sides (PBR3 source, materials/translucent.cpp).

use glam::Vec3;

use super::{Roughness, share};
use crate::texture::{Texture, TextureParams};

/// A thin surface of index 1.5 that reflects and lets pass.
#[derive(Debug, Clone)]
pub struct Translucent {
    /// Share of the diffuse part (`Kd`, default 0.25).
    pub kd: Texture<Vec3>,
    /// Factor of the glossy part (`Ks`, default 0.25).
    pub ks: Texture<Vec3>,
    /// What of both is reflected (`reflect`, default 0.5).
    pub reflect: Texture<Vec3>,
    /// What of both passes (`transmit`, default 0.5).
    pub transmit: Texture<Vec3>,
    /// Of the gloss (`roughness`, default 0.1; `remaproughness`).
    pub roughness: Roughness,
}

pub(super) fn translucent(params: &mut TextureParams) -> Translucent {
    Translucent {
        kd: share(params, "Kd", 0.25),
        ks: share(params, "Ks", 0.25),
        reflect: share(params, "reflect", 0.5),
        transmit: share(params, "transmit", 0.5),
        roughness: Roughness::isotropic(params, 0.1),
    }
}
