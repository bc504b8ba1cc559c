//! Rough surfaces of many small facets (PBR 8.4). Directions are in the shading frame.

use std::f32::consts::PI;

use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use glam::Vec3;

use super::fresnel::dielectric;
use crate::number::{V3, Vec3fx8};
use crate::warp::square_to_disk;

/// The least width, as in pbrt-v3: a mirror in all but name.
const LEAST: f32 = 1e-3;
/// The largest, so that products of widths stay finite.
const MOST: f32 = 1e6;

/// A width within the limits of a distribution; the least for NaN.
pub(super) fn alpha(width: f64) -> f32 {
    let width = width as f32;
    if width > LEAST { width.min(MOST) } else { LEAST }
}

/// Widths within the limits of a distribution.
#[inline(always)]
pub(super) fn in_range<S: Simd>(width: f32x8<S>) -> f32x8<S> {
    width.max(LEAST).min(MOST)
}

/// The width that pbrt-v3 gives a roughness from 0 to 1 (PBR 8.4.2).
pub(super) fn alpha_of_roughness(roughness: f64) -> f64 {
    let x = libm::log(roughness.max(1e-3));
    1.62142 + x * (0.819955 + x * (0.1734 + x * (0.0171201 + x * 0.000640711)))
}

/// Trowbridge and Reitz's distribution of the normals of facets (GGX): its widths along the two axes of the frame.
#[derive(Clone, Copy)]
pub(super) struct TrowbridgeReitz<S: Simd> {
    pub alpha: [f32x8<S>; 2],
    /// True if facets are hidden from the two directions independently, as in Disney's material.
    pub is_separable: bool,
}

impl<S: Simd> TrowbridgeReitz<S> {
    /// Density of normals around `wh`, by area of the surface (`D`).
    #[inline(always)]
    pub fn density(&self, wh: Vec3fx8<S>) -> f32x8<S> {
        let [ax, ay] = self.alpha;
        let (x, y) = (wh.x / ax, wh.y / ay);
        let slope = x * x + y * y + wh.z * wh.z;
        1.0 / (PI * ax * ay * slope * slope)
    }

    /// The cosine of `w` by the share of facets that it sees, `|cos| (1 + Lambda)`: without Smith's fractions, which grow beyond all
    /// bounds at grazing angles.
    #[inline(always)]
    fn unmasked(&self, w: Vec3fx8<S>) -> f32x8<S> {
        let (x, y) = (w.x * self.alpha[0], w.y * self.alpha[1]);
        ((w.z * w.z + (x * x + y * y)).sqrt() + w.z.abs()) * 0.5
    }

    /// `|cos_o cos_i| / G`, where `G` is the share of facets that both directions see; and the same of `wo` alone.
    #[inline(always)]
    fn masked(&self, wo: Vec3fx8<S>, wi: Vec3fx8<S>) -> (f32x8<S>, f32x8<S>) {
        let (of_o, of_i) = (self.unmasked(wo), self.unmasked(wi));
        if self.is_separable {
            return (of_o * of_i, of_o);
        }
        let (cos_o, cos_i) = (wo.z.abs(), wi.z.abs());
        (cos_i * of_o + cos_o * (of_i - cos_i), of_o)
    }

    /// The reflection of facets with a Fresnel term of 1, and the density of [`TrowbridgeReitz::reflected`].
    #[inline(always)]
    pub fn reflection(&self, wo: Vec3fx8<S>, wi: Vec3fx8<S>, wh: Vec3fx8<S>) -> (f32x8<S>, f32x8<S>) {
        let density = self.density(wh) * 0.25;
        let (both, of_o) = self.masked(wo, wi);
        (density / both, density / of_o)
    }

    /// Transmission by facets between media of relative index `eta`. Returns the transmitted radiance, the density of
    /// directions that visible facets refract, the cosine between `wo` and the facet, and a mask of the lanes with such a
    /// facet. pbrt-v3 also counts facets that one direction sees from behind, but never samples them.
    #[inline(always)]
    pub fn transmission(
        &self,
        eta: f32x8<S>,
        wo: Vec3fx8<S>,
        wi: Vec3fx8<S>,
    ) -> (f32x8<S>, f32x8<S>, f32x8<S>, mask32x8<S>) {
        let ratio = ratio(wo.z, eta);
        let (wh, is_valid) = (wo + wi * ratio).try_normalize();
        let wh = upward(wh);
        let (cos_o, cos_i) = (wo.dot(wh), wi.dot(wh));
        let is_valid =
            is_valid & (wo.z * wi.z).simd_lt(0.0) & (cos_o * wo.z).simd_gt(0.0) & (cos_i * wi.z).simd_gt(0.0);
        // Solid angle around `wi` over solid angle of the normals.
        let sum = cos_o + ratio * cos_i;
        let spread = ratio * ratio * cos_i.abs() / (sum * sum);
        let density = self.density(wh) * spread * cos_o.abs();
        let (both, of_o) = self.masked(wo, wi);
        // Radiance is denser where the index is larger.
        let value = (1.0 - dielectric(cos_o, eta)) * density / (ratio * ratio * both);
        (value, density / of_o, cos_o, is_valid)
    }

    /// One of the normals that `wo` sees, on its side (Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT
    /// 7(4), 2018).
    #[inline(always)]
    pub fn visible_normal(&self, wo: Vec3fx8<S>, u: [f32x8<S>; 2]) -> Vec3fx8<S> {
        let simd = wo.z.token();
        let is_below = wo.z.simd_lt(0.0);
        let up = (-wo).keep_where(is_below, wo);
        let [ax, ay] = self.alpha;
        let stretched = V3 { x: up.x * ax, y: up.y * ay, z: up.z }.normalize();
        let across = V3 { x: -stretched.y, y: stretched.x, z: 0.0.simd_into(simd) }.normalize_or(Vec3::X);
        let along = stretched.cross(across);
        // Keeps what is near in the square near on the disk: less noise than with polar coordinates.
        let ([x, y], s) = (square_to_disk(u), 0.5 * (1.0 + stretched.z));
        let y = (1.0 - s) * (1.0 - x * x).max(0.0).sqrt() + s * y;
        let n = across * x + along * y + stretched * (1.0 - x * x - y * y).max(0.0).sqrt();
        let wh = V3 { x: n.x * ax, y: n.y * ay, z: n.z.max(0.0) }.normalize_or(Vec3::Z);
        (-wh).keep_where(is_below, wh)
    }

    /// A direction that a facet reflects to `wo`, and where there is one.
    #[inline(always)]
    pub fn reflected(&self, wo: Vec3fx8<S>, u: [f32x8<S>; 2]) -> (Vec3fx8<S>, mask32x8<S>) {
        reflected(wo, self.visible_normal(wo, u))
    }
}

/// The direction that a facet reflects to `wo`, and where there is one.
#[inline(always)]
pub(super) fn reflected<S: Simd>(wo: Vec3fx8<S>, wh: Vec3fx8<S>) -> (Vec3fx8<S>, mask32x8<S>) {
    let wi = wh * (2.0 * wo.dot(wh)) - wo;
    (wi, (wi.z * wo.z).simd_gt(0.0))
}

/// The direction that a facet refracts to `wo`, and where there is one.
#[inline(always)]
pub(super) fn refracted<S: Simd>(eta: f32x8<S>, wo: Vec3fx8<S>, wh: Vec3fx8<S>) -> (Vec3fx8<S>, mask32x8<S>) {
    let (ratio, cos) = (ratio(wo.z, eta), wo.dot(wh));
    let along = (wh * cos - wo) * (1.0 / ratio);
    let squared = 1.0 - along.length_squared();
    let wi = (along - wh * squared.max(0.0).sqrt()).normalize();
    (wi, squared.simd_gt(0.0) & cos.simd_gt(0.0) & (wo.z * wi.z).simd_lt(0.0))
}

/// The normal that reflects one direction into the other, and where there is one: not where a direction is in the plane of the surface.
#[inline(always)]
pub(super) fn half<S: Simd>(wo: Vec3fx8<S>, wi: Vec3fx8<S>) -> (Vec3fx8<S>, mask32x8<S>) {
    let (wh, is_valid) = (wo + wi).try_normalize();
    (wh, is_valid & wo.z.simd_ne(0.0) & wi.z.simd_ne(0.0))
}

/// Normals of facets are on the side of the surface's, so that light from within is told from light from outside.
#[inline(always)]
pub(super) fn upward<S: Simd>(wh: Vec3fx8<S>) -> Vec3fx8<S> {
    (-wh).keep_where(wh.z.simd_lt(0.0), wh)
}

/// The index on the side of `wi` by that on the side of `wo`.
#[inline(always)]
pub(super) fn ratio<S: Simd>(cos_o: f32x8<S>, eta: f32x8<S>) -> f32x8<S> {
    cos_o.simd_gt(0.0).select(eta, 1.0 / eta)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::number::splat_f32;
    use crate::testing::baseline;

    /// Facets cover the surface exactly: the density times the cosine is one in all.
    #[test]
    fn facets_cover_the_surface() {
        for [x, y] in [[0.3, 0.3], [0.8, 0.2]] {
            let side = 800;
            let cell = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
            let sum: f64 = baseline!(simd => {
                let alpha = [splat_f32(simd, x), splat_f32(simd, y)];
                let facets = TrowbridgeReitz { alpha, is_separable: false };
                (0..side * side)
                    .map(|i| {
                        let (cos, phi) = (cell(i / side), TAU * cell(i % side));
                        let sin = (1.0 - cos * cos).sqrt();
                        let wh = V3::splat(simd, [sin * phi.cos(), sin * phi.sin(), cos].map(|x| x as f32));
                        f64::from(facets.density(wh)[0]) * cos
                    })
                    .sum()
            });
            assert!((sum * TAU / f64::from(side * side) - 1.0).abs() < 1e-3, "{x} {y} {sum}");
        }
    }

    #[test]
    fn roughness_becomes_the_width_of_pbrt() {
        assert!((alpha_of_roughness(1.0) - 1.62142).abs() < 1e-12);
        // Of 0.1: by hand.
        assert!((alpha_of_roughness(0.1) - 0.46176).abs() < 1e-5);
    }
}
