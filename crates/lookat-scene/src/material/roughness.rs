//! Roughness of glossy surfaces, by the parameter names of each material.

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

impl Roughness {
    /// `roughness` alone.
    pub(super) fn isotropic(params: &mut TextureParams, default: f64) -> Self {
        let u = given_or(params, "roughness", default);
        Roughness { u, v: None, remap: remap(params) }
    }

    /// `uroughness` and `vroughness`.
    pub(super) fn of_two(params: &mut TextureParams, default: f64) -> Self {
        let [u, v] = ["uroughness", "vroughness"].map(|name| given_or(params, name, default));
        Roughness { u, v: Some(v), remap: remap(params) }
    }

    /// `roughness`, which `uroughness` and `vroughness` each replace.
    pub(super) fn of_metal(params: &mut TextureParams, default: f64) -> Self {
        let both = given_or(params, "roughness", default);
        let [u, v] = ["uroughness", "vroughness"].map(|name| given(params, name));
        let is_isotropic = u.is_none() && v.is_none();
        let v = v.unwrap_or_else(|| both.clone());
        Roughness { u: u.unwrap_or(both), v: (!is_isotropic).then_some(v), remap: remap(params) }
    }

    /// `roughness` or `uroughness` for u, and `vroughness` for v (default the same as u).
    pub(super) fn of_uber(params: &mut TextureParams) -> Self {
        let both = given_or(params, "roughness", 0.1);
        let [u, v] = ["uroughness", "vroughness"].map(|name| given(params, name));
        Roughness { u: u.unwrap_or(both), v, remap: remap(params) }
    }
}

/// A roughness parameter, if given. Negative values give the narrowest lobe, as in pbrt-v3.
fn given(params: &mut TextureParams, name: &'static str) -> Option<Texture<f64>> {
    let roughness = params.float_texture_if_given(name)?;
    if let Texture::Constant(value) = roughness
        && value < 0.0
    {
        let message = format!("{name} is negative: the surface is almost smooth, as in pbrt-v3");
        params.warn(name, &message, "the usual range is 0 to 1");
    }
    Some(roughness)
}

fn given_or(params: &mut TextureParams, name: &'static str, default: f64) -> Texture<f64> {
    given(params, name).unwrap_or(Texture::Constant(default))
}

fn remap(params: &mut TextureParams) -> bool {
    params.bool("remaproughness", true)
}
