//! Rays in `f32`, as they are tested against boxes and triangles.

use fearless_simd::{Simd, f32x8, prelude::*};

use crate::bvh::{SlabRays, Slabs};
use crate::number::{LANES, Vec3x8, splat_f32, to_f32};
use crate::triangle::Axis;
use crate::triangle::block::MOST_MAGNITUDE;
use crate::triangle::filter::{Filter, Turned};

/// Eight rays.
pub(crate) struct Forms<S: Simd> {
    pub slabs: SlabRays<S>,
    turned: Turned<S>,
    /// The largest coordinate of each origin; infinite where `f32` tells nothing.
    pub magnitude: f32x8<S>,
    /// Where the longest axis of the direction is not x, and where it is not y either, as bits.
    is_not: [u64; 2],
}

impl<S: Simd> Forms<S> {
    #[inline(always)]
    pub fn new(simd: S, o: Vec3x8<S>, d: Vec3x8<S>) -> Self {
        let o = [to_f32(o.x), to_f32(o.y), to_f32(o.z)];
        let d = [to_f32(d.x), to_f32(d.y), to_f32(d.z)];
        let [x, y, z] = [d[0].abs(), d[1].abs(), d[2].abs()];
        let is_not_x = x.simd_lt(y) | x.simd_lt(z);
        let is_not_y = is_not_x & y.simd_lt(z);
        let longest = x.max(y).max(z);
        let magnitude = o[0].abs().max(o[1].abs()).max(o[2].abs());
        let is_safe = longest.simd_gt(1e-30) & longest.simd_lt(1e30) & magnitude.simd_lt(MOST_MAGNITUDE);
        let turned = |[x, y, z]: [f32x8<S>; 3]| {
            let pick = |if_x, if_y, if_z| is_not_y.select(if_z, is_not_x.select(if_y, if_x));
            [pick(y, z, x), pick(z, x, y), pick(x, y, z)]
        };
        Forms {
            slabs: SlabRays::new(simd, o, d),
            turned: Turned::new(turned(o), turned(d)),
            magnitude: is_safe.select(magnitude, splat_f32(simd, f32::INFINITY)),
            is_not: [is_not_x.to_bitmask(), is_not_y.to_bitmask()],
        }
    }

    /// One of them for boxes, and for triangles.
    #[inline(always)]
    pub fn one(&self, simd: S, lane: usize) -> (Slabs<S>, Filter<S>) {
        let filter = Filter::new(self.axes(lane), self.turned.one(simd, lane), self.magnitude[lane]);
        (self.slabs.one(simd, lane), filter)
    }

    /// All of them for triangles, if they are longest along one axis.
    #[inline(always)]
    pub fn all(&self) -> Option<Filter<S>> {
        let are_alike = self.is_not.iter().all(|is_not| [0, (1 << LANES) - 1].contains(is_not));
        are_alike.then(|| Filter::new(self.axes(0), self.turned, self.magnitude.reduce_max()))
    }

    /// The axes, that along which a ray is longest last.
    #[inline(always)]
    fn axes(&self, lane: usize) -> [Axis; 3] {
        Axis::ORDERS[self.is_not.iter().map(|is_not| (is_not >> lane & 1) as usize).sum::<usize>()]
    }
}
