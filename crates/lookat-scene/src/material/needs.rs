//! The surface data that a material needs, so that others are not computed.

use super::{AnyTexture, MaterialKind, Roughness};
use crate::texture::{Texture, Value};

/// The data needed to shade a point, besides its normals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Needs {
    /// Texture coordinates and their derivatives, for textures, bump maps and anisotropic lobes.
    pub coordinates: bool,
    /// The texture footprint (ray differentials), for filtered textures.
    pub footprint: bool,
}

impl Needs {
    /// A surface without textures needs nothing.
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
