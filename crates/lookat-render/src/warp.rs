//! From the unit square to other domains, with the densities that result; and from a number to one of several amounts.

pub(crate) mod lanes;

use std::f64::consts::{FRAC_PI_4, TAU};

use glam::{DVec2, DVec3, Vec2Swizzles};

use crate::circle::{at_angle, at_turn};

/// Uniform on the unit disk (Shirley and Chiu's concentric map; PBR 13.6.2).
pub(crate) fn square_to_disk(u: DVec2) -> DVec2 {
    let p = 2.0 * u - DVec2::ONE;
    if p == DVec2::ZERO {
        return p;
    }
    if p.x.abs() > p.y.abs() {
        at_angle(FRAC_PI_4 * (p.y / p.x)) * p.x
    } else {
        at_angle(FRAC_PI_4 * (p.x / p.y)).yx() * p.y
    }
}

/// Density of [`lanes::square_to_uniform_hemisphere`] by solid angle.
pub(crate) fn square_to_uniform_hemisphere_pdf() -> f32 {
    1.0 / TAU as f32
}

/// Directions within a cone around +z, given `1 - cos` of its half angle, which small cones need for accuracy.
pub(crate) fn square_to_uniform_cone(u: DVec2, one_minus_cos_max: f64) -> DVec3 {
    let one_minus_cos = u.x * one_minus_cos_max;
    let sin_theta = (one_minus_cos * (2.0 - one_minus_cos)).max(0.0).sqrt();
    (at_turn(u.y) * sin_theta).extend(1.0 - one_minus_cos)
}

/// Density of [`square_to_uniform_cone`] by solid angle.
pub(crate) fn square_to_uniform_cone_pdf(one_minus_cos_max: f64) -> f64 {
    1.0 / (TAU * one_minus_cos_max)
}

/// Weights of the first two corners of a triangle, for points all alike (PBR 13.6.5).
pub(crate) fn square_to_triangle(u: DVec2) -> [f64; 2] {
    let root = u.x.sqrt();
    [1.0 - root, u.y * root]
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

/// The first of some amounts with which their sum passes `at`, or else the last; how much it is, and how much of it is
/// passed.
pub(crate) fn pick(amounts: impl Iterator<Item = f64>, at: f64) -> Option<(usize, f64, f64)> {
    let (mut rest, mut last) = (at, None);
    for (index, amount) in amounts.enumerate() {
        last = Some((index, amount, rest));
        rest -= amount;
        if rest < 0.0 {
            break;
        }
    }
    last
}
