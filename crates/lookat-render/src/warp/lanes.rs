//! Points of the unit square side by side.

use std::f32::consts::FRAC_1_PI;
use std::f64::consts::FRAC_PI_4;

use fearless_simd::{Simd, f32x8, prelude::*};

use crate::circle::lanes::{Angle, at_turn};
use crate::lanes::{Number, V3};

/// As [`super::square_to_disk`]; of `f64` to the bit.
#[inline(always)]
pub(crate) fn square_to_disk<S: Simd, T: Number<S> + Angle>([u, v]: [T; 2]) -> [T; 2] {
    let n = |x| T::of(u.token(), x);
    let (x, y) = (n(2.0) * u - n(1.0), n(2.0) * v - n(1.0));
    let is_wide = x.abs().simd_gt(y.abs());
    let (short, long) = (is_wide.select(y, x), is_wide.select(x, y));
    let [cos, sin] = (n(FRAC_PI_4) * (short / long)).point();
    let (cos, sin) = (cos * long, sin * long);
    let zero = x.simd_eq(n(0.0)) & y.simd_eq(n(0.0));
    [zero.select(x, is_wide.select(cos, sin)), zero.select(y, is_wide.select(sin, cos))]
}

/// Directions around +z in proportion to their cosine (PBR 13.6.3).
#[inline(always)]
pub(crate) fn square_to_cosine_hemisphere<S: Simd>(u: [f32x8<S>; 2]) -> V3<f32x8<S>> {
    let [x, y] = square_to_disk(u);
    V3 { x, y, z: (1.0 - (x * x + y * y)).max(0.0).sqrt() }
}

/// Density of [`square_to_cosine_hemisphere`] by solid angle.
#[inline(always)]
pub(crate) fn square_to_cosine_hemisphere_pdf<S: Simd>(cos_theta: f32x8<S>) -> f32x8<S> {
    cos_theta.max(0.0) * FRAC_1_PI
}

/// Directions around +z, all alike (PBR 13.6.1).
#[inline(always)]
pub(crate) fn square_to_uniform_hemisphere<S: Simd>([u, v]: [f32x8<S>; 2]) -> V3<f32x8<S>> {
    let sin_theta = (1.0 - u * u).max(0.0).sqrt();
    let [cos, sin] = at_turn(v);
    V3 { x: cos * sin_theta, y: sin * sin_theta, z: u }
}
