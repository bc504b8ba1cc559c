//! `disney` as metal, glass and a diffuse surface under a gloss, mixed by `metallic` and `spectrans`; `thin` as `translucent`.
//! `sheen`, `clearcoat`, tints and `scatterdistance` are left out; textures of `metallic`, `spectrans` and `eta` count as their
//! defaults.

use std::sync::Arc;

use glam::Vec3;

use super::{constant, glossy, gray, scaled, share};
use crate::material::mix::count;
use crate::material::{Glass, Material, MaterialKind, Mix, Roughness, Translucent};
use crate::texture::{Texture, TextureParams};

/// An index so high that the surface reflects nearly all light in all directions, with the color of the metal.
const INDEX_OF_METAL: f64 = 1e4;

pub(super) fn disney(params: &mut TextureParams) -> (&'static str, MaterialKind) {
    let color = share(params, "color", 0.5);
    let [metallic, clear] = ["metallic", "spectrans"].map(|name| constant(params, name, 0.0).clamp(0.0, 1.0));
    let eta = constant(params, "eta", 1.5);
    let eta = if eta > 0.0 { eta } else { 1.5 };
    let roughness = roughness(params);
    if params.bool("thin", false) && metallic < 1.0 {
        let passes = (0.5 * constant(params, "difftrans", 1.0)).clamp(0.0, 1.0) as f32;
        let kd = scaled(color, Vec3::splat(((1.0 - metallic) * (1.0 - clear)) as f32));
        let [ks, reflect, transmit] = [0.0, 1.0 - passes, passes].map(gray);
        let sheet = MaterialKind::Translucent(Translucent { kd, ks, reflect, transmit, roughness });
        return ("\"translucent\" of its color", sheet);
    }
    let metal = glossy(gray(0.0), color.clone(), roughness.clone(), INDEX_OF_METAL);
    let diffuse = glossy(color.clone(), gray(1.0), roughness.clone(), eta);
    let kt = match color {
        Texture::Constant(color) => Texture::Constant(color.map(f32::sqrt)),
        varying => varying,
    };
    let glass = Glass { kr: gray(1.0), kt, roughness, eta: Texture::Constant(eta) };
    let dielectric = mixed(MaterialKind::Glass(glass), MaterialKind::Uber(Box::new(diffuse)), clear);
    let material = mixed(MaterialKind::Uber(Box::new(metal)), dielectric, metallic);
    let name = match (metallic, clear) {
        (0.0, 0.0) => "\"uber\" of its color, roughness and index",
        (1.0, _) => "\"uber\" with a metallic gloss of its color and roughness",
        (0.0, 1.0) => "\"glass\" of its color, roughness and index",
        _ => "a mix of metal, glass and \"uber\" of its color, roughness and index",
    };
    (name, material)
}

/// The width of the distribution of normals is the square of the roughness, wider along u where it is anisotropic.
fn roughness(params: &mut TextureParams) -> Roughness {
    let roughness = params.float_texture("roughness", 0.5);
    let aspect = (1.0 - 0.9 * constant(params, "anisotropic", 0.0).clamp(0.0, 1.0)).sqrt();
    match roughness {
        Texture::Constant(width) => {
            let [u, v] = [1.0 / aspect, aspect].map(|factor| Texture::Constant(width * width * factor));
            Roughness { u, v: Some(v), remap: false }
        }
        varying => {
            let u = Texture::product([varying.clone(), varying]);
            Roughness { u, v: None, remap: false }
        }
    }
}

/// Two materials, by the share of the first.
fn mixed(first: MaterialKind, second: MaterialKind, share: f64) -> MaterialKind {
    if share == 0.0 {
        return second;
    }
    if share == 1.0 {
        return first;
    }
    let materials = [first, second].map(|kind| Arc::new(Material::new(kind, None)));
    let count = materials.iter().map(|material| count(material)).sum();
    MaterialKind::Mix(Mix { materials, amount: gray(share as f32), count })
}
