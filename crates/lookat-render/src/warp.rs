//! From the unit square to other domains, with the densities that result; and from a number to one of several amounts.

pub(crate) mod lanes;

use std::f64::consts::{FRAC_PI_4, TAU};

use glam::{DVec2, Vec2Swizzles};

use crate::circle::at_angle;

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
