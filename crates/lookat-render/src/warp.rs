//! From the unit square to other domains, with the densities that result; and from a number to one of several amounts.

use std::array::from_fn;
use std::f32::consts::FRAC_1_PI;
use std::f64::consts::{FRAC_PI_4, TAU};

use fearless_simd::{Simd, f32x8, f64x8, prelude::*};

use crate::circle::{Angle, at_turn};
use crate::number::{LANES, Number, V3};

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

#[cfg(test)]
mod tests {
    use super::*;
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
}
