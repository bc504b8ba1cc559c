//! Angles side by side.

use fearless_simd::{Simd, f64x8};

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
