//! Arithmetic of one number or of eight side by side, with the same bits.

use std::ops::{Add, Div, Mul, Neg, Sub};

use fearless_simd::{Simd, f64x8, prelude::*};
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
    /// As many of the same number.
    fn same(self, x: f64) -> Self;

    fn abs(self) -> Self;

    fn sqrt(self) -> Self;

    /// A function of each.
    fn each(self, f: impl Fn(f64) -> f64) -> Self;

    /// Of length one, or +z where this is impossible.
    fn normalize(v: V3<Self>) -> V3<Self>;

    /// The vectors where these are finite, and others elsewhere.
    fn if_finite(v: V3<Self>, others: V3<Self>) -> V3<Self>;
}

impl Real for f64 {
    fn same(self, x: f64) -> Self {
        x
    }

    fn abs(self) -> Self {
        self.abs()
    }

    fn sqrt(self) -> Self {
        self.sqrt()
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
