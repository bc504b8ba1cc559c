//! `disney` as metal, glass and a diffuse surface under a gloss, mixed by `metallic` and `spectrans`. With `thin`, the glass has
//! index 1, and a translucent sheet replaces the diffuse surface. `sheen`, `clearcoat`, tints, `flatness` and `scatterdistance`
//! are left out.

use std::sync::Arc;

use glam::Vec3;

use super::{constant, constant_or, glossy, gray, share};
use crate::material::{Glass, Material, MaterialKind, Mix, Roughness, Translucent};
use crate::schema::{ColorTexture, Effect, FloatTexture, Key, Keys};
use crate::texture::{Texture, TextureParams, product};

/// An index so high that the surface reflects nearly all light in all directions, with the color of the metal.
const INDEX_OF_METAL: f64 = 1e4;

const COLOR: Key<ColorTexture> = Key::color_texture("color", 0.5, "the color");
const METALLIC: Key<FloatTexture> =
    Key::float_texture("metallic", 0.0, "the share of metal, clamped to 0 to 1");
const ETA: Key<FloatTexture> =
    Key::float_texture("eta", 1.5, "the index of refraction; 0 and less count as 1.5");
const ROUGHNESS: Key<FloatTexture> =
    Key::float_texture("roughness", 0.5, "the roughness, the square root of the width of the gloss");
const ANISOTROPIC: Key<FloatTexture> =
    Key::float_texture("anisotropic", 0.0, "how much wider the gloss is along u, clamped to 0 to 1");
const SPEC_TRANS: Key<FloatTexture> =
    Key::float_texture("spectrans", 0.0, "the share of glass in the rest, clamped to 0 to 1");
const THIN: Key<bool> = Key::bool("thin", false, "true renders a thin sheet, false a solid");
const DIFF_TRANS: Key<FloatTexture> = Key::float_texture(
    "difftrans",
    1.0,
    "twice the fraction of diffuse light that a thin sheet transmits, clamped to 0 to 2",
);

const fn left_out(name: &'static str, default: f64, meaning: &'static str) -> Key<FloatTexture> {
    Key::float_texture(name, default, meaning).effect(Effect::NotRendered)
}

const SPECULAR_TINT: Key<FloatTexture> =
    left_out("speculartint", 0.0, "how much the gloss takes on the color");
const SHEEN: Key<FloatTexture> = left_out("sheen", 0.0, "the reflection of fabric at grazing angles");
const SHEEN_TINT: Key<FloatTexture> = left_out("sheentint", 0.5, "how much the sheen takes on the color");
const CLEARCOAT: Key<FloatTexture> = left_out("clearcoat", 0.0, "the strength of a second gloss");
const CLEARCOAT_GLOSS: Key<FloatTexture> =
    left_out("clearcoatgloss", 1.0, "the smoothness of the second gloss");
const FLATNESS: Key<FloatTexture> =
    left_out("flatness", 0.0, "the share of scattering inside a thin sheet in diffuse light");
const SCATTER_DISTANCE: Key<ColorTexture> =
    Key::color_texture("scatterdistance", 0.0, "the mean free path of light inside a solid")
        .effect(Effect::NotRendered);

pub(in crate::material) const KEYS: Keys = &[
    &COLOR,
    &METALLIC,
    &ETA,
    &ROUGHNESS,
    &ANISOTROPIC,
    &SPEC_TRANS,
    &THIN,
    &DIFF_TRANS,
    &SPECULAR_TINT,
    &SHEEN,
    &SHEEN_TINT,
    &CLEARCOAT,
    &CLEARCOAT_GLOSS,
    &FLATNESS,
    &SCATTER_DISTANCE,
];

pub(super) fn disney(params: &mut TextureParams) -> (&'static str, MaterialKind) {
    let color = share(params, &COLOR);
    let [metallic, clear] = [&METALLIC, &SPEC_TRANS].map(|key| constant(params, key).clamp(0.0, 1.0));
    let eta = constant(params, &ETA);
    let eta = if eta > 0.0 { eta } else { ETA.default.0 };
    let roughness = roughness(params);
    let is_thin = params.take(&THIN);
    let difftrans = params.take_texture(&DIFF_TRANS);
    let metal = glossy(gray(0.0), color.clone(), roughness.clone(), INDEX_OF_METAL);
    let (clear_part, diffuse_part) = if is_thin {
        (thin_glass(color.clone()), sheet(params, color, difftrans))
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
fn sheet(params: &mut TextureParams, kd: Texture<Vec3>, difftrans: Texture<f64>) -> MaterialKind {
    let difftrans = constant_or(params, DIFF_TRANS.name, difftrans, DIFF_TRANS.default.0);
    let passes = (0.5 * difftrans).clamp(0.0, 1.0) as f32;
    let [ks, reflect, transmit] = [0.0, 1.0 - passes, passes].map(gray);
    let roughness = Roughness { u: Texture::Constant(1.0), v: None, remap: false };
    MaterialKind::Translucent(Translucent { kd, ks, reflect, transmit, roughness })
}

/// The width of the distribution of normals is the square of the roughness, wider along u where it is anisotropic.
fn roughness(params: &mut TextureParams) -> Roughness {
    let roughness = params.take_texture(&ROUGHNESS);
    let aspect = (1.0 - 0.9 * constant(params, &ANISOTROPIC).clamp(0.0, 1.0)).sqrt();
    match roughness {
        Texture::Constant(width) => {
            let [u, v] = [1.0 / aspect, aspect].map(|factor| (width * width * factor).min(f64::MAX));
            let [u, v] = [u, v].map(Texture::Constant);
            Roughness { u, v: Some(v), remap: false }
        }
        varying => {
            let u = product(params, [varying.clone(), varying]);
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
    MaterialKind::Mix(Mix { materials, amount: gray(amount as f32) })
}
