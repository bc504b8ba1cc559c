//! From the unit square to other domains with the densities that result (PBR 13.6), points of the unit circle, and choices among
//! weights.

use std::array::from_fn;
use std::f32::consts::FRAC_1_PI;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use fearless_simd::{Simd, f32x8, f64x8, prelude::*};
use glam::DVec2;

use crate::number::{LANES, Number, V3, Vec3fx8, Vec3x8};

/// Uniform on the unit disk (Shirley and Chiu's concentric map; PBR 13.6.2).
#[inline(always)]
pub(crate) fn square_to_disk<T: Number + Angle>([u, v]: [T; 2]) -> [T; 2] {
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
pub(crate) fn square_to_cosine_hemisphere<S: Simd>(u: [f32x8<S>; 2]) -> Vec3fx8<S> {
    let [x, y] = square_to_disk(u);
    V3 { x, y, z: (1.0 - (x * x + y * y)).max(0.0).sqrt() }
}

/// Density of [`square_to_cosine_hemisphere`] by solid angle.
#[inline(always)]
pub(crate) fn square_to_cosine_hemisphere_pdf<S: Simd>(cos_theta: f32x8<S>) -> f32x8<S> {
    cos_theta.max(0.0) * FRAC_1_PI
}

/// Directions around +z with uniform density (PBR 13.6.1).
#[inline(always)]
pub(crate) fn square_to_uniform_hemisphere<S: Simd>([u, v]: [f32x8<S>; 2]) -> Vec3fx8<S> {
    let sin_theta = (1.0 - u * u).max(0.0).sqrt();
    let [cos, sin] = at_turn(v);
    V3 { x: cos * sin_theta, y: sin * sin_theta, z: u }
}

/// Density of [`square_to_uniform_hemisphere`] by solid angle.
pub(crate) fn square_to_uniform_hemisphere_pdf() -> f32 {
    1.0 / TAU as f32
}

/// For each of some lists of equal length, which add up amounts, the amount with which the sum passes a share `u` of the total, and what
/// is left of `u`, from 0 to 1 again (PBR 13.3). All are searched together, as each step waits for memory.
#[inline(always)]
pub(crate) fn sample_discrete<S: Simd>(
    simd: S,
    sums: [&[f64]; LANES],
    u: f64x8<S>,
) -> ([usize; LANES], f64x8<S>) {
    let at: [f64; LANES] = from_fn(|lane| u[lane] * sums[lane][sums[lane].len() - 1]);
    let (mut first, mut count) = ([0; LANES], sums[0].len());
    while count > 1 {
        let half = count / 2;
        for lane in 0..LANES {
            let is_beyond = sums[lane][first[lane] + half - 1] <= at[lane];
            first[lane] += if is_beyond { half } else { 0 };
        }
        count -= half;
    }
    let end: f64x8<S> = f64x8::from_fn(simd, |lane| sums[lane][first[lane]]);
    let before: f64x8<S> =
        f64x8::from_fn(simd, |lane| if first[lane] == 0 { 0.0 } else { sums[lane][first[lane] - 1] });
    let at: f64x8<S> = at.simd_into(simd);
    (first, ((at - before) / (end - before)).max(0.0).min(1.0))
}

/// A number from 0 to 1 with a density that goes linearly from `ends[0]` to `ends[1]`, times a factor (PBR4 2.3.2).
pub(crate) fn linear(u: f64, ends: [f64; 2]) -> f64 {
    let [a, b] = ends;
    // Exactly 0 for u = 0, and never beyond 1.
    let root = (a * a + (b * b - a * a) * u).sqrt();
    if u == 0.0 { 0.0 } else { (u * (a + b) / (a + root)).min(1.0) }
}

/// Density of [`linear`].
pub(crate) fn linear_pdf(x: f64, ends: [f64; 2]) -> f64 {
    let [a, b] = ends;
    2.0 * (a + (b - a) * x) / (a + b)
}

/// Angles of at most an eighth of the way around, either way.
pub(crate) trait Angle: Sized {
    /// The points of the circle there.
    fn point(self) -> [Self; 2];
}

impl<S: Simd> Angle for f64x8<S> {
    /// Polynomials of fdlibm (`k_cos.c` and `k_sin.c`), off by less than 2^-57; rounding adds at most two units in the last place.
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
    /// Polynomials of Cephes (`sinf.c` and `cosf.c`).
    #[inline(always)]
    fn point(self) -> [Self; 2] {
        let (angle, z) = (self, self * self);
        let sin = (z * -1.951_529_6e-4 + 8.332_161e-3) * z - 1.666_665_5e-1;
        let cos = (z * 2.443_315_7e-5 - 1.388_731_6e-3) * z + 4.166_664_6e-2;
        [1.0 - (0.5 * z - z * z * cos), angle + angle * z * sin]
    }
}

/// The point at an angle in radians.
pub(crate) fn at_angle(angle: f64) -> DVec2 {
    let (sin, cos) = libm::sincos(angle);
    DVec2::new(cos, sin)
}

/// The points at `turn` of the way around from (1, 0) to (0, 1) and on, for numbers from 0 to 1.
#[inline(always)]
pub(crate) fn at_turn<T: Number + Angle>(turn: T) -> [T; 2] {
    let n = |x| T::of(turn.token(), x);
    let quarter = (turn * n(4.0) + n(0.5)).trunc();
    let [x, y] = (n(TAU) * (turn - quarter * n(0.25))).point();
    let is_odd = quarter.simd_eq(n(1.0)) | quarter.simd_eq(n(3.0));
    let (x, y) = (is_odd.select(-y, x), is_odd.select(x, y));
    let is_back = quarter.simd_eq(n(2.0)) | quarter.simd_eq(n(3.0));
    [is_back.select(-x, x), is_back.select(-y, y)]
}

/// The angle from (1, 0) to the point (`x`, `y`), from minus pi to pi; the polynomials are those of Cephes (`atan.c`), off by a few units
/// in the last place.
#[inline(always)]
pub(crate) fn angle<S: Simd>(y: f64x8<S>, x: f64x8<S>) -> f64x8<S> {
    let zero: f64x8<S> = 0.0.simd_into(x.token());
    let (width, height) = (x.abs(), y.abs());
    let is_steep = height.simd_gt(width);
    let (short, long) = (is_steep.select(width, height), is_steep.select(height, width));
    // Half of the eighth of a turn and more: less than an eighth remains.
    let is_wide = short.simd_gt(long * 0.66);
    let slope = is_wide.select(short - long, short) / is_wide.select(short + long, long);
    let slope = (short.simd_eq(0.0) | slope.is_nan()).select(zero, slope);
    let z = slope * slope;
    let above = (((ATAN[0] * z + ATAN[1]) * z + ATAN[2]) * z + ATAN[3]) * z + ATAN[4];
    let below = ((((z + BELOW[0]) * z + BELOW[1]) * z + BELOW[2]) * z + BELOW[3]) * z + BELOW[4];
    let rest = slope + slope * (z * above / below);
    let eighth = is_wide.select(rest + FRAC_PI_4, rest);
    let quarter = is_steep.select(FRAC_PI_2 - eighth, eighth);
    x.is_sign_negative().select(PI - quarter, quarter).copysign(y)
}

/// The longitude of directions of any length, from +x by way of +y, and the latitude, from +z; each from 0 to 1.
#[inline(always)]
pub(crate) fn longitude_latitude<S: Simd>(d: Vec3x8<S>) -> [f64x8<S>; 2] {
    let longitude = angle(d.y, d.x) * (1.0 / TAU);
    let latitude = angle((d.x * d.x + d.y * d.y).sqrt(), d.z) * (1.0 / PI);
    [longitude.simd_lt(0.0).select(longitude + 1.0, longitude), latitude]
}

/// The numerator of a rational approximation of the arc tangent, from the highest power on.
const ATAN: [f64; 5] = [
    -8.750608600031904e-1,
    -1.6157537187333652e1,
    -7.500855792314705e1,
    -1.2288666844901361e2,
    -6.485021904942025e1,
];

/// The denominator of the approximation, after a first coefficient of 1.
const BELOW: [f64; 5] =
    [2.485846490142306e1, 1.650270098316988e2, 4.328810604912903e2, 4.853903996359137e2, 1.945506571482614e2];

/// Coefficients of the sine: angle^3, angle^5 and so on.
const SIN: [f64; 6] = [
    -0.16666666666666632,
    0.00833333333332249,
    -0.0001984126982985795,
    2.7557313707070068e-06,
    -2.5050760253406863e-08,
    1.58969099521155e-10,
];

/// Coefficients of the cosine: angle^4, angle^6 and so on.
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
    use super::*;
    use crate::number::splat_f32;
    use crate::testing::baseline;

    /// Of a million triangles that are alike, each is chosen by the numbers of its share, and what is left of these has 32 bits.
    #[test]
    fn each_of_a_million_has_its_share() {
        const COUNT: usize = 1_000_000;
        let sums: Vec<f64> = (1..=COUNT).map(|number| number as f64 * 0.3).collect();
        baseline!(simd => {
            for first in (0..COUNT).step_by(LANES) {
                for part in [1e-9, 0.7, 1.0 - 1e-9] {
                    let u = f64x8::from_fn(simd, |lane| ((first + lane) as f64 + part) / COUNT as f64);
                    let (found, rest) = sample_discrete(simd, [&sums; LANES], u);
                    for lane in 0..LANES {
                        assert_eq!(found[lane], first + lane);
                        assert!((rest[lane] - part).abs() < 2_f64.powi(-32), "{first} {lane} {}", rest[lane]);
                    }
                }
            }
        });
    }

    fn point(angle: f64) -> DVec2 {
        baseline!(simd => DVec2::from(f64x8::splat(simd, angle).point().map(|x| x[0])))
    }

    fn turned(turn: f64) -> DVec2 {
        baseline!(simd => DVec2::from(at_turn(f64x8::splat(simd, turn)).map(|x| x[0])))
    }

    /// Half of the last place of numbers just below one.
    const UNIT: f64 = f64::EPSILON / 2.0;

    #[test]
    fn points_are_those_of_sine_and_cosine() {
        for k in 0..=100_000 {
            let share = f64::from(k) / 100_000.0;
            let angle = FRAC_PI_4 * (2.0 * share - 1.0);
            let error = point(angle) - DVec2::new(angle.cos(), angle.sin());
            assert!(error.abs().max_element() <= 2.0 * UNIT, "{angle}: {error}");
            // The angle itself is rounded too.
            let error = turned(share) - DVec2::from_angle(TAU * share);
            assert!(error.abs().max_element() <= 8.0 * UNIT, "{share}: {error}");
        }
    }

    #[test]
    fn quarters_of_a_turn_are_exact() {
        for (turn, p) in
            [(0.0, DVec2::X), (0.25, DVec2::Y), (0.5, -DVec2::X), (0.75, -DVec2::Y), (1.0, DVec2::X)]
        {
            assert_eq!(turned(turn), p);
        }
    }

    #[test]
    fn angles_are_those_of_the_arc_tangent() {
        let of = |y: f64, x: f64| baseline!(simd => angle(y.simd_into(simd), x.simd_into(simd))[0]);
        for k in -100_000..=100_000 {
            let (y, x) = (TAU * f64::from(k) / 200_000.0).sin_cos();
            for scale in [1.0, 1e-300, 1e300] {
                let (y, x) = (y * scale, x * scale);
                assert!((of(y, x) - y.atan2(x)).abs() <= 8.0 * f64::EPSILON, "{y} {x}");
            }
        }
        for (y, x) in [(0.0, 0.0), (0.0, -1.0), (-0.0, -1.0), (1.0, 0.0), (-1.0, 0.0), (1e-310, 1.0)] {
            assert_eq!(of(y, x), f64::atan2(y, x), "{y} {x}");
        }
    }

    #[test]
    fn points_of_f32_are_those_of_sine_and_cosine() {
        for k in 0..=100_000 {
            let turn = k as f32 / 100_000.0;
            let [x, y] = baseline!(simd => at_turn(splat_f32(simd, turn)).map(|x| x[0]));
            let (sin, cos) = (TAU * f64::from(turn)).sin_cos();
            let error = (f64::from(x) - cos).abs().max((f64::from(y) - sin).abs());
            assert!(error <= 2.0 * f64::from(f32::EPSILON), "{turn}: {error}");
        }
    }
}
