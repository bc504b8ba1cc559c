//! Roughness of glossy surfaces, by the parameter names of each material.

use crate::schema::{FloatTexture, GivenTexture, Key};
use crate::texture::{Texture, TextureParams};

/// The roughness along the two directions of the texture coordinates.
#[derive(Debug, Clone)]
pub struct Roughness {
    /// Along u.
    pub u: Texture<f64>,
    /// Along v. `None` means the same as along u.
    pub v: Option<Texture<f64>>,
    /// If true, values from 0 to 1 are converted to the microfacet alpha by pbrt-v3's RoughnessToAlpha. If false,
    /// they are alpha (`remaproughness`, default true).
    pub remap: bool,
}

pub(super) const REMAP: Key<bool> = Key::bool(
    "remaproughness",
    true,
    "true converts roughness from 0 to 1 to the width of the microfacet distribution, false takes it as the width",
);

const ALONG_U: &str = "the roughness along the texture coordinate u, usually 0 to 1";
const ALONG_V: &str = "the roughness along the texture coordinate v, usually 0 to 1";

pub(super) const fn isotropic(default: f64) -> Key<FloatTexture> {
    Key::float_texture("roughness", default, "the roughness, usually 0 to 1")
}

pub(super) const fn along_u(default: f64) -> Key<FloatTexture> {
    Key::float_texture("uroughness", default, ALONG_U)
}

pub(super) const fn along_v(default: f64) -> Key<FloatTexture> {
    Key::float_texture("vroughness", default, ALONG_V)
}

pub(super) const GIVEN_U: Key<GivenTexture> =
    Key::given_texture("uroughness", ALONG_U).default_words("roughness");

pub(super) const fn given_v(default_words: &'static str) -> Key<GivenTexture> {
    Key::given_texture("vroughness", ALONG_V).default_words(default_words)
}

impl Roughness {
    /// `roughness` alone.
    pub(super) fn isotropic(params: &mut TextureParams, both: &Key<FloatTexture>) -> Self {
        let u = params.take_texture(both);
        let remap = remap(params, &[(both.name, Some(&u))]);
        Roughness { u, v: None, remap }
    }

    /// `uroughness` and `vroughness`.
    pub(super) fn of_two(params: &mut TextureParams, keys: [&Key<FloatTexture>; 2]) -> Self {
        let [u, v] = keys.map(|key| params.take_texture(key));
        let remap = remap(params, &[(keys[0].name, Some(&u)), (keys[1].name, Some(&v))]);
        Roughness { u, v: Some(v), remap }
    }

    /// `roughness`, which `uroughness` and `vroughness` each replace.
    pub(super) fn of_metal(
        params: &mut TextureParams,
        both: &Key<FloatTexture>,
        v: &Key<GivenTexture>,
    ) -> Self {
        let (both, [u, v], remap) = of_three(params, both, v);
        params.replaced_by("roughness", &["uroughness", "vroughness"]);
        let is_isotropic = u.is_none() && v.is_none();
        let v = v.unwrap_or_else(|| both.clone());
        Roughness { u: u.unwrap_or(both), v: (!is_isotropic).then_some(v), remap }
    }

    /// `roughness` or `uroughness` for u, and `vroughness` for v (default the same as u).
    pub(super) fn of_uber(
        params: &mut TextureParams,
        both: &Key<FloatTexture>,
        v: &Key<GivenTexture>,
    ) -> Self {
        let (both, [u, v], remap) = of_three(params, both, v);
        params.replaced_by("roughness", &["uroughness"]);
        Roughness { u: u.unwrap_or(both), v, remap }
    }
}

/// `roughness`, `uroughness` and `vroughness` if they are given, and `remaproughness`.
fn of_three(
    params: &mut TextureParams,
    both: &Key<FloatTexture>,
    v: &Key<GivenTexture>,
) -> (Texture<f64>, [Option<Texture<f64>>; 2], bool) {
    let first = params.take_texture(both);
    let [along_u, along_v] = [&GIVEN_U, v].map(|key| params.take_texture(key));
    let all = [(both.name, Some(&first)), (GIVEN_U.name, along_u.as_ref()), (v.name, along_v.as_ref())];
    let remap = remap(params, &all);
    (first, [along_u, along_v], remap)
}

/// Takes `remaproughness`, and warns of roughness outside 0 to 1. Negative values give the narrowest lobe, as in pbrt-v3.
/// A width above 1 is none that surprises: the conversion gives 1.62 for 1.
fn remap(params: &mut TextureParams, all: &[(&str, Option<&Texture<f64>>)]) -> bool {
    let remap = params.take(&REMAP);
    for (name, roughness) in all {
        let value = roughness.and_then(|roughness| roughness.constant()).unwrap_or(0.0);
        let (what, help) = if value < 0.0 {
            ("negative: the surface is almost smooth, as in pbrt-v3", "the usual range is 0 to 1")
        } else if value > 1.0 && remap {
            let help =
                "write a roughness from 0 to 1; if it is a width, add \"bool remaproughness\" \"false\"";
            ("above the usual range 0 to 1", help)
        } else {
            continue;
        };
        params.warn(name, &format!("{name} is {what}"), help);
    }
    remap
}
