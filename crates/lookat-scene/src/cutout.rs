//! Alpha masks of meshes: `alpha` and `shadowalpha` of `trianglemesh` and `plymesh`.

use crate::schema::{FloatTexture, Key, Keys};
use crate::texture::{Texture, TextureParams};

/// The alpha masks of a mesh.
#[derive(Debug, Clone)]
pub struct Cutout {
    /// The mesh has holes where this is 0 (`alpha`).
    pub alpha: Option<Texture<f64>>,
    /// Shadow rays pass where this is 0 (`shadowalpha`).
    pub shadow_alpha: Option<Texture<f64>>,
}

const ALPHA: Key<FloatTexture> =
    Key::float_texture("alpha", 1.0, "the mesh has holes where this is 0; other values are opaque");
const SHADOW_ALPHA: Key<FloatTexture> =
    Key::float_texture("shadowalpha", 1.0, "shadow rays pass where this is 0, and where alpha is 0");

pub(crate) const CUTOUT: Keys = &[&ALPHA, &SHADOW_ALPHA];

/// The alpha masks of a mesh, if given.
pub(crate) fn cutout(params: &mut TextureParams) -> Option<Cutout> {
    let [alpha, shadow_alpha] = [&ALPHA, &SHADOW_ALPHA].map(|key| {
        // A constant other than 0 is opaque and needs no mask.
        Some(params.take_texture(key)).filter(|alpha| alpha.constant().is_none_or(|alpha| alpha == 0.0))
    });
    (alpha.is_some() || shadow_alpha.is_some()).then_some(Cutout { alpha, shadow_alpha })
}
