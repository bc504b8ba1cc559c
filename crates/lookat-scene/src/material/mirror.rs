//! `Material "mirror"`: a smooth mirror (PBR 9.2 of the source, materials/mirror.cpp).

use glam::Vec3;

use super::share;
use crate::params::Params;
use crate::texture::Texture;

/// A smooth mirror.
#[derive(Debug, Clone)]
pub struct Mirror {
    /// Reflected share of light (`Kr`, default 0.9).
    pub kr: Texture<Vec3>,
}

pub(super) fn mirror(params: &mut Params) -> Mirror {
    Mirror { kr: share(params, "Kr", 0.9) }
}
