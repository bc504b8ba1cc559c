//! `Material "mirror"`: a smooth mirror (PBR 9.2 of the source, materials/mirror.cpp).

use glam::Vec3;

use super::share;
use crate::texture::{Texture, TextureParams};

/// A smooth mirror.
#[derive(Debug, Clone)]
pub struct Mirror {
    /// Reflected share of light (`Kr`, default 0.9).
    pub kr: Texture<Vec3>,
}

pub(super) fn mirror(params: &mut TextureParams) -> Mirror {
    Mirror { kr: share(params, "Kr", 0.9) }
}
