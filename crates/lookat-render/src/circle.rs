//! Points of the unit circle, for samples: without the cases that the sine and cosine of any angle have.

pub(crate) mod lanes;

use glam::DVec2;

/// The point at an angle of at most an eighth of the way around, either way.
///
/// The polynomials are those of fdlibm (`k_cos.c` and `k_sin.c`), off by less than 2^-57; rounding adds two units in the
/// last place at most.
#[inline]
pub(crate) fn at_angle(angle: f64) -> DVec2 {
    let z = angle * angle;
    let w = z * z;
    let sin = SIN[0] + z * SIN[1] + w * (SIN[2] + z * SIN[3] + w * (SIN[4] + z * SIN[5]));
    let cos = COS[0] + z * COS[1] + w * (COS[2] + z * COS[3] + w * (COS[4] + z * COS[5]));
    DVec2::new(1.0 - (0.5 * z - w * cos), angle + angle * z * sin)
}

/// Those of angle^3, angle^5 and on.
const SIN: [f64; 6] = [
    -0.16666666666666632,
    0.00833333333332249,
    -0.0001984126982985795,
    2.7557313707070068e-06,
    -2.5050760253406863e-08,
    1.58969099521155e-10,
];

/// Those of angle^4, angle^6 and on.
const COS: [f64; 6] = [
    0.0416666666666666,
    -0.001388888888887411,
    2.480158728947673e-05,
    -2.7557314351390663e-07,
    2.087572321298175e-09,
    -1.1359647557788195e-11,
];

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_4, TAU};

    use fearless_simd::f64x8;
    use fearless_simd::prelude::*;

    use super::*;
    use crate::testing::baseline;

    fn at_turn(turn: f64) -> DVec2 {
        baseline!(simd => DVec2::from(lanes::at_turn::<_, f64x8<_>>(turn.simd_into(simd)).map(|x| x[0])))
    }

    /// Half of the last place of numbers just below one.
    const UNIT: f64 = f64::EPSILON / 2.0;

    #[test]
    fn points_are_those_of_sine_and_cosine() {
        for k in 0..=100_000 {
            let share = f64::from(k) / 100_000.0;
            let angle = FRAC_PI_4 * (2.0 * share - 1.0);
            let error = at_angle(angle) - DVec2::new(angle.cos(), angle.sin());
            assert!(error.abs().max_element() <= 2.0 * UNIT, "{angle}: {error}");
            // The angle itself is rounded too.
            let error = at_turn(share) - DVec2::from_angle(TAU * share);
            assert!(error.abs().max_element() <= 8.0 * UNIT, "{share}: {error}");
        }
    }

    #[test]
    fn quarters_of_a_turn_are_exact() {
        for (turn, p) in
            [(0.0, DVec2::X), (0.25, DVec2::Y), (0.5, -DVec2::X), (0.75, -DVec2::Y), (1.0, DVec2::X)]
        {
            assert_eq!(at_turn(turn), p);
        }
    }
}
