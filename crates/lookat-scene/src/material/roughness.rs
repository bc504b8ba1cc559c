//! Roughness of glossy surfaces, by the names that the materials have for it.

use crate::texture::{Texture, TextureParams};

/// How rough a surface is along the two directions of its texture coordinates.
#[derive(Debug, Clone)]
pub struct Roughness {
    /// Along u.
    pub u: Texture<f64>,
    /// Along v; the same as along u where there is none.
    pub v: Option<Texture<f64>>,
    /// Both are from 0 to 1 and become the width of the distribution of normals by pbrt-v3's RoughnessToAlpha; else they
    /// are that width (`remaproughness`, default true).
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

    /// `roughness`, and `uroughness` and `vroughness` each in place of it.
    pub(super) fn of_metal(params: &mut TextureParams, default: f64) -> Self {
        let both = given_or(params, "roughness", default);
        let [u, v] = ["uroughness", "vroughness"].map(|name| given(params, name));
        let is_isotropic = u.is_none() && v.is_none();
        let v = v.unwrap_or_else(|| both.clone());
        Roughness { u: u.unwrap_or(both), v: (!is_isotropic).then_some(v), remap: remap(params) }
    }

    /// `roughness`, or `uroughness` in place of it, and `vroughness` in place of that.
    pub(super) fn of_uber(params: &mut TextureParams) -> Self {
        let both = given_or(params, "roughness", 0.1);
        let [u, v] = ["uroughness", "vroughness"].map(|name| given(params, name));
        Roughness { u: u.unwrap_or(both), v, remap: remap(params) }
    }
}

/// Roughness by a name, where it is given. Below 0, as in pbrt-v3, lobes are as narrow as they can be.
fn given(params: &mut TextureParams, name: &'static str) -> Option<Texture<f64>> {
    let roughness = params.float_texture_if_given(name)?;
    if let Texture::Constant(value) = roughness
        && value < 0.0
    {
        let message = format!("{name} is below 0: the surface is almost smooth, as in pbrt-v3");
        params.warn(name, &message, "it is mostly between 0 and 1");
    }
    Some(roughness)
}

fn given_or(params: &mut TextureParams, name: &'static str, default: f64) -> Texture<f64> {
    given(params, name).unwrap_or(Texture::Constant(default))
}

fn remap(params: &mut TextureParams) -> bool {
    params.bool("remaproughness", true)
}
