//! Stand-ins for unsupported materials: the nearest supported material with the same mean color.

mod diffusion;
pub(super) mod disney;
pub(super) mod fourier;
pub(super) mod hair;
mod media;
pub(super) mod subsurface;

use glam::Vec3;

use super::{MaterialKind, Matte, Roughness, Uber, share};
use crate::schema::{ColorTexture, FloatTexture, Key};
use crate::texture::{Texture, TextureParams, Value};

pub(super) fn stand_in(params: &mut TextureParams) -> MaterialKind {
    let (replacement, material) = match params.kind() {
        "disney" => disney::disney(params),
        "hair" => ("\"matte\" with the same color", matte(hair::color(params))),
        "kdsubsurface" => ("\"uber\" with the same Kd and index", subsurface::of_color(params)),
        "subsurface" => (
            "\"uber\" with the same index and the diffuse color of the coefficients",
            subsurface::of_coefficients(params),
        ),
        _ => fourier::fourier(params),
    };
    let message =
        format!("lookat does not support Material \"{}\": it renders {replacement} instead", params.kind());
    params.unsupported(message);
    material
}

/// A number. Warns of a texture, and returns the default.
fn constant(params: &mut TextureParams, key: &Key<FloatTexture>) -> f64 {
    let texture = params.take_texture(key);
    constant_or(params, key.name, texture, key.default.0)
}

/// A color of 0 or more. Warns of a texture, and returns the default.
fn constant_color(params: &mut TextureParams, key: &Key<ColorTexture>) -> Vec3 {
    let texture = params.take_texture(key);
    constant_or(params, key.name, texture, key.default.0).max(Vec3::ZERO)
}

fn constant_or<T: Value>(params: &mut TextureParams, name: &str, texture: Texture<T>, default: T) -> T {
    texture.constant().unwrap_or_else(|| {
        let message = format!("lookat ignores this texture of {name}: it uses the default value");
        params.warn(name, &message, &format!("write {name} without a texture"));
        default
    })
}

/// A polynomial in `x`. Its coefficients begin with the highest power.
fn polynomial<const N: usize>(coefficients: [f64; N], x: f64) -> f64 {
    coefficients.iter().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

fn gray(value: f32) -> Texture<Vec3> {
    Texture::Constant(Vec3::splat(value))
}

fn matte(kd: Texture<Vec3>) -> MaterialKind {
    MaterialKind::Matte(Matte { kd, sigma: Texture::Constant(0.0) })
}

/// A diffuse surface under a rough gloss of the given index.
fn glossy(kd: Texture<Vec3>, ks: Texture<Vec3>, roughness: Roughness, eta: f64) -> Uber {
    let [kr, kt] = [gray(0.0), gray(0.0)];
    Uber { kd, ks, kr, kt, roughness, eta: Texture::Constant(eta), opacity: gray(1.0) }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// The material of a sphere after a directive.
    fn material(directive: &str) -> MaterialKind {
        let scene = format!("WorldBegin\n{directive}\nShape \"sphere\"\nWorldEnd");
        let read = |_: &Path| Ok(scene.clone().into_bytes());
        let loaded = crate::load(Path::new("a.pbrt"), &read, &Default::default());
        loaded.scene.unwrap().world.primitives[0].material.kind.clone()
    }

    #[track_caller]
    fn diffuse(directive: &str) -> Vec3 {
        match material(directive) {
            MaterialKind::Matte(matte) => matte.kd.constant().unwrap(),
            MaterialKind::Uber(uber) => uber.kd.constant().unwrap(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn media_have_the_color_of_their_coefficients() {
        let ketchup = diffuse("Material \"subsurface\" \"string name\" \"Ketchup\" \"float eta\" 1.3");
        assert!(ketchup.x < 0.2 && ketchup.x > 10.0 * ketchup.z, "{ketchup}");
        let black = diffuse("Material \"subsurface\" \"rgb sigma_s\" [0 0 0]");
        assert_eq!(black, Vec3::ZERO);
        let kd = diffuse("Material \"kdsubsurface\" \"rgb Kd\" [0.8 0.4 0.2]");
        assert!(kd.y > 0.36 && kd.y < 0.4 && (kd.x - 2.0 * kd.y).abs() < 1e-6, "{kd}");
    }

    #[test]
    fn hair_has_the_color_of_its_absorption() {
        let color = Vec3::new(0.8, 0.4, 0.2);
        assert_eq!(diffuse("Material \"hair\" \"rgb color\" [0.8 0.4 0.2]"), color);
        // SigmaAFromReflectance of pbrt-v3, at its default beta_n of 0.3.
        let f = 5.969 - 0.215 * 0.3 + 2.532 * 0.09 - 10.73 * 0.027 + 5.574 * 0.0081 + 0.245 * 0.00243_f32;
        let [r, g, b] = color.to_array().map(|channel| (channel.ln() / f).powi(2));
        let back = diffuse(&format!("Material \"hair\" \"rgb sigma_a\" [{r} {g} {b}]"));
        assert!((back - color).abs().max_element() < 1e-4, "{back}");
        let brown = diffuse("Material \"hair\"");
        assert!(brown.x > brown.y && brown.y > brown.z && brown.x < 0.1, "{brown}");
    }

    #[test]
    fn disney_is_metal_by_its_share() {
        assert_eq!(diffuse("Material \"disney\" \"rgb color\" [1 0.5 0]"), Vec3::new(1.0, 0.5, 0.0));
        let MaterialKind::Uber(metal) =
            material("Material \"disney\" \"float metallic\" 1 \"rgb color\" [1 0.5 0]")
        else {
            panic!("metal is one material");
        };
        assert_eq!(metal.kd.constant(), Some(Vec3::ZERO));
        assert_eq!(metal.ks.constant(), Some(Vec3::new(1.0, 0.5, 0.0)));
        let MaterialKind::Mix(mix) =
            material("Material \"disney\" \"float metallic\" 0.5 \"float spectrans\" 0.5")
        else {
            panic!("several shares are a mix");
        };
        assert_eq!((mix.parts(), mix.amount.constant()), (3, Some(Vec3::splat(0.5))));
    }
}
