//! All rays of some packets at once against boxes.

use fearless_simd::{Simd, f32x8, f64x8, mask32x8, prelude::*};

use super::lanes::conservative;
use crate::bvh::{Node, WIDTH};
use crate::lanes::{Vec3x8, splat_f32, to_f32};
use crate::triangle::block::Block;

/// [`super::Slabs`] of rays that run the same way along each axis: boxes are entered where the first ray enters, and left where the
/// last one leaves. Only of boxes behind the origin that is not true, and these are not met.
#[derive(Clone, Copy)]
pub(crate) struct PacketSlabs<S: Simd> {
    /// Along each axis.
    axes: [AxisSlabs<S>; 3],
}

#[derive(Clone, Copy)]
struct AxisSlabs<S: Simd> {
    near_o: f32x8<S>,
    far_o: f32x8<S>,
    near_inverse: f32x8<S>,
    far_inverse: f32x8<S>,
    is_negative: bool,
}

impl<S: Simd> PacketSlabs<S> {
    /// Those of eight rays, in all lanes; `inverse` is one over the directions. `None` of rays that run different ways, or where a
    /// direction is not a number.
    #[inline(always)]
    pub fn new(simd: S, o: Vec3x8<S>, inverse: Vec3x8<S>) -> Option<Self> {
        Some(PacketSlabs {
            axes: [
                AxisSlabs::new(simd, o.x, inverse.x)?,
                AxisSlabs::new(simd, o.y, inverse.y)?,
                AxisSlabs::new(simd, o.z, inverse.z)?,
            ],
        })
    }

    /// Those of the rays of both; `None` if they run different ways.
    #[inline(always)]
    pub fn union(self, other: Self) -> Option<Self> {
        let ([x, y, z], [other_x, other_y, other_z]) = (self.axes, other.axes);
        Some(PacketSlabs { axes: [x.union(other_x)?, y.union(other_y)?, z.union(other_z)?] })
    }

    /// Those of the rays of all lanes, in each lane.
    #[inline(always)]
    pub fn of_all(self, simd: S) -> Self {
        let [x, y, z] = self.axes;
        PacketSlabs { axes: [x.of_all(simd), y.of_all(simd), z.of_all(simd)] }
    }

    /// As [`super::Slabs::meet`].
    #[inline(always)]
    pub fn meet(&self, simd: S, node: &Node, t_max: f32) -> (u32, [f32; WIDTH]) {
        let [x, y, z] = &node.planes;
        let planes = [load(simd, x), load(simd, y), load(simd, z)];
        let (near, is_met) = self.within(simd, planes, t_max);
        (is_met.to_bitmask() as u32, near.to_array())
    }

    /// Which triangles of a block have boxes that any of the rays may meet, as bits.
    #[inline(always)]
    pub fn meet_triangles(&self, simd: S, block: &Block, t_max: f32) -> u32 {
        let [low, high] = block.boxes(simd);
        let [[a, b, c], [d, e, f]] = [low, high];
        let (_, is_met) = self.within(simd, [[a, d], [b, e], [c, f]], t_max);
        is_met.to_bitmask() as u32 & block.all()
    }

    /// Where boxes are entered, and which of them are before a limit.
    #[inline(always)]
    fn within(&self, simd: S, planes: [[f32x8<S>; 2]; 3], t_max: f32) -> (f32x8<S>, mask32x8<S>) {
        let (mut near, mut far) = (splat_f32(simd, 0.0), splat_f32(simd, t_max));
        for (slabs, [low, high]) in self.axes.iter().zip(planes) {
            let (first, last) = if slabs.is_negative { (high, low) } else { (low, high) };
            let enter = (first - slabs.near_o) * slabs.near_inverse;
            let leave = (last - slabs.far_o) * slabs.far_inverse;
            // A NaN, where infinity meets zero, drops out.
            near = enter.max_precise(near);
            far = leave.min_precise(far);
        }
        (near, near.simd_le(far))
    }
}

impl<S: Simd> AxisSlabs<S> {
    #[inline(always)]
    fn new(simd: S, o: f64x8<S>, inverse: f64x8<S>) -> Option<Self> {
        let (o, inverse) = (to_f32(o), to_f32(inverse));
        let negative = inverse.is_sign_negative();
        let is_one_way = negative.all_true() || negative.all_false();
        if !is_one_way || !inverse.simd_eq(inverse).all_true() {
            return None;
        }
        let [near_o, far_o, near_inverse, far_inverse] = conservative(simd, o, inverse);
        Some(AxisSlabs { near_o, far_o, near_inverse, far_inverse, is_negative: negative.all_true() })
    }

    #[inline(always)]
    fn union(self, other: Self) -> Option<Self> {
        if self.is_negative != other.is_negative {
            return None;
        }
        let (a, b) = if self.is_negative { (other.negated(), self.negated()) } else { (self, other) };
        let union = AxisSlabs {
            near_o: a.near_o.max(b.near_o),
            far_o: a.far_o.min(b.far_o),
            near_inverse: a.near_inverse.min(b.near_inverse),
            far_inverse: a.far_inverse.max(b.far_inverse),
            is_negative: false,
        };
        Some(if self.is_negative { union.negated() } else { union })
    }

    #[inline(always)]
    fn of_all(self, simd: S) -> Self {
        let from = if self.is_negative { self.negated() } else { self };
        let union = AxisSlabs {
            near_o: splat_f32(simd, from.near_o.reduce_max()),
            far_o: splat_f32(simd, from.far_o.reduce_min()),
            near_inverse: splat_f32(simd, from.near_inverse.reduce_min()),
            far_inverse: splat_f32(simd, from.far_inverse.reduce_max()),
            is_negative: false,
        };
        if self.is_negative { union.negated() } else { union }
    }

    /// Those of the rays and the axis seen in a mirror.
    #[inline(always)]
    fn negated(self) -> Self {
        AxisSlabs {
            near_o: -self.near_o,
            far_o: -self.far_o,
            near_inverse: -self.near_inverse,
            far_inverse: -self.far_inverse,
            is_negative: !self.is_negative,
        }
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, [low, high]: &[[f32; WIDTH]; 2]) -> [f32x8<S>; 2] {
    [(*low).simd_into(simd), (*high).simd_into(simd)]
}
