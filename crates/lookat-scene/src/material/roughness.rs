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
        Roughness { u: taken(params, both), v: None, remap: params.take(&REMAP) }
    }

    /// `uroughness` and `vroughness`.
    pub(super) fn of_two(params: &mut TextureParams, keys: [&Key<FloatTexture>; 2]) -> Self {
        let [u, v] = keys.map(|key| taken(params, key));
        Roughness { u, v: Some(v), remap: params.take(&REMAP) }
    }

    /// `roughness`, which `uroughness` and `vroughness` each replace.
    pub(super) fn of_metal(
        params: &mut TextureParams,
        both: &Key<FloatTexture>,
        v: &Key<GivenTexture>,
    ) -> Self {
        let (both, [u, v]) = of_three(params, both, v);
        params.replaced_by("roughness", &["uroughness", "vroughness"]);
        let is_isotropic = u.is_none() && v.is_none();
        let v = v.unwrap_or_else(|| both.clone());
        Roughness { u: u.unwrap_or(both), v: (!is_isotropic).then_some(v), remap: params.take(&REMAP) }
    }

    /// `roughness` or `uroughness` for u, and `vroughness` for v (default the same as u).
    pub(super) fn of_uber(
        params: &mut TextureParams,
        both: &Key<FloatTexture>,
        v: &Key<GivenTexture>,
    ) -> Self {
        let (both, [u, v]) = of_three(params, both, v);
        params.replaced_by("roughness", &["uroughness"]);
        Roughness { u: u.unwrap_or(both), v, remap: params.take(&REMAP) }
    }
}

/// `roughness`, and `uroughness` and `vroughness` if they are given.
fn of_three(
    params: &mut TextureParams,
    both: &Key<FloatTexture>,
    v: &Key<GivenTexture>,
) -> (Texture<f64>, [Option<Texture<f64>>; 2]) {
    let both = taken(params, both);
    (both, [&GIVEN_U, v].map(|key| given(params, key)))
}

fn given(params: &mut TextureParams, key: &Key<GivenTexture>) -> Option<Texture<f64>> {
    let roughness = params.take_texture(key)?;
    check(params, key.name, &roughness);
    Some(roughness)
}

fn taken(params: &mut TextureParams, key: &Key<FloatTexture>) -> Texture<f64> {
    let roughness = params.take_texture(key);
    check(params, key.name, &roughness);
    roughness
}

/// Negative values give the narrowest lobe, as in pbrt-v3.
fn check(params: &mut TextureParams, name: &str, roughness: &Texture<f64>) {
    if roughness.constant().is_some_and(|value| value < 0.0) {
        let message = format!("{name} is negative: the surface is almost smooth, as in pbrt-v3");
        params.warn(name, &message, "the usual range is 0 to 1");
    }
}
