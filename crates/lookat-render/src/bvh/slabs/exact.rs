//! Rays against boxes in `f64`.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::DVec3;

use crate::number::Vec3x8;

/// Covers the rounding of both ends of the test (Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013).
const PAD: f64 = 1.0 + 4.0 * f64::EPSILON;

/// The distance of a hit of what lies between two corners, brought between those at which the ray enters and leaves their
/// box. It then agrees, to the bit, with the test of every box around that box: no tree skips what is hit. `None` where the
/// ray passes the box. `inverse` is one over the direction.
#[inline]
pub(crate) fn within_box(o: DVec3, inverse: DVec3, low: DVec3, high: DVec3, t: f64) -> Option<f64> {
    let (near, far) = slabs(o, inverse, low, high, f64::INFINITY);
    (near <= far).then(|| t.clamp(near, far))
}

/// Where a ray enters and leaves a box.
///
/// Near and far are told by the sign of the direction, before anything is compared; then a NaN, which a ray in the
/// plane of a side gives, drops out, because it compares as false.
#[inline(always)]
pub(in crate::bvh) fn slabs(o: DVec3, inverse: DVec3, low: DVec3, high: DVec3, t_max: f64) -> (f64, f64) {
    let (mut near, mut far) = (0.0_f64, t_max);
    for axis in 0..3 {
        let is_negative = inverse[axis].is_sign_negative();
        let (first, last) = if is_negative { (high[axis], low[axis]) } else { (low[axis], high[axis]) };
        let (enter, leave) = ((first - o[axis]) * inverse[axis], (last - o[axis]) * inverse[axis] * PAD);
        near = if enter > near { enter } else { near };
        far = if leave < far { leave } else { far };
    }
    (near, far)
}

/// Eight rays.
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

    /// Where they enter and leave the box between two corners; as [`slabs`], to the bit.
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
