//! Arithmetic of one number or of eight side by side, with the same bits.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::DVec3;

use crate::number::{V3, Vec3x8};

/// One number, or eight.
pub(crate) trait Real:
    Copy
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// What comparisons say: of one, or of each of eight.
    type Mask: Copy + Not<Output = Self::Mask> + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask>;

    /// As many of the same number.
    fn same(self, x: f64) -> Self;

    fn abs(self) -> Self;

    fn sqrt(self) -> Self;

    /// The lesser; any if one is no number.
    fn min(self, other: Self) -> Self;

    /// The greater; any if one is no number.
    fn max(self, other: Self) -> Self;

    fn is_less(self, other: Self) -> Self::Mask;

    fn is_at_most(self, other: Self) -> Self::Mask;

    /// Some where a mask says so, and others elsewhere.
    fn select(mask: Self::Mask, own: Self, others: Self) -> Self;

    /// True if a mask says so anywhere.
    fn any(mask: Self::Mask) -> bool;

    /// A function of each.
    fn each(self, f: impl Fn(f64) -> f64) -> Self;

    /// Of length one, or +z where this is impossible.
    fn normalize(v: V3<Self>) -> V3<Self>;

    /// The vectors where these are finite, and others elsewhere.
    fn if_finite(v: V3<Self>, others: V3<Self>) -> V3<Self>;
}

impl Real for f64 {
    type Mask = bool;

    fn same(self, x: f64) -> Self {
        x
    }

    fn abs(self) -> Self {
        self.abs()
    }

    fn sqrt(self) -> Self {
        self.sqrt()
    }

    fn min(self, other: Self) -> Self {
        self.min(other)
    }

    fn max(self, other: Self) -> Self {
        self.max(other)
    }

    fn is_less(self, other: Self) -> bool {
        self < other
    }

    fn is_at_most(self, other: Self) -> bool {
        self <= other
    }

    fn select(mask: bool, own: Self, others: Self) -> Self {
        if mask { own } else { others }
    }

    fn any(mask: bool) -> bool {
        mask
    }

    fn each(self, f: impl Fn(f64) -> f64) -> Self {
        f(self)
    }

    fn normalize(v: V3<Self>) -> V3<Self> {
        DVec3::from(v).normalize_or(DVec3::Z).into()
    }

    fn if_finite(v: V3<Self>, others: V3<Self>) -> V3<Self> {
        if DVec3::from(v).is_finite() { v } else { others }
    }
}

impl<S: Simd> Real for f64x8<S> {
    type Mask = mask64x8<S>;

    #[inline(always)]
    fn same(self, x: f64) -> Self {
        f64x8::splat(self.token(), x)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        <Self as SimdBase<S>>::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        <Self as SimdFloat<S>>::sqrt(self)
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        <Self as SimdBase<S>>::min(self, other)
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        <Self as SimdBase<S>>::max(self, other)
    }

    #[inline(always)]
    fn is_less(self, other: Self) -> mask64x8<S> {
        self.simd_lt(other)
    }

    #[inline(always)]
    fn is_at_most(self, other: Self) -> mask64x8<S> {
        self.simd_le(other)
    }

    #[inline(always)]
    fn select(mask: mask64x8<S>, own: Self, others: Self) -> Self {
        mask.select(own, others)
    }

    #[inline(always)]
    fn any(mask: mask64x8<S>) -> bool {
        mask.any_true()
    }

    #[inline(always)]
    fn each(mut self, f: impl Fn(f64) -> f64) -> Self {
        for x in self.as_mut_slice() {
            *x = f(*x);
        }
        self
    }

    #[inline(always)]
    fn normalize(v: V3<Self>) -> V3<Self> {
        v.normalize_or(DVec3::Z)
    }

    #[inline(always)]
    fn if_finite(v: Vec3x8<S>, others: Vec3x8<S>) -> Vec3x8<S> {
        v.keep_where(v.x.is_finite() & v.y.is_finite() & v.z.is_finite(), others)
    }
}

impl<T: Real> V3<T> {
    /// Some where a mask says so, and others elsewhere.
    #[inline(always)]
    pub fn select(mask: T::Mask, own: Self, others: Self) -> Self {
        V3 {
            x: T::select(mask, own.x, others.x),
            y: T::select(mask, own.y, others.y),
            z: T::select(mask, own.z, others.z),
        }
    }
}
