//! Materials of pbrt-v3 that are not rendered, and what stands in for them.
//!
//! - `hair`: matte of its `color`
//! - `disney`: a substrate of its `color` and `roughness`
//! - `subsurface`: white plastic
//! - `kdsubsurface`: plastic with its `Kd`
//! - `fourier`: grey matte

use glam::Vec3;

use super::{MaterialKind, Matte, Plastic, Roughness, Substrate, share};
use crate::texture::{Texture, TextureParams};

pub(super) fn stand_in(params: &mut TextureParams) -> MaterialKind {
    let (stand_in, material) = match params.kind() {
        "disney" => ("a substrate, neither metallic nor clear, with its color and roughness", disney(params)),
        "hair" => ("matte with its color", matte(share(params, "color", 0.3))),
        "kdsubsurface" => {
            let kd = share(params, "Kd", 0.5);
            ("plastic with its Kd", plastic(params, kd))
        }
        "subsurface" => ("white plastic", plastic(params, gray(0.8))),
        _ => ("grey matte", matte(gray(0.5))),
    };
    let message = format!("Material \"{}\" is not rendered; {stand_in} stands in for it", params.kind());
    params.unsupported(message);
    material
}

fn gray(share: f32) -> Texture<Vec3> {
    Texture::Constant(Vec3::splat(share))
}

fn matte(kd: Texture<Vec3>) -> MaterialKind {
    MaterialKind::Matte(Matte { kd, sigma: Texture::Constant(0.0) })
}

/// The gloss of a dielectric of index 1.5 on something diffuse.
fn plastic(params: &mut TextureParams, kd: Texture<Vec3>) -> MaterialKind {
    MaterialKind::Plastic(Plastic { kd, ks: gray(1.0), roughness: Roughness::isotropic(params, 0.1) })
}

fn disney(params: &mut TextureParams) -> MaterialKind {
    let kd = share(params, "color", 0.5);
    // What a dielectric of index 1.5 reflects along the normal.
    MaterialKind::Substrate(Substrate { kd, ks: gray(0.04), roughness: Roughness::isotropic(params, 0.5) })
}
