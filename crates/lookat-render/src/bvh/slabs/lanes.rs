//! Rays side by side against boxes.

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};
use glam::DVec3;

use super::{PAD, SLACK};
use crate::lanes::{LANES, Vec3x8, splat_f32, to_f32};

/// Rays as they are tested against boxes.
#[derive(Clone, Copy)]
pub(crate) struct BoxRays<S: Simd> {
    o: [f64x8<S>; 3],
    /// One over the direction.
    inverse: [f64x8<S>; 3],
    /// Where the direction is negative along an axis.
    negative: [mask64x8<S>; 3],
}

impl<S: Simd> BoxRays<S> {
    #[inline(always)]
    pub fn new(o: Vec3x8<S>, d: Vec3x8<S>) -> Self {
        let inverse = [1.0 / d.x, 1.0 / d.y, 1.0 / d.z];
        let negative =
            [inverse[0].is_sign_negative(), inverse[1].is_sign_negative(), inverse[2].is_sign_negative()];
        BoxRays { o: [o.x, o.y, o.z], inverse, negative }
    }

    /// One over the directions.
    #[inline(always)]
    pub fn inverse(&self) -> Vec3x8<S> {
        let [x, y, z] = self.inverse;
        Vec3x8 { x, y, z }
    }

    /// Where they enter and leave the box between two corners; as `slabs` does, to the bit.
    #[inline(always)]
    pub fn ends(&self, simd: S, low: &DVec3, high: &DVec3) -> (f64x8<S>, f64x8<S>) {
        let (mut near, mut far): (f64x8<S>, f64x8<S>) = (0.0.simd_into(simd), f64::INFINITY.simd_into(simd));
        for axis in 0..3 {
            let (o, inverse, negative) = (self.o[axis], self.inverse[axis], self.negative[axis]);
            let (low, high) = ((low[axis] - o) * inverse, (high[axis] - o) * inverse);
            let (enter, leave) = (negative.select(high, low), negative.select(low, high) * PAD);
            // A NaN drops out, because it compares as false.
            near = enter.simd_gt(near).select(enter, near);
            far = leave.simd_lt(far).select(leave, far);
        }
        (near, far)
    }
}

/// [`super::Slabs`] of eight rays.
pub(crate) struct ManySlabs {
    pub near_o: [[f32; LANES]; 3],
    pub far_o: [[f32; LANES]; 3],
    pub near_inverse: [[f32; LANES]; 3],
    pub far_inverse: [[f32; LANES]; 3],
    /// Where directions are negative along each axis, as bits.
    negative: [u64; 3],
}

impl ManySlabs {
    pub const NOTHING: ManySlabs = ManySlabs {
        near_o: [[0.0; LANES]; 3],
        far_o: [[0.0; LANES]; 3],
        near_inverse: [[0.0; LANES]; 3],
        far_inverse: [[0.0; LANES]; 3],
        negative: [0; 3],
    };

    /// As [`super::Slabs::new`], to the bit. `inverse` is one over the directions.
    #[inline(always)]
    pub fn put<S: Simd>(&mut self, simd: S, o: Vec3x8<S>, inverse: Vec3x8<S>) {
        let (o, inverse) = ([o.x, o.y, o.z], [inverse.x, inverse.y, inverse.z]);
        for axis in 0..3 {
            let (o, inverse) = (to_f32(o[axis]), to_f32(inverse[axis]));
            let [near_o, far_o, near_inverse, far_inverse] = conservative(simd, o, inverse);
            near_o.store_slice(&mut self.near_o[axis]);
            far_o.store_slice(&mut self.far_o[axis]);
            near_inverse.store_slice(&mut self.near_inverse[axis]);
            far_inverse.store_slice(&mut self.far_inverse[axis]);
            self.negative[axis] = inverse.is_sign_negative().to_bitmask();
        }
    }

    /// Along each axis, which of the two planes of a box one of the rays enters it at.
    #[inline(always)]
    pub fn near(&self, lane: usize) -> [usize; 3] {
        let [x, y, z] = self.negative;
        [(x >> lane & 1) as usize, (y >> lane & 1) as usize, (z >> lane & 1) as usize]
    }
}

/// The origin and one over the direction along an axis, for the planes where boxes are entered and where they are left; as
/// [`super::Slabs::new`] rounds them: `near_o`, `far_o`, `near_inverse` and `far_inverse`.
#[inline(always)]
pub(super) fn conservative<S: Simd>(simd: S, o: f32x8<S>, inverse: f32x8<S>) -> [f32x8<S>; 4] {
    let (least, most) = (splat_f32(simd, f32::MIN_POSITIVE), splat_f32(simd, f32::MAX));
    let along = (o.abs() * f32::EPSILON + least).copysign(inverse);
    let is_tiny = inverse.abs().simd_lt(least);
    let near_inverse = (inverse * (1.0 - SLACK)).max(-most).min(most);
    let far_inverse = is_tiny.select(least.copysign(inverse), inverse * (1.0 + SLACK));
    [o + along, o - along, is_tiny.select(splat_f32(simd, 0.0), near_inverse), far_inverse]
}
