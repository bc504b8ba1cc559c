//! `Material "translucent"`: diffuse and glossy reflection and transmission (materials/translucent.cpp).

use glam::Vec3;

use super::{Roughness, share};
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

pub(super) fn translucent(params: &mut TextureParams) -> Translucent {
    Translucent {
        kd: share(params, "Kd", 0.25),
        ks: share(params, "Ks", 0.25),
        reflect: share(params, "reflect", 0.5),
        transmit: share(params, "transmit", 0.5),
        roughness: Roughness::isotropic(params, 0.1),
    }
}
