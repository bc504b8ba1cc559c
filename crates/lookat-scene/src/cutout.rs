//! Holes of meshes: `alpha` and `shadowalpha` of `trianglemesh` and `plymesh`.
//!
//! - `alpha`: float texture or number, default 1: where it is 0, there is nothing
//! - `shadowalpha`: the same, for shadow rays alone and besides `alpha`

use crate::texture::{Texture, TextureParams};

/// Where a mesh has holes.
#[derive(Debug, Clone)]
pub struct Cutout {
    /// Where it is 0, there is nothing (`alpha`).
    pub alpha: Option<Texture<f64>>,
    /// Where it is 0, light passes on its way to a surface (`shadowalpha`).
    pub shadow_alpha: Option<Texture<f64>>,
}

/// The holes of a mesh, if it may have any.
pub(crate) fn cutout(params: &mut TextureParams) -> Option<Cutout> {
    let [alpha, shadow_alpha] = ["alpha", "shadowalpha"].map(|name| {
        // What is not 0 is there, however small.
        params.float_texture_if_given(name).filter(|alpha| alpha.constant().is_none_or(|alpha| alpha == 0.0))
    });
    (alpha.is_some() || shadow_alpha.is_some()).then_some(Cutout { alpha, shadow_alpha })
}
