//! What a material asks of the surface that it is on, so that others are not asked.

use glam::Vec3;

use super::{MaterialKind, Roughness};
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
        match kind {
            MaterialKind::Matte(matte) => {
                needs.colors(&[&matte.kd]);
                needs.texture(&matte.sigma);
            }
            MaterialKind::Plastic(plastic) => {
                needs.colors(&[&plastic.kd, &plastic.ks]);
                needs.roughness(&plastic.roughness);
            }
            MaterialKind::Translucent(this) => {
                needs.colors(&[&this.kd, &this.ks, &this.reflect, &this.transmit]);
                needs.roughness(&this.roughness);
            }
            MaterialKind::Glass(glass) => {
                needs.colors(&[&glass.kr, &glass.kt]);
                needs.roughness(&glass.roughness);
                needs.texture(&glass.eta);
            }
            MaterialKind::Mirror(mirror) => needs.colors(&[&mirror.kr]),
            MaterialKind::Metal(metal) => {
                needs.colors(&[&metal.eta, &metal.k]);
                needs.roughness(&metal.roughness);
            }
            MaterialKind::Substrate(substrate) => {
                needs.colors(&[&substrate.kd, &substrate.ks]);
                needs.roughness(&substrate.roughness);
            }
            MaterialKind::Uber(uber) => {
                needs.colors(&[&uber.kd, &uber.ks, &uber.kr, &uber.kt, &uber.opacity]);
                needs.roughness(&uber.roughness);
                needs.texture(&uber.eta);
            }
            MaterialKind::Mix(mix) => {
                needs.colors(&[&mix.amount]);
                mix.materials.iter().for_each(|material| needs.add(material.needs));
            }
            MaterialKind::None => {}
        }
        needs
    }

    fn add(&mut self, other: Needs) {
        self.coordinates |= other.coordinates;
        self.footprint |= other.footprint;
    }

    fn colors(&mut self, textures: &[&Texture<Vec3>]) {
        textures.iter().for_each(|texture| self.texture(texture));
    }

    fn texture<T: Value>(&mut self, texture: &Texture<T>) {
        self.coordinates |= texture.constant().is_none();
        self.footprint |= texture.is_filtered();
    }

    fn roughness(&mut self, roughness: &Roughness) {
        self.texture(&roughness.u);
        let Some(v) = &roughness.v else { return };
        self.texture(v);
        self.coordinates |= roughness.u.constant() != v.constant();
    }
}
