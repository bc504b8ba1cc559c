//! Shading frames, and boxes along the axes in `f32` that are never too small.

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};
use glam::{DVec3, Vec3A};

use crate::number::{Number, V3, Vec3x8, narrow};

/// The direction, or the opposite one.
pub(crate) fn flipped(n: DVec3, flip: bool) -> DVec3 {
    if flip { -n } else { n }
}

/// Orthonormal frames.
#[derive(Clone, Copy)]
pub(crate) struct Frames<T> {
    pub x: V3<T>,
    pub y: V3<T>,
    pub z: V3<T>,
}

impl<T: Number> Frames<T> {
    /// Frames with the z axes `z`, of length one (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017).
    #[inline(always)]
    pub fn from_z(z: V3<T>) -> Self {
        let one = T::of(z.z.token(), 1.0);
        let sign = one.copysign(z.z);
        let a = -one / (sign + z.z);
        let b = z.x * z.y * a;
        let x = V3 { x: one + sign * z.x * z.x * a, y: sign * b, z: -sign * z.x };
        let y = V3 { x: b, y: sign + z.y * z.y * a, z: -z.y };
        Frames { x, y, z }
    }

    #[inline(always)]
    pub fn to_local(self, v: V3<T>) -> V3<T> {
        V3 { x: self.x.dot(v), y: self.y.dot(v), z: self.z.dot(v) }
    }

    #[inline(always)]
    pub fn to_world(self, v: V3<T>) -> V3<T> {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

impl<S: Simd> Frames<f64x8<S>> {
    /// The frames around `z`, of length one, whose x axes are as near to `x` as can be.
    #[inline(always)]
    pub fn from_zx(z: Vec3x8<S>, x: Vec3x8<S>) -> Self {
        let (x, is_valid) = (x - z * z.dot(x)).try_normalize();
        let others = Frames::from_z(z);
        Frames { x: x.keep_where(is_valid, others.x), y: z.cross(x).keep_where(is_valid, others.y), z }
    }

    /// Rounded to `f32`.
    #[inline(always)]
    pub fn narrow(self) -> Frames<f32x8<S>> {
        Frames { x: self.x.narrow(), y: self.y.narrow(), z: self.z.narrow() }
    }
}

impl<S: Simd> Frames<f32x8<S>> {
    /// Keeps the lanes in `mask` and takes the other lanes from `others`.
    #[inline(always)]
    pub fn keep_where(self, mask: mask64x8<S>, others: Self) -> Self {
        let mask = narrow(mask);
        Frames {
            x: self.x.keep_where(mask, others.x),
            y: self.y.keep_where(mask, others.y),
            z: self.z.keep_where(mask, others.z),
        }
    }
}

/// Two directions across `v`, of length one where `v` is (pbrt-v3's CoordinateSystem).
#[inline(always)]
pub(crate) fn pbrt_frame<S: Simd>(v: Vec3x8<S>) -> [Vec3x8<S>; 2] {
    let zero = f64x8::splat(v.x.token(), 0.0);
    let is_x = v.x.abs().simd_gt(v.y.abs());
    let x = V3 { x: -v.z, y: zero, z: v.x }.keep_where(is_x, V3 { x: zero, y: v.z, z: -v.y });
    let x = x.normalize_or(DVec3::X);
    [x, v.cross(x)]
}

/// An axis-aligned box. Its corners are rounded outward, so it holds whatever `f64` box it was made from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub min: Vec3A,
    pub max: Vec3A,
}

impl Bounds {
    /// Holds nothing.
    pub const EMPTY: Bounds = Bounds { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    pub fn new(min: DVec3, max: DVec3) -> Self {
        Bounds { min: min.to_array().map(round_down).into(), max: max.to_array().map(round_up).into() }
    }

    /// A box whose corners were computed from coordinates of a magnitude: wider by what rounding may have taken.
    pub fn padded(min: DVec3, max: DVec3, magnitude: f64) -> Self {
        let error = magnitude * 1e-14;
        Bounds::new(min - error, max + error)
    }

    /// True if the box is empty.
    pub fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }

    /// A box around two.
    #[inline(always)]
    pub fn union(self, other: Bounds) -> Self {
        Bounds { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The middle, within the finite numbers.
    #[inline(always)]
    pub fn center(&self) -> Vec3A {
        self.min.max(Vec3A::MIN) * 0.5 + self.max.min(Vec3A::MAX) * 0.5
    }

    /// The corners, as `f64`.
    pub fn corners(&self) -> (DVec3, DVec3) {
        (self.min.as_dvec3(), self.max.as_dvec3())
    }
}

/// Without branches: what is rounded up cannot be foretold.
#[inline(always)]
pub(crate) fn round_down(x: f64) -> f32 {
    let rounded = x as f32;
    let is_above = i32::from(f64::from(rounded) > x);
    // Negative numbers are in the order of their bits, too, if all but the sign are inverted.
    let ordered = |bits: i32| bits ^ (bits >> 31 & i32::MAX);
    f32::from_bits(ordered(ordered(rounded.to_bits() as i32) - is_above) as u32)
}

pub(crate) fn round_up(x: f64) -> f32 {
    -round_down(-x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_rounded_outward() {
        for x in [0.1, -0.1, 1.0, 1e-40, -1e-300, 16_777_217.0, 1e300] {
            let bounds = Bounds::new(DVec3::splat(x), DVec3::splat(x));
            assert!(f64::from(bounds.min[0]) <= x && x <= f64::from(bounds.max[0]), "{x}");
        }
        assert_eq!(Bounds::new(DVec3::ONE, DVec3::ONE), Bounds { min: Vec3A::ONE, max: Vec3A::ONE });
    }
}
