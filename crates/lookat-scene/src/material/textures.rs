//! The textures of any material.

use glam::Vec3;

use super::{MaterialKind, Metal, Roughness, Uber};
use crate::texture::Texture;

/// A texture of numbers or of colors.
#[derive(Debug, Clone, Copy)]
pub enum AnyTexture<'t> {
    /// Of numbers.
    Number(&'t Texture<f64>),
    /// Of colors.
    Color(&'t Texture<Vec3>),
}

/// The textures of a material, without textures of the parts of a mix: colors, then numbers.
macro_rules! textures {
    ($kind:expr $(, $mutable:tt)?) => {{
        let (colors, number, roughness) = match $kind {
            MaterialKind::Matte(it) => (vec![&$($mutable)? it.kd], Some(&$($mutable)? it.sigma), None),
            MaterialKind::Plastic(it) => {
                (vec![&$($mutable)? it.kd, &$($mutable)? it.ks], None, Some(&$($mutable)? it.roughness))
            }
            MaterialKind::Translucent(it) => (
                vec![
                    &$($mutable)? it.kd,
                    &$($mutable)? it.ks,
                    &$($mutable)? it.reflect,
                    &$($mutable)? it.transmit,
                ],
                None,
                Some(&$($mutable)? it.roughness),
            ),
            MaterialKind::Glass(it) => (
                vec![&$($mutable)? it.kr, &$($mutable)? it.kt],
                Some(&$($mutable)? it.eta),
                Some(&$($mutable)? it.roughness),
            ),
            MaterialKind::Mirror(it) => (vec![&$($mutable)? it.kr], None, None),
            MaterialKind::Metal(it) => {
                let Metal { eta, k, roughness, .. } = &$($mutable)? **it;
                (vec![eta, k], None, Some(roughness))
            }
            MaterialKind::Substrate(it) => {
                (vec![&$($mutable)? it.kd, &$($mutable)? it.ks], None, Some(&$($mutable)? it.roughness))
            }
            MaterialKind::Uber(it) => {
                let Uber { kd, ks, kr, kt, opacity, eta, roughness, .. } = &$($mutable)? **it;
                (vec![kd, ks, kr, kt, opacity], Some(eta), Some(roughness))
            }
            MaterialKind::Mix(it) => (vec![&$($mutable)? it.amount], None, None),
            MaterialKind::None => (vec![], None, None),
        };
        let mut numbers: Vec<_> = number.into_iter().collect();
        if let Some(roughness) = roughness {
            numbers.push(&$($mutable)? roughness.u);
            numbers.extend(&$($mutable)? roughness.v);
        }
        (colors, numbers)
    }};
}

impl MaterialKind {
    /// The textures of this material, without textures of the parts of a mix.
    pub fn textures(&self) -> Vec<AnyTexture<'_>> {
        let (colors, numbers): (Vec<_>, Vec<_>) = textures!(self);
        let numbers = numbers.into_iter().map(AnyTexture::Number);
        colors.into_iter().map(AnyTexture::Color).chain(numbers).collect()
    }

    /// The same, to change: colors, then numbers.
    pub(crate) fn textures_mut(&mut self) -> (Vec<&mut Texture<Vec3>>, Vec<&mut Texture<f64>>) {
        textures!(self, mut)
    }

    /// True if it scatters no light. Textures that vary count as light.
    pub fn is_black(&self) -> bool {
        let are_black = |all: &[&Texture<Vec3>]| all.iter().all(|share| share.constant() == Some(Vec3::ZERO));
        match self {
            MaterialKind::Matte(it) => are_black(&[&it.kd]),
            MaterialKind::Plastic(it) => are_black(&[&it.kd, &it.ks]),
            MaterialKind::Translucent(it) => {
                are_black(&[&it.kd, &it.ks]) || are_black(&[&it.reflect, &it.transmit])
            }
            MaterialKind::Glass(it) => are_black(&[&it.kr, &it.kt]),
            MaterialKind::Mirror(it) => are_black(&[&it.kr]),
            MaterialKind::Substrate(it) => are_black(&[&it.kd, &it.ks]),
            MaterialKind::Uber(it) => {
                it.opacity.constant() == Some(Vec3::ONE) && are_black(&[&it.kd, &it.ks, &it.kr, &it.kt])
            }
            MaterialKind::Mix(it) => it.materials.iter().all(|part| part.kind.is_black()),
            MaterialKind::Metal(_) | MaterialKind::None => false,
        }
    }

    /// The index of refraction, if the material has one.
    pub(crate) fn index(&self) -> Option<&Texture<f64>> {
        match self {
            MaterialKind::Glass(glass) => Some(&glass.eta),
            MaterialKind::Uber(uber) => Some(&uber.eta),
            _ => None,
        }
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
