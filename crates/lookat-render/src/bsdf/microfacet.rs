//! The distribution of the normals of a rough surface, by Trowbridge and Reitz (GGX; PBR 8.4). Directions are in the
//! shading frame.

pub(super) mod lanes;

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::circle::at_turn;

/// The least width, as in pbrt-v3: a mirror in all but name.
const LEAST: f64 = 1e-3;

/// Trowbridge and Reitz's distribution.
#[derive(Debug, Clone, Copy)]
pub(super) struct TrowbridgeReitz {
    /// Width along the two axes of the frame, at least 1e-3.
    alpha: DVec2,
}

impl TrowbridgeReitz {
    pub fn new(alpha: DVec2) -> Self {
        TrowbridgeReitz { alpha: alpha.max(DVec2::splat(LEAST)) }
    }

    /// The width that pbrt-v3 gives a roughness from 0 to 1 (PBR 8.4.2).
    pub fn alpha_of(roughness: f64) -> f64 {
        let x = roughness.max(1e-3).ln();
        1.62142 + x * (0.819955 + x * (0.1734 + x * (0.0171201 + x * 0.000640711)))
    }

    /// Its widths.
    pub fn alpha(&self) -> DVec2 {
        self.alpha
    }

    /// Density of normals around `wh`, by area of the surface (`D`).
    pub fn density(&self, wh: DVec3) -> f64 {
        let slope = (wh.truncate() / self.alpha).length_squared() + wh.z * wh.z;
        1.0 / (PI * self.alpha.x * self.alpha.y * slope * slope)
    }

    /// What is hidden, by what is seen, from direction `w` (`Lambda`).
    fn lambda(&self, w: DVec3) -> f64 {
        let squared = (w.truncate() * self.alpha).length_squared() / (w.z * w.z);
        ((1.0 + squared).sqrt() - 1.0) / 2.0
    }

    /// The share of facets that both directions see (`G`).
    pub fn masking_shadowing(&self, wo: DVec3, wi: DVec3) -> f64 {
        1.0 / (1.0 + self.lambda(wo) + self.lambda(wi))
    }

    /// Density of [`TrowbridgeReitz::sample`] by solid angle around `wh`.
    pub fn pdf(&self, wo: DVec3, wh: DVec3) -> f64 {
        self.density(wh) * wo.dot(wh).abs() / ((1.0 + self.lambda(wo)) * wo.z.abs())
    }

    /// One of the normals that `wo` sees, on its side (Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT
    /// 7(4), 2018).
    pub fn sample(&self, wo: DVec3, u: DVec2) -> DVec3 {
        let up = if wo.z < 0.0 { -wo } else { wo };
        let stretched = (up.truncate() * self.alpha).extend(up.z).normalize();
        let across = DVec2::new(-stretched.y, stretched.x).normalize_or(DVec2::X).extend(0.0);
        let along = stretched.cross(across);
        let (p, s) = (at_turn(u.y) * u.x.sqrt(), 0.5 * (1.0 + stretched.z));
        let x = p.x;
        let y = (1.0 - s) * (1.0 - x * x).max(0.0).sqrt() + s * p.y;
        let n = across * x + along * y + stretched * (1.0 - x * x - y * y).max(0.0).sqrt();
        let wh = (n.truncate() * self.alpha).extend(n.z.max(0.0)).normalize_or(DVec3::Z);
        if wo.z < 0.0 { -wh } else { wh }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Facets cover the surface exactly: the density times the cosine is one in all.
    #[test]
    fn facets_cover_the_surface() {
        for alpha in [DVec2::new(0.3, 0.3), DVec2::new(0.8, 0.2)] {
            let facets = TrowbridgeReitz::new(alpha);
            let side = 800;
            let cell = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
            let sum: f64 = (0..side * side)
                .map(|i| {
                    let (cos, phi) = (cell(i / side), TAU * cell(i % side));
                    let sin = (1.0 - cos * cos).sqrt();
                    facets.density(DVec3::new(sin * phi.cos(), sin * phi.sin(), cos)) * cos
                })
                .sum();
            assert!((sum * TAU / f64::from(side * side) - 1.0).abs() < 1e-3, "{alpha} {sum}");
        }
    }

    #[test]
    fn roughness_becomes_the_width_of_pbrt() {
        assert!((TrowbridgeReitz::alpha_of(1.0) - 1.62142).abs() < 1e-12);
        // Of 0.1: by hand.
        assert!((TrowbridgeReitz::alpha_of(0.1) - 0.46176).abs() < 1e-5);
    }
}
