//! `disney` as metal, glass and a diffuse surface under a gloss, mixed by `metallic` and `spectrans`. With `thin`, the glass has
//! index 1, and a translucent sheet replaces the diffuse surface. `sheen`, `clearcoat`, tints, `flatness` and `scatterdistance`
//! are left out.

use std::sync::Arc;

use glam::Vec3;

use super::{constant, glossy, gray, share};
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
    let is_thin = params.bool("thin", false);
    let metal = glossy(gray(0.0), color.clone(), roughness.clone(), INDEX_OF_METAL);
    let (clear_part, diffuse_part) = if is_thin {
        (thin_glass(color.clone()), sheet(params, color))
    } else {
        let diffuse = glossy(color.clone(), gray(1.0), roughness.clone(), eta);
        (glass(color, roughness, eta), MaterialKind::Uber(Box::new(diffuse)))
    };
    let dielectric = mixed(clear_part, diffuse_part, clear);
    let material = mixed(MaterialKind::Uber(Box::new(metal)), dielectric, metallic);
    (name(metallic, clear, is_thin), material)
}

fn name(metallic: f64, clear: f64, is_thin: bool) -> &'static str {
    match (metallic, clear, is_thin) {
        (1.0, ..) => "\"uber\" with a metallic gloss of the same color and roughness",
        (0.0, 0.0, false) => "\"uber\" with the same color, roughness and index",
        (0.0, 1.0, false) => "\"glass\" with the same color, roughness and index",
        (_, _, false) => "a mix of metal, glass and \"uber\" with the same color, roughness and index",
        (0.0, 0.0, true) => "\"translucent\" with the same color",
        (0.0, 1.0, true) => "smooth \"glass\" of index 1 with the same color",
        (_, _, true) => "a mix of metal, glass of index 1 and \"translucent\" with the same color",
    }
}

/// Glass that colors transmitted light by the square root of `color`: light enters and leaves a solid.
fn glass(color: Texture<Vec3>, roughness: Roughness, eta: f64) -> MaterialKind {
    let kt = match color {
        Texture::Constant(color) => Texture::Constant(color.map(f32::sqrt)),
        varying => varying,
    };
    MaterialKind::Glass(Glass { kr: gray(1.0), kt, roughness, eta: Texture::Constant(eta) })
}

/// The clear part of a thin sheet: light passes straight through.
fn thin_glass(color: Texture<Vec3>) -> MaterialKind {
    let smooth = Roughness { u: Texture::Constant(0.0), v: None, remap: false };
    glass(color, smooth, 1.0)
}

/// The diffuse part of a thin sheet: `difftrans` from 0 to 2 is twice the part that passes.
fn sheet(params: &mut TextureParams, kd: Texture<Vec3>) -> MaterialKind {
    let passes = (0.5 * constant(params, "difftrans", 1.0)).clamp(0.0, 1.0) as f32;
    let [ks, reflect, transmit] = [0.0, 1.0 - passes, passes].map(gray);
    let roughness = Roughness { u: Texture::Constant(1.0), v: None, remap: false };
    MaterialKind::Translucent(Translucent { kd, ks, reflect, transmit, roughness })
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

/// A mix of two materials. `amount`: the weight of the first, 0 to 1.
fn mixed(first: MaterialKind, second: MaterialKind, amount: f64) -> MaterialKind {
    if amount == 0.0 {
        return second;
    }
    if amount == 1.0 {
        return first;
    }
    let materials = [first, second].map(|kind| Arc::new(Material::new(kind, None)));
    let count = materials.iter().map(|material| count(material)).sum();
    MaterialKind::Mix(Mix { materials, amount: gray(amount as f32), count })
}
