//! Eight triangles, as rays pass them.

use fearless_simd::{Simd, f32x8, prelude::*};

use super::Triangle;
use crate::bvh::WIDTH;
use crate::number::splat_f32;

/// The corners of up to eight triangles in `f32`, and how far these are to be trusted.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Block {
    /// By corner, axis and triangle.
    pub corners: [[[f32; WIDTH]; 3]; 3],
    /// What rounding does to them.
    error: f32,
    /// Twice the longest side of the box of any of the triangles, or more.
    size: f32,
    /// A bit for each triangle.
    pub mask: u32,
    /// The place of the first triangle; those of the others follow.
    first: u32,
}

impl Block {
    /// Of one to eight triangles, with finite corners, and the place of the first.
    pub fn new(triangles: &[Triangle], first: usize) -> Self {
        debug_assert!((1..=WIDTH).contains(&triangles.len()));
        debug_assert!(triangles.iter().flat_map(|triangle| triangle.corners).all(|p| p.is_finite()));
        let (mut magnitude, mut extent) = (0.0, LEAST_SIZE);
        let mut corners = [[[0.0; WIDTH]; 3]; 3];
        for (lane, triangle) in triangles.iter().enumerate() {
            for (corner, p) in triangle.corners.iter().enumerate() {
                for axis in 0..3 {
                    corners[corner][axis][lane] = p[axis] as f32;
                }
                magnitude = p.abs().max_element().max(magnitude);
            }
            let [p, q, r] = &triangle.corners;
            let sides = p.max(*q).max(*r) - p.min(*q).min(*r);
            extent = sides.max_element().max(extent);
        }
        let is_safe = extent < MOST_SIZE && magnitude < f64::from(MOST_MAGNITUDE);
        Block {
            corners,
            error: if is_safe { 12.0 * UNIT * magnitude as f32 + f32::MIN_POSITIVE } else { f32::INFINITY },
            size: 2.0 * extent as f32,
            mask: (1 << triangles.len()) - 1,
            first: first as u32,
        }
    }

    /// The least and the greatest coordinates of the triangles along each axis, wider by what rounding has taken.
    #[inline(always)]
    pub fn boxes<S: Simd>(&self, simd: S) -> [[f32x8<S>; 3]; 2] {
        let mut boxes = [[splat_f32(simd, 0.0); 3]; 2];
        let [a, b, c] = &self.corners;
        for axis in 0..3 {
            let (a, b): (f32x8<S>, f32x8<S>) = (a[axis].simd_into(simd), b[axis].simd_into(simd));
            let c: f32x8<S> = c[axis].simd_into(simd);
            boxes[0][axis] = a.min(b).min(c) - self.error;
            boxes[1][axis] = a.max(b).max(c) + self.error;
        }
        boxes
    }

    /// What rounding may do, with rays that it does so much to.
    #[inline(always)]
    pub fn tolerance(&self, error: f32) -> Tolerance {
        let error = self.error + error;
        let size = self.size + 2.0 * error;
        Tolerance { error, size, side: 4.0 * size * (error + UNIT * size) }
    }

    /// The place of a triangle.
    #[inline(always)]
    pub fn place(&self, lane: u32) -> u32 {
        self.first + lane
    }

    /// The bit of the triangle at a place, if it is here.
    #[inline(always)]
    pub fn bit_of(&self, place: u32) -> u32 {
        let lane = place.wrapping_sub(self.first);
        u32::from(lane < WIDTH as u32) << (lane % WIDTH as u32)
    }
}

/// What rounding may do to triangles, seen from a ray that runs along z from the origin.
///
/// Corners and origin are rounded, and their difference, and its product with the shear: a corner moves by less than
/// `error`. Where the ray passes the box of a triangle, its corners are not farther from it than `size`. The cross
/// product of two of them then moves by less than `side`. Where products overflow or vanish, nothing is known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tolerance {
    pub error: f32,
    pub size: f32,
    pub side: f32,
}

/// The rounding of one operation, relative to its result.
pub(crate) const UNIT: f32 = f32::EPSILON / 2.0;

/// Products of smaller numbers vanish in `f32`.
const LEAST_SIZE: f64 = 1e-15;
/// Products of larger ones overflow.
const MOST_SIZE: f64 = 1e17;
/// Coordinates that may be rounded by more than that.
pub(crate) const MOST_MAGNITUDE: f32 = 1e23;
