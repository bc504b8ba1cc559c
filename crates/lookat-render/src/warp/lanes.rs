//! Points of the unit square side by side.

use std::f64::consts::{FRAC_PI_4, PI};

use fearless_simd::{Simd, f64x8, prelude::*};

use crate::circle;
use crate::lanes::Vec3x8;

/// As [`super::square_to_disk`], to the bit.
#[inline(always)]
pub(crate) fn square_to_disk<S: Simd>([u, v]: [f64x8<S>; 2]) -> [f64x8<S>; 2] {
    let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    let is_wide = x.abs().simd_gt(y.abs());
    let (short, long) = (is_wide.select(y, x), is_wide.select(x, y));
    let [cos, sin] = circle::lanes::at_angle(FRAC_PI_4 * (short / long));
    let (cos, sin) = (cos * long, sin * long);
    let zero = x.simd_eq(0.0) & y.simd_eq(0.0);
    [zero.select(x, is_wide.select(cos, sin)), zero.select(y, is_wide.select(sin, cos))]
}

/// As [`super::square_to_cosine_hemisphere`], to the bit.
#[inline(always)]
pub(crate) fn square_to_cosine_hemisphere<S: Simd>(u: [f64x8<S>; 2]) -> Vec3x8<S> {
    let [x, y] = square_to_disk(u);
    Vec3x8 { x, y, z: (1.0 - (x * x + y * y)).max(0.0).sqrt() }
}

/// As [`super::square_to_cosine_hemisphere_pdf`].
#[inline(always)]
pub(crate) fn square_to_cosine_hemisphere_pdf<S: Simd>(cos_theta: f64x8<S>) -> f64x8<S> {
    cos_theta.max(0.0) / PI
}

/// Directions around +z, all alike (PBR 13.6.1).
#[inline(always)]
pub(crate) fn square_to_uniform_hemisphere<S: Simd>([u, v]: [f64x8<S>; 2]) -> Vec3x8<S> {
    let sin_theta = (1.0 - u * u).max(0.0).sqrt();
    let [cos, sin] = circle::lanes::at_turn(v);
    Vec3x8 { x: cos * sin_theta, y: sin * sin_theta, z: u }
}
