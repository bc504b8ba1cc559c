//! Materials of pbrt-v3 that are not rendered, and what stands in for them.
//!
//! - `hair`: matte of its `color`
//! - `disney`: a substrate of its `color` and `roughness`
//! - `subsurface`: a grey substrate
//! - `kdsubsurface`: a substrate of its `Kd`
//! - `fourier`: grey matte

use glam::Vec3;

use super::{MaterialKind, Matte, Roughness, Substrate, share};
use crate::texture::{Texture, TextureParams};

pub(super) fn stand_in(params: &mut TextureParams) -> MaterialKind {
    let (stand_in, material) = match params.kind() {
        "disney" => {
            let kd = share(params, "color", 0.5);
            let stand_in = "a substrate, neither metallic nor clear, with its color and roughness";
            (stand_in, substrate(params, kd, 0.04, 0.5))
        }
        "hair" => ("matte with its color", matte(share(params, "color", 0.3))),
        "kdsubsurface" => {
            let kd = share(params, "Kd", 0.5);
            ("a substrate with its Kd", substrate(params, kd, 0.02, 0.1))
        }
        "subsurface" => ("a grey substrate", substrate(params, gray(0.6), 0.02, 0.1)),
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

/// The gloss of a dielectric on something diffuse, which reflects no more than it gets. `ks`: what it reflects along the
/// normal, 0.04 for an index of 1.5 and 0.02 for 1.33.
fn substrate(params: &mut TextureParams, kd: Texture<Vec3>, ks: f32, roughness: f64) -> MaterialKind {
    let roughness = Roughness::isotropic(params, roughness);
    MaterialKind::Substrate(Substrate { kd, ks: gray(ks), roughness })
}
