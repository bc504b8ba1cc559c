//! Vectors of eight numbers: one lane for each of eight samples.
//!
//! A sample has the same bits with any instruction set and any neighbors: operations have one order, and none is fused with the
//! next. Functions are inlined into the one that is compiled for the processor. Colors are linear RGB.

use std::f32::consts::{LN_2, LOG2_E};
use std::ops::{Add, Div, Mul, Neg, Range, Sub};

use fearless_simd::{Simd, f32x8, f64x8, mask32x8, mask64x8, prelude::*, u32x8};
use glam::{DMat3, DVec3, Vec3};
use lookat_scene::LUMINANCE;

/// The number of lanes: samples that are computed side by side.
pub(crate) const LANES: usize = 8;

/// Does something with the instructions of `simd`: in functions that are not inlined, which know none.
macro_rules! vectorized {
    ($simd:expr, $does:expr) => {
        fearless_simd::Simd::vectorize(
            $simd,
            #[inline(always)]
            || $does,
        )
    };
}

pub(crate) use vectorized;

/// An expression for each axis, without a closure, which compilers do not always inline.
macro_rules! three {
    ($axis:ident, $of:expr) => {{
        use crate::number::three;
        [three!($axis = 0, $of), three!($axis = 1, $of), three!($axis = 2, $of)]
    }};
    ($axis:ident = $at:expr, $of:expr) => {{
        let $axis: usize = $at;
        $of
    }};
}

pub(crate) use three;

/// Does something with the instructions of a level, `simd`: AVX-512, AVX2, or what all processors of its kind have.
macro_rules! side_by_side {
    ($level:expr, $simd:ident => $does:expr) => {
        match $level {
            #[cfg(target_arch = "x86_64")]
            fearless_simd::Level::Avx512($simd) => crate::number::vectorized!($simd, $does),
            #[cfg(target_arch = "x86_64")]
            fearless_simd::Level::Avx2($simd) => crate::number::vectorized!($simd, $does),
            _ => crate::number::baseline!($simd => $does),
        }
    };
}

pub(crate) use side_by_side;

/// Does something with the instructions that all processors of a kind have.
macro_rules! baseline {
    ($simd:ident => $does:expr) => {{
        let level = fearless_simd::Level::baseline();
        #[cfg(target_arch = "x86_64")]
        let $simd = level.as_sse2().expect("every x86-64 processor has SSE2");
        #[cfg(target_arch = "aarch64")]
        let $simd = level.as_neon().expect("every AArch64 processor has NEON");
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
        let fearless_simd::Level::Fallback($simd) = level else {
            unreachable!("other processors do without")
        };
        $does
    }};
}

pub(crate) use baseline;

/// Numbers side by side: `f64` for places, `f32` for light and directions.
pub(crate) trait Number: SimdFloat<<Self as Number>::Token> {
    type Token: Simd;

    /// The same value in all lanes.
    fn of(simd: Self::Token, x: f64) -> Self;
}

impl<S: Simd> Number for f64x8<S> {
    type Token = S;

    #[inline(always)]
    fn of(simd: S, x: f64) -> Self {
        x.simd_into(simd)
    }
}

impl<S: Simd> Number for f32x8<S> {
    type Token = S;

    #[inline(always)]
    fn of(simd: S, x: f64) -> Self {
        (x as f32).simd_into(simd)
    }
}

/// Vectors.
#[derive(Debug, Clone, Copy)]
pub(crate) struct V3<T> {
    pub x: T,
    pub y: T,
    pub z: T,
}

/// Points of the world, and directions of rays.
pub(crate) type Vec3x8<S> = V3<f64x8<S>>;

/// Points of planes.
pub(crate) type Vec2x8<S> = [f64x8<S>; 2];

/// Colors, radiances, normals and directions of scattering.
pub(crate) type Vec3fx8<S> = V3<f32x8<S>>;

impl<T: Copy + Add<Output = T> + Mul<Output = T>> V3<T> {
    #[inline(always)]
    pub fn dot(self, other: Self) -> T {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub fn length_squared(self) -> T {
        self.dot(self)
    }

    /// Transforms the vector by the matrix with these columns.
    #[inline(always)]
    pub fn by_columns(self, [x, y, z]: [Self; 3]) -> Self {
        x * self.x + y * self.y + z * self.z
    }

    /// Transforms the vector by a matrix.
    #[inline(always)]
    pub fn by(self, m: &DMat3) -> Self
    where
        T: Mul<f64, Output = T>,
    {
        let (x, y, z) = (&m.x_axis, &m.y_axis, &m.z_axis);
        V3 {
            x: self.x * x.x + self.y * y.x + self.z * z.x,
            y: self.x * x.y + self.y * y.y + self.z * z.y,
            z: self.x * x.z + self.y * y.z + self.z * z.z,
        }
    }
}

impl<T: Copy + Sub<Output = T> + Mul<Output = T>> V3<T> {
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        V3 {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }
}

impl<T: Add<f64, Output = T>> V3<T> {
    /// Adds the same vector to all.
    #[inline(always)]
    pub fn moved_by(self, v: DVec3) -> Self {
        V3 { x: self.x + v.x, y: self.y + v.y, z: self.z + v.z }
    }
}

impl From<DVec3> for V3<f64> {
    fn from(v: DVec3) -> Self {
        V3 { x: v.x, y: v.y, z: v.z }
    }
}

impl From<V3<f64>> for DVec3 {
    fn from(v: V3<f64>) -> Self {
        DVec3::new(v.x, v.y, v.z)
    }
}

impl<T: Number> V3<T> {
    /// The same value in all lanes.
    #[inline(always)]
    pub fn splat(simd: T::Token, v: impl Into<[T::Element; 3]>) -> Self {
        let [x, y, z] = v.into();
        V3 { x: T::splat(simd, x), y: T::splat(simd, y), z: T::splat(simd, z) }
    }

    /// The vectors scaled to length one.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        self.try_normalize().0
    }

    /// The vectors scaled to length one, and a mask of the lanes where this is possible.
    #[inline(always)]
    pub fn try_normalize(self) -> (Self, T::Mask) {
        let simd = self.x.token();
        let inverse = T::of(simd, 1.0) / self.length_squared().sqrt();
        (self * inverse, inverse.is_finite() & inverse.simd_gt(T::of(simd, 0.0)))
    }

    /// The vectors scaled to length one, or `v` where this is impossible.
    #[inline(always)]
    pub fn normalize_or(self, v: impl Into<[T::Element; 3]>) -> Self {
        let (normalized, is_valid) = self.try_normalize();
        normalized.keep_where(is_valid, V3::splat(self.x.token(), v))
    }

    /// Keeps the lanes in `mask` and takes the other lanes from `others`.
    #[inline(always)]
    pub fn keep_where(self, mask: T::Mask, others: Self) -> Self {
        V3 {
            x: mask.select(self.x, others.x),
            y: mask.select(self.y, others.y),
            z: mask.select(self.z, others.z),
        }
    }

    /// This vector or its opposite, whichever lies on the same side as `v` (PBR 2.2.1).
    #[inline(always)]
    pub fn face_forward(self, v: Self) -> Self {
        (-self).keep_where(self.dot(v).simd_lt(T::of(self.x.token(), 0.0)), self)
    }

    /// The lesser coordinates of both vectors.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        V3 { x: self.x.min(other.x), y: self.y.min(other.y), z: self.z.min(other.z) }
    }

    /// The greater coordinates of both vectors.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        V3 { x: self.x.max(other.x), y: self.y.max(other.y), z: self.z.max(other.z) }
    }

    /// The size of the largest coordinate.
    #[inline(always)]
    pub fn magnitude(self) -> T {
        self.x.abs().max(self.y.abs()).max(self.z.abs())
    }

    /// Replaces the vector in one lane.
    #[inline(always)]
    pub fn set_lane(&mut self, lane: usize, v: impl Into<[T::Element; 3]>) {
        [self.x[lane], self.y[lane], self.z[lane]] = v.into();
    }
}

impl<S: Simd> Vec3x8<S> {
    /// Vectors from arrays of their coordinates.
    #[inline(always)]
    pub fn from_arrays(simd: S, [x, y, z]: &[[f64; LANES]; 3]) -> Self {
        V3 { x: (*x).simd_into(simd), y: (*y).simd_into(simd), z: (*z).simd_into(simd) }
    }

    /// Three for each lane, such as the corners of triangles.
    #[inline(always)]
    pub fn three(simd: S, [a, b, c]: &[[[f64; LANES]; 3]; 3]) -> [Self; 3] {
        [V3::from_arrays(simd, a), V3::from_arrays(simd, b), V3::from_arrays(simd, c)]
    }

    /// The value in one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> DVec3 {
        DVec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// Rounded to `f32`.
    #[inline(always)]
    pub fn narrow(self) -> Vec3fx8<S> {
        V3 { x: to_f32(self.x), y: to_f32(self.y), z: to_f32(self.z) }
    }
}

impl<S: Simd> Vec3fx8<S> {
    #[inline(always)]
    pub fn widen(self) -> Vec3x8<S> {
        V3 { x: to_f64(self.x), y: to_f64(self.y), z: to_f64(self.z) }
    }

    /// Times factors that may be beyond the range of `f32`.
    #[inline(always)]
    pub fn scaled(self, by: f64x8<S>) -> Self {
        (self.widen() * by).narrow()
    }

    /// The luminance of the magnitudes, like [`strength`].
    #[inline(always)]
    pub fn strength(self) -> f64x8<S> {
        let of = |x: f32x8<S>, share: f64| to_f64(x.abs()) * share;
        of(self.x, LUMINANCE.x) + of(self.y, LUMINANCE.y) + of(self.z, LUMINANCE.z)
    }

    /// Does what [`V3::keep_where`] does, with a mask of `f64` lanes.
    #[inline(always)]
    pub fn keep_where_wide(self, mask: mask64x8<S>, others: Self) -> Self {
        self.keep_where(narrow(mask), others)
    }

    /// The sums of the channels, with negative channels as 0.
    #[inline(always)]
    pub fn amount(self) -> f32x8<S> {
        let positive = |x: f32x8<S>| x.simd_gt(0.0).select(x, splat_f32(x.token(), 0.0));
        positive(self.x) + positive(self.y) + positive(self.z)
    }

    /// The lanes that are not black.
    #[inline(always)]
    pub fn is_light(self) -> mask64x8<S> {
        widen(!(self.x.simd_eq(0.0) & self.y.simd_eq(0.0) & self.z.simd_eq(0.0)))
    }

    /// The value in one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }
}

/// Operators that work along each axis.
macro_rules! along_axes {
    ($($trait:ident $of:ident),*) => {
        $(impl<T: $trait<Output = T>> $trait for V3<T> {
            type Output = Self;
            #[inline(always)]
            fn $of(self, other: Self) -> Self {
                V3 { x: self.x.$of(other.x), y: self.y.$of(other.y), z: self.z.$of(other.z) }
            }
        })*
    };
}
along_axes!(Add add, Sub sub, Mul mul);

impl<T: Neg<Output = T>> Neg for V3<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        V3 { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl<T: Mul<Output = T> + Copy> Mul<T> for V3<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: T) -> Self {
        V3 { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

impl<T: Div<Output = T> + Copy> Div<T> for V3<T> {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: T) -> Self {
        V3 { x: self.x / divisor, y: self.y / divisor, z: self.z / divisor }
    }
}

/// A mask of the lanes whose bits are set.
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
pub(crate) fn set_lanes<S: Simd>(mask: mask64x8<S>) -> impl Iterator<Item = usize> {
    let bits = mask.to_bitmask();
    (0..LANES).filter(move |lane| bits >> lane & 1 == 1)
}

/// The places of the bits that are set, from the lowest on.
#[inline(always)]
pub(crate) fn set_bits(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(
        #[inline(always)]
        move || {
            let place = (bits != 0).then(|| bits.trailing_zeros() as usize % u64::BITS as usize)?;
            bits &= bits - 1;
            Some(place)
        },
    )
}

/// True if the processor moves chosen lanes together in few instructions.
#[inline(always)]
pub(crate) fn has_compress<S: Simd>(simd: S) -> bool {
    #[cfg(target_arch = "x86_64")]
    return matches!(simd.level(), fearless_simd::Level::Avx512(_) | fearless_simd::Level::Avx2(_));
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = simd;
        false
    }
}

/// As many bits as `count`, from the lowest on; at most 64.
#[inline(always)]
pub(crate) fn first_bits(count: usize) -> u64 {
    u64::MAX.checked_shr(u64::BITS - count as u32).unwrap_or(0)
}

/// The eights that have any of some bits: the first place of each, and its bits.
#[inline(always)]
pub(crate) fn eights(all: u64) -> impl Iterator<Item = (usize, u64)> {
    (0..u64::BITS as usize)
        .step_by(LANES)
        .map(move |first| (first, all >> first & 0xff))
        .filter(|(_, own)| *own != 0)
}

/// Groups of lanes that are alike: the first of each, and all of them as bits.
#[inline(always)]
pub(crate) fn groups(
    lanes: u64,
    is_same: impl Fn(usize, usize) -> bool,
) -> impl Iterator<Item = (usize, u64)> {
    let mut rest = lanes;
    std::iter::from_fn(
        #[inline(always)]
        move || {
            let first = (rest != 0).then(|| rest.trailing_zeros() as usize)?;
            let mut own = 1 << first;
            for lane in (first + 1..LANES).filter(|lane| rest >> lane & 1 == 1) {
                own |= u64::from(is_same(first, lane)) << lane;
            }
            rest &= !own;
            Some((first, own))
        },
    )
}

/// The same number in all lanes.
#[inline(always)]
pub(crate) fn splat_f32<S: Simd>(simd: S, x: f32) -> f32x8<S> {
    x.simd_into(simd)
}

/// By how much a matrix stretches a vector at most: that, or a little more. Exact where its columns are perpendicular.
pub(crate) fn largest_stretch(m: &DMat3) -> f64 {
    let squares = m.transpose() * *m;
    let rows = squares.x_axis.abs() + squares.y_axis.abs() + squares.z_axis.abs();
    rows.max_element().sqrt()
}

/// The largest power of two that is not above `x`, a normal number.
pub(crate) fn power_of_two(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & f64::INFINITY.to_bits())
}

/// Rounded to `f32`.
#[inline(always)]
pub(crate) fn to_f32<S: Simd>(x: f64x8<S>) -> f32x8<S> {
    let simd = x.token();
    simd.split_f32x16(simd.narrow_f64x8(x, x)).0
}

/// The logarithm to base 2: its integers, from -127 for 0 to 128 for what is no number, and the rest to 2e-7.
#[inline(always)]
pub(crate) fn log2<S: Simd>(of: f32x8<S>) -> ([i32; LANES], f32x8<S>) {
    let bits: u32x8<S> = of.bitcast();
    let mantissa: f32x8<S> = (bits & 0x7f_ffff | 0x3f80_0000).bitcast();
    let x = mantissa - 1.0;
    // log2(1 + x) from 0 to 1.
    const FACTORS: [f32; 8] = [
        -0.042_687_185,
        0.113_051_97,
        -0.197_285_2,
        0.275_719_67,
        -0.358_428_48,
        0.480_695_5,
        -0.721_340_36,
        LOG2_E,
    ];
    let mut rest = x * 0.007_579_135_7;
    for factor in FACTORS {
        rest = (rest + factor) * x;
    }
    ((bits >> 23 & 0xff).to_array().map(|exponent| exponent as i32 - 127), rest)
}

/// The natural logarithm, to 2e-7 and a rounding; of 0 it is about -88.
#[inline(always)]
pub(crate) fn ln<S: Simd>(x: f32x8<S>) -> f32x8<S> {
    let (whole, rest) = log2(x);
    let whole: f32x8<S> = whole.map(|whole| whole as f32).simd_into(x.token());
    (whole + rest) * LN_2
}

/// The natural logarithm of 1 - `u`, for numbers from 0 to 1, to a millionth of itself.
#[inline(always)]
pub(crate) fn log_1_minus<S: Simd>(u: f64x8<S>) -> f32x8<S> {
    let far = ln(to_f32(1.0 - u));
    // Near 0 by the series of the inverse hyperbolic tangent.
    let near = to_f32(u);
    let s = near / (2.0 - near);
    let square = s * s;
    let mut sum = square * (1.0 / 11.0);
    for factor in [1.0 / 9.0, 1.0 / 7.0, 1.0 / 5.0, 1.0 / 3.0] {
        sum = (sum + factor) * square;
    }
    near.simd_lt(0.5).select((sum + 1.0) * s * -2.0, far)
}

/// e to the power of minus `x`, which is 0 or more, to a millionth (polynomial of Cephes, `exp2f.c`).
#[inline(always)]
pub(crate) fn exp_minus<S: Simd>(x: f32x8<S>) -> f32x8<S> {
    // Adding this rounds to a whole number, which the lowest bits of the sum hold.
    const ROUNDING: f32 = 12_582_912.0;
    const FACTORS: [f32; 5] = [1.339_887_4e-3, 9.618_437e-3, 5.550_332_5e-2, 2.402_264_8e-1, 6.931_472e-1];
    let power = (x * LOG2_E).min(126.0);
    let whole = power + ROUNDING;
    let rest = (whole - ROUNDING) - power;
    let mut sum = rest * 1.535_336_2e-4;
    for factor in FACTORS {
        sum = (sum + factor) * rest;
    }
    let whole: u32x8<S> = whole.bitcast();
    let scale: f32x8<S> = (u32x8::splat(x.token(), 1.0_f32.to_bits()) - (whole << 23)).bitcast();
    power.simd_lt(125.0).select((sum + 1.0) * scale, splat_f32(x.token(), 0.0))
}

/// Widens numbers to `f64`.
#[inline(always)]
pub(crate) fn to_f64<S: Simd>(x: f32x8<S>) -> f64x8<S> {
    let (low, high) = x.widen();
    x.token().combine_f64x4(low, high)
}

/// A mask of `f64` as one of `f32`.
#[inline(always)]
pub(crate) fn narrow<S: Simd>(mask: mask64x8<S>) -> mask32x8<S> {
    let simd = mask.token();
    let (low, high) = simd.split_mask64x8(mask);
    low.narrow(high)
}

/// A mask of `f32` as one of `f64`.
#[inline(always)]
pub(crate) fn widen<S: Simd>(mask: mask32x8<S>) -> mask64x8<S> {
    let (low, high) = mask.widen();
    mask.token().combine_mask64x4(low, high)
}

/// The luminance of linear RGB (ITU-R BT.709).
pub(crate) fn luminance(rgb: Vec3) -> f64 {
    rgb.as_dvec3().dot(LUMINANCE)
}

/// The luminance of a color. Negative channels count as positive, so that only black has luminance 0.
pub(crate) fn strength(rgb: Vec3) -> f64 {
    luminance(rgb.abs())
}

/// The size of a cache line in bytes.
const LINE: usize = 64;

/// Asks for some lines of memory, counted from a place, which may be anywhere.
#[inline(always)]
pub(crate) fn prefetch<T>(at: *const T, lines: Range<usize>) {
    #[cfg(target_arch = "x86_64")]
    for line in lines {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: every such processor has it, and it does nothing wherever it points.
        #[allow(unsafe_code)]
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(at.cast::<i8>().wrapping_add(LINE * line));
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (at, lines, LINE);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_near_1_are_exact_to_a_millionth() {
        baseline!(simd => {
            for k in 0..4_000 {
                for u in [f64::from(k) * 2.4999e-4, libm::exp(-0.01 * f64::from(k + 70))] {
                    let found = f64::from(log_1_minus(u.simd_into(simd))[2]);
                    let expected = libm::log1p(-u);
                    assert!((found - expected).abs() <= 1e-6 * -expected, "{u}: {found}, not {expected}");
                }
            }
        });
    }

    #[test]
    fn exponentials_are_exact_to_a_millionth() {
        baseline!(simd => {
            for k in 0..10_000 {
                let x = k as f32 * 0.0087;
                let (found, expected) = (exp_minus(splat_f32(simd, x))[5], libm::exp(-f64::from(x)));
                let error = (f64::from(found) - expected) / expected;
                assert!(error.abs() < if x < 10.0 { 1e-6 } else { 1e-5 } || expected < 1e-37, "{x}: {error}");
            }
            for (x, expected) in [(0.0, 1.0), (1e-30, 1.0), (1e30, 0.0), (f32::INFINITY, 0.0)] {
                assert_eq!(exp_minus(splat_f32(simd, x))[0], expected, "{x}");
            }
        });
    }

    #[test]
    fn logarithms_are_exact_to_2e_7() {
        baseline!(simd => {
            let parts = |x: f32| {
                let (whole, rest) = log2(splat_f32(simd, x));
                (whole[3], rest[3])
            };
            for case in 0..20_000_u32 {
                let x = f32::from_bits(0x0080_0000 + case * 106_000);
                let (whole, rest) = parts(x);
                let error = f64::from(whole) + f64::from(rest) - libm::log2(f64::from(x));
                assert!(error.abs() < 2e-7, "{x}: {error}");
            }
            for (x, whole) in [(0.0, -127), (1e-40, -127), (f32::INFINITY, 128), (f32::NAN, 128)] {
                assert_eq!(parts(x).0, whole, "{x}");
            }
        });
    }
}
