//! Alpha masks of meshes: `alpha` and `shadowalpha` of `trianglemesh` and `plymesh`.
//!
//! - `alpha`: float texture or number, default 1: the mesh has holes where it is 0
//! - `shadowalpha`: the same for shadow rays only, in addition to `alpha`

use crate::texture::{Texture, TextureParams};

/// The alpha masks of a mesh.
#[derive(Debug, Clone)]
pub struct Cutout {
    /// The mesh has holes where this is 0 (`alpha`).
    pub alpha: Option<Texture<f64>>,
    /// Shadow rays pass where this is 0 (`shadowalpha`).
    pub shadow_alpha: Option<Texture<f64>>,
}

/// The alpha masks of a mesh, if given.
pub(crate) fn cutout(params: &mut TextureParams) -> Option<Cutout> {
    let [alpha, shadow_alpha] = ["alpha", "shadowalpha"].map(|name| {
        // A constant other than 0 is opaque and needs no mask.
        params.float_texture_if_given(name).filter(|alpha| alpha.constant().is_none_or(|alpha| alpha == 0.0))
    });
    (alpha.is_some() || shadow_alpha.is_some()).then_some(Cutout { alpha, shadow_alpha })
}
