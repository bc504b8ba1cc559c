//! `Material "mirror"`: a perfect mirror (materials/mirror.cpp).

use glam::Vec3;

use super::share;
use crate::schema::{ColorTexture, Key, Keys};
use crate::texture::{Texture, TextureParams};

/// A perfect mirror.
#[derive(Debug, Clone)]
pub struct Mirror {
    /// The reflectance (`Kr`, default 0.9).
    pub kr: Texture<Vec3>,
}

const KR: Key<ColorTexture> = Key::color_texture("Kr", 0.9, "the reflectance");

pub(super) const KEYS: Keys = &[&KR];

pub(super) fn mirror(params: &mut TextureParams) -> Mirror {
    Mirror { kr: share(params, &KR) }
}
