//! Alpha masks of meshes: `alpha` and `shadowalpha` of `trianglemesh` and `plymesh`.
//!
//! - `alpha`: float texture or number, default 1: where it is 0, there is nothing
//! - `shadowalpha`: the same, for shadow rays alone and besides `alpha`

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
        // Any value except 0 is opaque.
        params.float_texture_if_given(name).filter(|alpha| alpha.constant().is_none_or(|alpha| alpha == 0.0))
    });
    (alpha.is_some() || shadow_alpha.is_some()).then_some(Cutout { alpha, shadow_alpha })
}
