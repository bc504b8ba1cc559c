//! Trowbridge and Reitz's distributions side by side.

use std::f64::consts::PI;

use fearless_simd::{Simd, f64x8, prelude::*};
use glam::DVec3;

use crate::circle::lanes::at_turn;
use crate::lanes::Vec3x8;

/// As [`super::TrowbridgeReitz`], to the bit: widths along the two axes of the frame.
#[derive(Clone, Copy)]
pub(in crate::bsdf) struct Facets<S: Simd> {
    pub x: f64x8<S>,
    pub y: f64x8<S>,
}

impl<S: Simd> Facets<S> {
    #[inline(always)]
    pub fn density(&self, wh: Vec3x8<S>) -> f64x8<S> {
        let (x, y) = (wh.x / self.x, wh.y / self.y);
        let slope = x * x + y * y + wh.z * wh.z;
        1.0 / (PI * self.x * self.y * slope * slope)
    }

    #[inline(always)]
    pub fn lambda(&self, w: Vec3x8<S>) -> f64x8<S> {
        let (x, y) = (w.x * self.x, w.y * self.y);
        let squared = (x * x + y * y) / (w.z * w.z);
        ((1.0 + squared).sqrt() - 1.0) / 2.0
    }

    #[inline(always)]
    pub fn sample(&self, wo: Vec3x8<S>, [u, v]: [f64x8<S>; 2]) -> Vec3x8<S> {
        let simd = u.token();
        let zero: f64x8<S> = 0.0.simd_into(simd);
        let is_below = wo.z.simd_lt(0.0);
        let up = (-wo).or(is_below, wo);
        let stretched = Vec3x8 { x: up.x * self.x, y: up.y * self.y, z: up.z }.normalize();
        let (x, y) = (-stretched.y, stretched.x);
        let inverse = 1.0 / (x * x + y * y).sqrt();
        let across = Vec3x8 { x: x * inverse, y: y * inverse, z: zero }
            .or(inverse.is_finite() & inverse.simd_gt(0.0), Vec3x8::splat(simd, DVec3::X));
        let along = stretched.cross(across);
        let ([x, y], root) = (at_turn(v), u.sqrt());
        let (x, y, s) = (x * root, y * root, 0.5 * (1.0 + stretched.z));
        let y = (1.0 - s) * (1.0 - x * x).max(0.0).sqrt() + s * y;
        let n = across * x + along * y + stretched * (1.0 - x * x - y * y).max(0.0).sqrt();
        let wh = Vec3x8 { x: n.x * self.x, y: n.y * self.y, z: n.z.max(0.0) }.normalize_or(DVec3::Z);
        (-wh).or(is_below, wh)
    }
}
