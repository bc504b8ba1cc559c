//! Stand-ins for unsupported materials: the nearest supported material with the same mean color.

mod disney;
mod fourier;
mod media;
mod subsurface;

use glam::Vec3;

use super::{MaterialKind, Matte, Roughness, Uber, share};
use crate::texture::{Texture, TextureParams};

pub(super) fn stand_in(params: &mut TextureParams) -> MaterialKind {
    let (replacement, material) = match params.kind() {
        "disney" => disney::disney(params),
        "hair" => ("\"matte\" of its color", matte(hair_color(params))),
        "kdsubsurface" => ("\"uber\" of its Kd and index", subsurface::of_color(params)),
        "subsurface" => (
            "\"uber\" of its index and the diffuse color of its coefficients",
            subsurface::of_coefficients(params),
        ),
        _ => fourier::fourier(params),
    };
    let message = format!("Material \"{}\" is not rendered: {replacement} replaces it", params.kind());
    params.unsupported(message);
    material
}

/// The color of a mass of hair by its absorption, and the other way round, after Chiang et al. 2016 (HairBSDF in
/// materials/hair.cpp).
fn hair_color(params: &mut TextureParams) -> Texture<Vec3> {
    const EUMELANIN: Vec3 = Vec3::new(0.419, 0.697, 1.37);
    const PHEOMELANIN: Vec3 = Vec3::new(0.187, 0.4, 1.05);
    let color = share(params, "color", 0.0);
    let absorption = constant_color(params, "sigma_a", Vec3::ZERO);
    let [eumelanin, pheomelanin] = ["eumelanin", "pheomelanin"].map(|name| constant(params, name, 0.0));
    let beta = constant(params, "beta_n", 0.3);
    let absorption = if params.was_taken("sigma_a") {
        absorption
    } else if params.was_taken("color") {
        return color;
    } else if params.was_taken("eumelanin") || params.was_taken("pheomelanin") {
        eumelanin.max(0.0) as f32 * EUMELANIN + pheomelanin.max(0.0) as f32 * PHEOMELANIN
    } else {
        1.3 * EUMELANIN
    };
    let of_beta =
        [0.245, 5.574, -10.73, 2.532, -0.215, 5.969].iter().fold(0.0, |sum, term| sum * beta + term);
    let channel = |absorption: f32| (-absorption.max(0.0).sqrt() * of_beta as f32).exp();
    Texture::Constant(Vec3::from_array(absorption.to_array().map(channel)))
}

/// A number; of a texture, the default.
fn constant(params: &mut TextureParams, name: &'static str, default: f64) -> f64 {
    params.float_texture(name, default).constant().unwrap_or(default)
}

/// A color of 0 or more; of a texture, the default.
fn constant_color(params: &mut TextureParams, name: &'static str, default: Vec3) -> Vec3 {
    params.spectrum_texture(name, default).constant().unwrap_or(default).max(Vec3::ZERO)
}

/// A texture times a color.
fn scaled(texture: Texture<Vec3>, factor: Vec3) -> Texture<Vec3> {
    Texture::product([Texture::Constant(factor), texture])
}

fn gray(share: f32) -> Texture<Vec3> {
    Texture::Constant(Vec3::splat(share))
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
        loaded.scene.unwrap().primitives[0].material.kind.clone()
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
        assert_eq!((mix.count, mix.amount.constant()), (3, Some(Vec3::splat(0.5))));
    }
}
