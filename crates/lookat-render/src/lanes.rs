//! Eight numbers of a kind at once, one for each of as many samples.
//!
//! What is computed side by side is what is computed for one, to the bit: each step is taken in the same order, and none
//! is fused with the next. Functions are inlined into the one that is compiled for what the processor has.

use fearless_simd::{Simd, f32x8, f64x8, mask32x8, mask64x8, prelude::*};
use glam::{DMat3, DVec3, Vec3};

/// So many samples side by side.
pub(crate) const LANES: usize = 8;

/// Does something with the instructions of a level, `simd`: AVX-512, AVX2, or what all processors of its kind have.
macro_rules! side_by_side {
    ($level:expr, $simd:ident => $does:expr) => {
        match $level {
            #[cfg(target_arch = "x86_64")]
            fearless_simd::Level::Avx512($simd) => $simd.vectorize(
                #[inline(always)]
                || $does,
            ),
            #[cfg(target_arch = "x86_64")]
            fearless_simd::Level::Avx2($simd) => $simd.vectorize(
                #[inline(always)]
                || $does,
            ),
            #[cfg(target_arch = "x86_64")]
            level => {
                let $simd = level.as_sse2().expect("every x86-64 processor has SSE2");
                $does
            }
            #[cfg(target_arch = "aarch64")]
            level => {
                let $simd = level.as_neon().expect("every AArch64 processor has NEON");
                $does
            }
            #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
            fearless_simd::Level::Fallback($simd) => $does,
        }
    };
}
pub(crate) use side_by_side;

/// Vectors.
#[derive(Clone, Copy)]
pub(crate) struct Vec3x8<S: Simd> {
    pub x: f64x8<S>,
    pub y: f64x8<S>,
    pub z: f64x8<S>,
}

impl<S: Simd> Vec3x8<S> {
    /// The same one everywhere.
    #[inline(always)]
    pub fn splat(simd: S, v: DVec3) -> Self {
        Vec3x8 { x: v.x.simd_into(simd), y: v.y.simd_into(simd), z: v.z.simd_into(simd) }
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> f64x8<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Vec3x8 {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    #[inline(always)]
    pub fn length_squared(self) -> f64x8<S> {
        self.dot(self)
    }

    /// Of length one.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        self * (1.0 / self.length_squared().sqrt())
    }

    /// Of length one, and where there is such a vector.
    #[inline(always)]
    pub fn try_normalize(self) -> (Self, mask64x8<S>) {
        let inverse = 1.0 / self.length_squared().sqrt();
        (self * inverse, inverse.is_finite() & inverse.simd_gt(0.0))
    }

    /// Of length one, or else `v`.
    #[inline(always)]
    pub fn normalize_or(self, v: DVec3) -> Self {
        let (normalized, is_there) = self.try_normalize();
        normalized.or(is_there, Vec3x8::splat(self.x.token(), v))
    }

    /// These where `mask` says so, and the others elsewhere.
    #[inline(always)]
    pub fn or(self, mask: mask64x8<S>, others: Self) -> Self {
        Vec3x8 {
            x: mask.select(self.x, others.x),
            y: mask.select(self.y, others.y),
            z: mask.select(self.z, others.z),
        }
    }

    /// Transformed.
    #[inline(always)]
    pub fn by(self, m: &DMat3) -> Self {
        let (x, y, z) = (&m.x_axis, &m.y_axis, &m.z_axis);
        Vec3x8 {
            x: self.x * x.x + self.y * y.x + self.z * z.x,
            y: self.x * x.y + self.y * y.y + self.z * z.y,
            z: self.x * x.z + self.y * y.z + self.z * z.z,
        }
    }

    /// The size of the largest coordinate.
    #[inline(always)]
    pub fn magnitude(self) -> f64x8<S> {
        self.x.abs().max(self.y.abs()).max(self.z.abs())
    }

    /// Those whose coordinates are these.
    #[inline(always)]
    pub fn from_arrays(simd: S, [x, y, z]: &[[f64; LANES]; 3]) -> Self {
        Vec3x8 { x: (*x).simd_into(simd), y: (*y).simd_into(simd), z: (*z).simd_into(simd) }
    }

    /// That of a lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> DVec3 {
        DVec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// Puts another one in a lane.
    #[inline(always)]
    pub fn put(&mut self, lane: usize, v: DVec3) {
        (self.x[lane], self.y[lane], self.z[lane]) = v.into();
    }
}

impl<S: Simd> std::ops::Add for Vec3x8<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Vec3x8 { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<S: Simd> std::ops::Sub for Vec3x8<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Vec3x8 { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<S: Simd> std::ops::Neg for Vec3x8<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Vec3x8 { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl<S: Simd> std::ops::Mul<f64x8<S>> for Vec3x8<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64x8<S>) -> Self {
        Vec3x8 { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

/// Colors, or radiances.
#[derive(Clone, Copy)]
pub(crate) struct Colors<S: Simd> {
    pub r: f32x8<S>,
    pub g: f32x8<S>,
    pub b: f32x8<S>,
}

impl<S: Simd> Colors<S> {
    /// The same one everywhere.
    #[inline(always)]
    pub fn splat(simd: S, color: Vec3) -> Self {
        Colors { r: color.x.simd_into(simd), g: color.y.simd_into(simd), b: color.z.simd_into(simd) }
    }

    /// These where `mask` says so, and the others elsewhere.
    #[inline(always)]
    pub fn or(self, mask: mask64x8<S>, others: Self) -> Self {
        let mask = mask32x8::from_bitmask(self.r.token(), mask.to_bitmask());
        Colors {
            r: mask.select(self.r, others.r),
            g: mask.select(self.g, others.g),
            b: mask.select(self.b, others.b),
        }
    }

    /// The sums of the channels, as far as these are not negative.
    #[inline(always)]
    pub fn amount(self) -> f64x8<S> {
        let simd = self.r.token();
        let sum = self.r.max(0.0) * 1.0 + self.g.max(0.0) * 1.0 + self.b.max(0.0) * 1.0;
        sum.to_array().map(f64::from).simd_into(simd)
    }

    /// Where they are not black.
    #[inline(always)]
    pub fn is_light(self) -> mask64x8<S> {
        let is_black = self.r.simd_eq(0.0) & self.g.simd_eq(0.0) & self.b.simd_eq(0.0);
        mask64x8::from_bitmask(self.r.token(), !is_black.to_bitmask())
    }

    /// That of a lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Vec3 {
        Vec3::new(self.r[lane], self.g[lane], self.b[lane])
    }

    /// Puts another one in a lane.
    #[inline(always)]
    pub fn put(&mut self, lane: usize, color: Vec3) {
        (self.r[lane], self.g[lane], self.b[lane]) = color.into();
    }
}

impl<S: Simd> std::ops::Add for Colors<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Colors { r: self.r + other.r, g: self.g + other.g, b: self.b + other.b }
    }
}

impl<S: Simd> std::ops::Mul for Colors<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Colors { r: self.r * other.r, g: self.g * other.g, b: self.b * other.b }
    }
}

impl<S: Simd> std::ops::Mul<f32x8<S>> for Colors<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f32x8<S>) -> Self {
        Colors { r: self.r * factor, g: self.g * factor, b: self.b * factor }
    }
}

impl<S: Simd> std::ops::Div<f32x8<S>> for Colors<S> {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: f32x8<S>) -> Self {
        Colors { r: self.r / divisor, g: self.g / divisor, b: self.b / divisor }
    }
}

/// Where bits are set.
#[inline(always)]
pub(crate) fn bits<S: Simd>(simd: S, bits: u64) -> mask64x8<S> {
    mask64x8::from_bitmask(simd, bits)
}

/// The first lanes, so many.
#[inline(always)]
pub(crate) fn first_lanes<S: Simd>(simd: S, count: usize) -> mask64x8<S> {
    bits(simd, (1 << count) - 1)
}

/// The lanes where a mask says so.
#[inline(always)]
pub(crate) fn those<S: Simd>(mask: mask64x8<S>) -> impl Iterator<Item = usize> {
    let bits = mask.to_bitmask();
    (0..LANES).filter(move |lane| bits >> lane & 1 == 1)
}

/// How many there are.
#[inline(always)]
pub(crate) fn count<S: Simd>(mask: mask64x8<S>) -> u64 {
    u64::from(mask.to_bitmask().count_ones())
}

/// The same number everywhere.
#[inline(always)]
pub(crate) fn splat_f32<S: Simd>(simd: S, x: f32) -> f32x8<S> {
    x.simd_into(simd)
}

/// One for each axis, of what a closure gives that is to be inlined.
#[inline(always)]
pub(crate) fn three<T>(of: impl Fn(usize) -> T) -> [T; 3] {
    [of(0), of(1), of(2)]
}

/// Rounded to `f32`.
#[inline(always)]
pub(crate) fn to_f32<S: Simd>(x: f64x8<S>) -> f32x8<S> {
    let simd = x.token();
    simd.split_f32x16(simd.narrow_f64x8(x, x)).0
}
