//! Directions and frames around them.

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};
use glam::DVec3;

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
    /// Those with `z`, of length one, as their z axes (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017).
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
        let (x, is_there) = (x - z * z.dot(x)).try_normalize();
        let others = Frames::from_z(z);
        Frames { x: x.or(is_there, others.x), y: z.cross(x).or(is_there, others.y), z }
    }

    /// Rounded to `f32`.
    #[inline(always)]
    pub fn narrow(self) -> Frames<f32x8<S>> {
        Frames { x: self.x.narrow(), y: self.y.narrow(), z: self.z.narrow() }
    }
}

impl<S: Simd> Frames<f32x8<S>> {
    /// These where `mask` says so, and the others elsewhere.
    #[inline(always)]
    pub fn or(self, mask: mask64x8<S>, others: Self) -> Self {
        let mask = narrow(mask);
        Frames { x: self.x.or(mask, others.x), y: self.y.or(mask, others.y), z: self.z.or(mask, others.z) }
    }
}

/// Two directions across `v`, of length one where `v` is (pbrt-v3's CoordinateSystem).
#[inline(always)]
pub(crate) fn pbrt_frame<S: Simd>(v: Vec3x8<S>) -> [Vec3x8<S>; 2] {
    let zero = f64x8::splat(v.x.token(), 0.0);
    let is_x = v.x.abs().simd_gt(v.y.abs());
    let x = V3 { x: -v.z, y: zero, z: v.x }.or(is_x, V3 { x: zero, y: v.z, z: -v.y });
    let x = x.normalize_or(DVec3::X);
    [x, v.cross(x)]
}
