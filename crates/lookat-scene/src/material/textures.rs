//! The textures of any material.

use glam::Vec3;

use super::{MaterialKind, Roughness};
use crate::texture::Texture;

/// A texture of numbers or of colors.
#[derive(Debug, Clone, Copy)]
pub enum AnyTexture<'t> {
    /// Of numbers.
    Number(&'t Texture<f64>),
    /// Of colors.
    Color(&'t Texture<Vec3>),
}

impl MaterialKind {
    /// The textures of this material, without textures of the parts of a mix.
    pub fn textures(&self) -> Vec<AnyTexture<'_>> {
        let (colors, number): (Vec<&Texture<Vec3>>, _) = match self {
            MaterialKind::Matte(matte) => (vec![&matte.kd], Some(&matte.sigma)),
            MaterialKind::Plastic(plastic) => (vec![&plastic.kd, &plastic.ks], None),
            MaterialKind::Translucent(this) => {
                (vec![&this.kd, &this.ks, &this.reflect, &this.transmit], None)
            }
            MaterialKind::Glass(glass) => (vec![&glass.kr, &glass.kt], Some(&glass.eta)),
            MaterialKind::Mirror(mirror) => (vec![&mirror.kr], None),
            MaterialKind::Metal(metal) => (vec![&metal.eta, &metal.k], None),
            MaterialKind::Substrate(substrate) => (vec![&substrate.kd, &substrate.ks], None),
            MaterialKind::Uber(uber) => {
                (vec![&uber.kd, &uber.ks, &uber.kr, &uber.kt, &uber.opacity], Some(&uber.eta))
            }
            MaterialKind::Mix(mix) => (vec![&mix.amount], None),
            MaterialKind::None => (vec![], None),
        };
        let widths = self.roughness().into_iter().flat_map(|it| std::iter::once(&it.u).chain(&it.v));
        let numbers = number.into_iter().chain(widths).map(AnyTexture::Number);
        colors.into_iter().map(AnyTexture::Color).chain(numbers).collect()
    }

    /// The roughness, if the material has one.
    pub(super) fn roughness(&self) -> Option<&Roughness> {
        match self {
            MaterialKind::Plastic(plastic) => Some(&plastic.roughness),
            MaterialKind::Translucent(translucent) => Some(&translucent.roughness),
            MaterialKind::Glass(glass) => Some(&glass.roughness),
            MaterialKind::Metal(metal) => Some(&metal.roughness),
            MaterialKind::Substrate(substrate) => Some(&substrate.roughness),
            MaterialKind::Uber(uber) => Some(&uber.roughness),
            MaterialKind::Matte(_) | MaterialKind::Mirror(_) | MaterialKind::Mix(_) | MaterialKind::None => {
                None
            }
        }
    }

    /// The type name in scene files.
    pub fn name(&self) -> &'static str {
        match self {
            MaterialKind::Matte(_) => "matte",
            MaterialKind::Plastic(_) => "plastic",
            MaterialKind::Translucent(_) => "translucent",
            MaterialKind::Glass(_) => "glass",
            MaterialKind::Mirror(_) => "mirror",
            MaterialKind::Metal(_) => "metal",
            MaterialKind::Substrate(_) => "substrate",
            MaterialKind::Uber(_) => "uber",
            MaterialKind::Mix(_) => "mix",
            MaterialKind::None => "none",
        }
    }
}
