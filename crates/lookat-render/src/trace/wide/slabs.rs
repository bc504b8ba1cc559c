//! Slab tests with fused multiply-add, of one ray against the eight boxes of a node.

use fearless_simd::{Simd, f32x8, prelude::*};

use super::MOST_RAYS;
use crate::bvh::{Node, max, min};
use crate::number::{LANES, splat_f32, three};
use crate::triangle::UNIT;

/// Rays prepared for tests against boxes, in `f32`.
///
/// A ray meets a plane `p` at the distance `p * inverse + c`, where `c` is minus the origin times `inverse`. With u for the rounding of
/// one operation, `inverse` is off by 2.01 u and `c` by 4.02 u; the sum, and the product where it is rounded, by u each. As
/// `p * inverse` is the distance t minus `c`, the result is off by less than 4.1 u |t| + 7.2 u |c|. So `c` is moved by 12 u |c|, and the
/// far end by 16 u |t|, which covers both ends. Unlike a bound by the largest plane, this does not widen boxes near the origin of a ray
/// where the world is large.
pub(super) struct FusedSlabs {
    inverse: [[f32; MOST_RAYS]; 3],
    /// `c` for the plane where boxes are entered: too small by the error, or more.
    near: [[f32; MOST_RAYS]; 3],
    /// `c` for the plane where boxes are left: too large by the error, or more.
    far: [[f32; MOST_RAYS]; 3],
    /// The index of the plane where boxes are entered, along each axis.
    first: [[u8; 3]; MOST_RAYS],
}

/// Along each axis a direction counts as at least this share of its largest coordinate, so that its inverse is not too large.
const LEAST: f32 = 1.0 / (1_u64 << 40) as f32;
/// This moves rays by less than this share of the coordinates that they come by.
const MOVED: f32 = 1.0 / (1_u64 << 36) as f32;
/// More than the absolute errors of numbers that vanish in `f32`.
const VANISHING: f32 = 1e-42;
/// Covers the error of both ends.
pub(super) const PAD: f32 = 1.0 + 16.0 * UNIT;

impl FusedSlabs {
    pub fn new() -> Self {
        let zero = [[0.0; MOST_RAYS]; 3];
        FusedSlabs { inverse: zero, near: zero, far: zero, first: [[0; 3]; MOST_RAYS] }
    }

    /// Sets eight rays from `first` on, whose origins and directions were rounded once to `f32`. `reach`: the largest coordinates of
    /// origins and boxes.
    #[inline(always)]
    pub fn set<S: Simd>(&mut self, first: usize, o: [f32x8<S>; 3], d: [f32x8<S>; 3], reach: f32x8<S>) {
        let own = first..first + LANES;
        let least = d[0].abs().max(d[1].abs()).max(d[2].abs()) * LEAST;
        let mut negative = [0; 3];
        for axis in 0..3 {
            let (size, tiny) = (d[axis].abs(), splat_f32(least.token(), f32::MIN_POSITIVE));
            let inverse = 1.0 / size.max(least).copysign(d[axis]);
            let c = -(o[axis] * inverse);
            // The absolute error of numbers that vanish in `f32` counts, too.
            let moved = size.simd_lt(least).select(reach * MOVED + tiny, tiny);
            let error = c.abs() * (12.0 * UNIT) + inverse.abs() * moved + VANISHING;
            inverse.store_slice(&mut self.inverse[axis][own.clone()]);
            (c - error).store_slice(&mut self.near[axis][own.clone()]);
            (c + error).store_slice(&mut self.far[axis][own.clone()]);
            negative[axis] = d[axis].is_sign_negative().to_bitmask();
        }
        for (lane, first) in self.first[own].iter_mut().enumerate() {
            *first = three!(axis, (negative[axis] >> lane & 1) as u8);
        }
    }

    /// The distances where a ray enters the boxes of a node, at least 0 and at most [`PAD`] times too large, and bits of those that it may
    /// hit before `limit`.
    #[inline(always)]
    pub fn meet<S: Simd>(&self, simd: S, ray: usize, node: &Node, limit: f32) -> (f32x8<S>, u32) {
        let (mut near, mut far) = (splat_f32(simd, 0.0), splat_f32(simd, limit));
        for axis in 0..3 {
            let first = usize::from(self.first[ray][axis] & 1);
            let inverse = splat_f32(simd, self.inverse[axis][ray]);
            let enter = f32x8::from_slice(simd, &node.planes[axis][first]);
            let leave = f32x8::from_slice(simd, &node.planes[axis][1 - first]);
            // A NaN, where infinity meets infinity, drops out.
            near = max(enter.mul_add(inverse, splat_f32(simd, self.near[axis][ray])), near);
            far = min(leave.mul_add(inverse, splat_f32(simd, self.far[axis][ray])), far);
        }
        (near, near.simd_le(far * PAD).to_bitmask() as u32)
    }
}
