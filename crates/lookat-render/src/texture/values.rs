//! What textures give: numbers and colors.

use std::ops::{Add, Mul};

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};
use glam::Vec3;
use lookat_scene::{LUMINANCE, Value};

use crate::number::{Colors, LANES, to_f32, to_f64};

/// Values side by side.
pub(crate) trait Values<S: Simd>: Value {
    type Wide: Copy + Mul<Output = Self::Wide>;
    type Texels: Copy + Add<Output = Self::Texels> + Mul<f32x8<S>, Output = Self::Texels>;

    /// The same one everywhere.
    fn splat(simd: S, value: Self) -> Self::Wide;

    /// The first where `mask` says so, and the others elsewhere.
    fn or(first: Self::Wide, mask: mask64x8<S>, others: Self::Wide) -> Self::Wide;

    /// Gray values.
    fn gray(values: f64x8<S>) -> Self::Wide;

    /// Numbers become luminances.
    fn from_rgb(rgb: Colors<S>) -> Self::Wide;

    /// `a` for an amount of 0, `b` for 1.
    fn blend(a: Self::Wide, b: Self::Wide, amount: f64x8<S>) -> Self::Wide;

    fn texels(simd: S, texels: &[Self::Texel; LANES]) -> Self::Texels;

    fn from_texels(texels: Self::Texels) -> Self::Wide;
}

impl<S: Simd> Values<S> for f64 {
    type Wide = f64x8<S>;
    type Texels = f32x8<S>;

    #[inline(always)]
    fn splat(simd: S, value: f64) -> f64x8<S> {
        value.simd_into(simd)
    }

    #[inline(always)]
    fn or(first: f64x8<S>, mask: mask64x8<S>, others: f64x8<S>) -> f64x8<S> {
        mask.select(first, others)
    }

    #[inline(always)]
    fn gray(values: f64x8<S>) -> f64x8<S> {
        values
    }

    #[inline(always)]
    fn from_rgb(rgb: Colors<S>) -> f64x8<S> {
        to_f64(rgb.x) * LUMINANCE.x + to_f64(rgb.y) * LUMINANCE.y + to_f64(rgb.z) * LUMINANCE.z
    }

    #[inline(always)]
    fn blend(a: f64x8<S>, b: f64x8<S>, amount: f64x8<S>) -> f64x8<S> {
        a * (1.0 - amount) + b * amount
    }

    #[inline(always)]
    fn texels(simd: S, texels: &[f32; LANES]) -> f32x8<S> {
        (*texels).simd_into(simd)
    }

    #[inline(always)]
    fn from_texels(texels: f32x8<S>) -> f64x8<S> {
        to_f64(texels)
    }
}

impl<S: Simd> Values<S> for Vec3 {
    type Wide = Colors<S>;
    type Texels = Colors<S>;

    #[inline(always)]
    fn splat(simd: S, value: Vec3) -> Colors<S> {
        Colors::splat(simd, value)
    }

    #[inline(always)]
    fn or(first: Colors<S>, mask: mask64x8<S>, others: Colors<S>) -> Colors<S> {
        first.or_wide(mask, others)
    }

    #[inline(always)]
    fn gray(values: f64x8<S>) -> Colors<S> {
        let gray = to_f32(values);
        Colors { x: gray, y: gray, z: gray }
    }

    #[inline(always)]
    fn from_rgb(rgb: Colors<S>) -> Colors<S> {
        rgb
    }

    #[inline(always)]
    fn blend(a: Colors<S>, b: Colors<S>, amount: f64x8<S>) -> Colors<S> {
        a * to_f32(1.0 - amount) + b * to_f32(amount)
    }

    #[inline(always)]
    fn texels(simd: S, texels: &[Vec3; LANES]) -> Colors<S> {
        let [r, g, b]: [[f32; LANES]; 3] = [
            std::array::from_fn(|lane| texels[lane].x),
            std::array::from_fn(|lane| texels[lane].y),
            std::array::from_fn(|lane| texels[lane].z),
        ];
        Colors { x: r.simd_into(simd), y: g.simd_into(simd), z: b.simd_into(simd) }
    }

    #[inline(always)]
    fn from_texels(texels: Colors<S>) -> Colors<S> {
        texels
    }
}
