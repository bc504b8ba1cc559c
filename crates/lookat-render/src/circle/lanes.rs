//! Angles side by side.

use std::f64::consts::TAU;

use fearless_simd::{Simd, f64x8, prelude::*};

use super::{COS, SIN};

/// As [`super::at_angle`], to the bit.
#[inline(always)]
pub(crate) fn at_angle<S: Simd>(angle: f64x8<S>) -> [f64x8<S>; 2] {
    let z = angle * angle;
    let w = z * z;
    let sin = SIN[0] + z * SIN[1] + w * (SIN[2] + z * SIN[3] + w * (SIN[4] + z * SIN[5]));
    let cos = COS[0] + z * COS[1] + w * (COS[2] + z * COS[3] + w * (COS[4] + z * COS[5]));
    [1.0 - (0.5 * z - w * cos), angle + angle * z * sin]
}

/// As [`super::at_turn`], to the bit.
#[inline(always)]
pub(crate) fn at_turn<S: Simd>(turn: f64x8<S>) -> [f64x8<S>; 2] {
    let quarter = (turn * 4.0 + 0.5).trunc();
    let [x, y] = at_angle(TAU * (turn - quarter * 0.25));
    let is_odd = quarter.simd_eq(1.0) | quarter.simd_eq(3.0);
    let (x, y) = (is_odd.select(-y, x), is_odd.select(x, y));
    let is_back = quarter.simd_eq(2.0) | quarter.simd_eq(3.0);
    [is_back.select(-x, x), is_back.select(-y, y)]
}
