//! `Material "mirror"`: a perfect mirror (materials/mirror.cpp).

use glam::Vec3;

use super::share;
use crate::texture::{Texture, TextureParams};

/// A perfect mirror.
#[derive(Debug, Clone)]
pub struct Mirror {
    /// The reflectance (`Kr`, default 0.9).
    pub kr: Texture<Vec3>,
}

pub(super) fn mirror(params: &mut TextureParams) -> Mirror {
    Mirror { kr: share(params, "Kr", 0.9) }
}
