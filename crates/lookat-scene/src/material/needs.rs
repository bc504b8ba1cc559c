//! What a material asks of the surface that it is on, so that others are not asked.

use super::{AnyTexture, MaterialKind, Roughness};
use crate::texture::{Texture, Value};

/// What must be known of a point to shade it, beyond its normals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Needs {
    /// Texture coordinates and their directions: it varies, is bent, or shines differently along them.
    pub coordinates: bool,
    /// The distance to the points that neighbouring rays see: its textures are filtered.
    pub footprint: bool,
}

impl Needs {
    /// Of a surface that is everywhere alike.
    pub const NOTHING: Needs = Needs { coordinates: false, footprint: false };

    pub(super) fn of(kind: &MaterialKind, bump: Option<&Texture<f64>>) -> Self {
        let mut needs = Needs { coordinates: bump.is_some(), footprint: bump.is_some() };
        for texture in kind.textures() {
            match texture {
                AnyTexture::Number(texture) => needs.texture(texture),
                AnyTexture::Color(texture) => needs.texture(texture),
            }
        }
        if let Some(Roughness { u, v: Some(v), .. }) = kind.roughness() {
            needs.coordinates |= u.constant() != v.constant();
        }
        if let MaterialKind::Mix(mix) = kind {
            mix.materials.iter().for_each(|material| needs.add(material.needs));
        }
        needs
    }

    fn add(&mut self, other: Needs) {
        self.coordinates |= other.coordinates;
        self.footprint |= other.footprint;
    }

    fn texture<T: Value>(&mut self, texture: &Texture<T>) {
        self.coordinates |= texture.constant().is_none();
        self.footprint |= texture.is_filtered();
    }
}
