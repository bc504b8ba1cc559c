//! Angles side by side.

use std::f64::consts::TAU;

use fearless_simd::{Simd, f32x8, f64x8, prelude::*};

use super::{COS, SIN};
use crate::lanes::Number;

/// Angles of at most an eighth of the way around, either way.
pub(crate) trait Angle: Sized {
    /// As [`super::at_angle`].
    fn point(self) -> [Self; 2];
}

impl<S: Simd> Angle for f64x8<S> {
    /// To the bit.
    #[inline(always)]
    fn point(self) -> [Self; 2] {
        let (angle, z) = (self, self * self);
        let w = z * z;
        let sin = SIN[0] + z * SIN[1] + w * (SIN[2] + z * SIN[3] + w * (SIN[4] + z * SIN[5]));
        let cos = COS[0] + z * COS[1] + w * (COS[2] + z * COS[3] + w * (COS[4] + z * COS[5]));
        [1.0 - (0.5 * z - w * cos), angle + angle * z * sin]
    }
}

impl<S: Simd> Angle for f32x8<S> {
    /// The polynomials are those of Cephes (`sinf.c` and `cosf.c`).
    #[inline(always)]
    fn point(self) -> [Self; 2] {
        let (angle, z) = (self, self * self);
        let sin = (z * -1.951_529_6e-4 + 8.332_161e-3) * z - 1.666_665_5e-1;
        let cos = (z * 2.443_315_7e-5 - 1.388_731_6e-3) * z + 4.166_664_6e-2;
        [1.0 - (0.5 * z - z * z * cos), angle + angle * z * sin]
    }
}

/// As [`super::at_turn`]; of `f64` to the bit.
#[inline(always)]
pub(crate) fn at_turn<S: Simd, T: Number<S> + Angle>(turn: T) -> [T; 2] {
    let n = |x| T::of(turn.token(), x);
    let quarter = (turn * n(4.0) + n(0.5)).trunc();
    let [x, y] = (n(TAU) * (turn - quarter * n(0.25))).point();
    let is_odd = quarter.simd_eq(n(1.0)) | quarter.simd_eq(n(3.0));
    let (x, y) = (is_odd.select(-y, x), is_odd.select(x, y));
    let is_back = quarter.simd_eq(n(2.0)) | quarter.simd_eq(n(3.0));
    [is_back.select(-x, x), is_back.select(-y, y)]
}
