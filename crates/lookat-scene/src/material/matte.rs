//! `Material "matte"`: Lambertian, or Oren-Nayar with a `sigma` above 0 (PBR 9.2.1).

use glam::Vec3;

use super::share;
use crate::schema::{ColorTexture, FloatTexture, Key, Keys, Unit};
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

const KD: Key<ColorTexture> = Key::color_texture("Kd", 0.5, "the diffuse reflectance");
const SIGMA: Key<FloatTexture> = Key::float_texture(
    "sigma",
    0.0,
    "the standard deviation of the facet angle (Oren-Nayar), clamped to 0 to 90; 0 is Lambertian",
)
.unit(Unit::Degrees);

pub(super) const KEYS: Keys = &[&KD, &SIGMA];

pub(super) fn matte(params: &mut TextureParams) -> Matte {
    let kd = share(params, &KD);
    let sigma = params.take_texture(&SIGMA);
    if let Texture::Constant(degrees) = sigma
        && !(0.0..=90.0).contains(&degrees)
    {
        let message =
            format!("sigma is out of range: it is used as {}, as in pbrt-v3", degrees.clamp(0.0, 90.0));
        params.warn("sigma", &message, "use a sigma from 0 (smooth) to 90 degrees");
    }
    Matte { kd, sigma }
}
