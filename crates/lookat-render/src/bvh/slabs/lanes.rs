//! Rays side by side against a box.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::DVec3;

use super::PAD;
use crate::lanes::Vec3x8;

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
