//! `Material "matte"`: diffuse, by Lambert or, where `sigma` is not 0, by Oren and Nayar (PBR 9.2.1).

use glam::Vec3;

use super::share;
use crate::texture::{Texture, TextureParams};

/// A diffuse surface.
#[derive(Debug, Clone)]
pub struct Matte {
    /// Reflected share of light (`Kd`, default 0.5).
    pub kd: Texture<Vec3>,
    /// Spread of the slopes of the facets, in degrees, used from 0 to 90 (`sigma`, default 0).
    pub sigma: Texture<f64>,
}

pub(super) fn matte(params: &mut TextureParams) -> Matte {
    let kd = share(params, "Kd", 0.5);
    let sigma = params.float_texture("sigma", 0.0);
    if let Texture::Constant(degrees) = sigma
        && !(0.0..=90.0).contains(&degrees)
    {
        let message = format!("sigma counts as {}, as in pbrt-v3", degrees.clamp(0.0, 90.0));
        params.warn("sigma", &message, "it goes from 0, which is smooth, to 90 degrees");
    }
    Matte { kd, sigma }
}
