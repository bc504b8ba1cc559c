//! `Material "matte"`: Lambertian, or Oren-Nayar with a `sigma` above 0 (PBR 9.2.1).

use glam::Vec3;

use super::share;
use crate::texture::{Texture, TextureParams};

/// A diffuse surface.
#[derive(Debug, Clone)]
pub struct Matte {
    /// The diffuse reflectance (`Kd`, default 0.5).
    pub kd: Texture<Vec3>,
    /// The Oren-Nayar roughness: standard deviation of the facet angle in degrees, clamped to 0 to 90 (`sigma`,
    /// default 0).
    pub sigma: Texture<f64>,
}

pub(super) fn matte(params: &mut TextureParams) -> Matte {
    let kd = share(params, "Kd", 0.5);
    let sigma = params.float_texture("sigma", 0.0);
    if let Texture::Constant(degrees) = sigma
        && !(0.0..=90.0).contains(&degrees)
    {
        let message =
            format!("sigma is out of range: it is used as {}, as in pbrt-v3", degrees.clamp(0.0, 90.0));
        params.warn("sigma", &message, "use a sigma from 0 (smooth) to 90 degrees");
    }
    Matte { kd, sigma }
}
