//! Rays against boxes: the test of a box in `f32` is never no where a ray meets what is in it.

pub(super) mod exact;

use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};

use super::{Node, WIDTH};
use crate::number::{splat_f32, three};

/// Rays between two planes, along an axis.
///
/// All is rounded to the side on which boxes are entered earlier or left later, so that the test says yes wherever that in
/// `f64` does.
#[derive(Clone, Copy)]
struct AxisSlabs<S: Simd> {
    /// The origin, for the plane where boxes are entered, and for that where they are left.
    near_o: f32x8<S>,
    far_o: f32x8<S>,
    /// One over the direction, likewise.
    near_inverse: f32x8<S>,
    far_inverse: f32x8<S>,
}

/// Eight rays.
#[derive(Clone, Copy)]
pub(crate) struct SlabRays<S: Simd> {
    axes: [AxisSlabs<S>; 3],
    /// Where directions are negative along each axis, as bits.
    negative: [u64; 3],
}

/// What is tested against boxes: one ray in all lanes, or many that run the same way along each axis. Of many, boxes are entered
/// where the first enters, and left where the last one leaves. Only of boxes behind the origin that is not true, and these are not
/// met.
#[derive(Clone, Copy)]
pub(crate) struct Slabs<S: Simd> {
    axes: [AxisSlabs<S>; 3],
    /// Along each axis, which of the two planes of a box it is entered at; it is left at the other one.
    near: [usize; 3],
}

/// Covers the rounding of a direction, an inverse, a difference and a product, and more.
const SLACK: f32 = 5.0 * f32::EPSILON;

impl<S: Simd> SlabRays<S> {
    /// Of origins and directions that have been rounded once.
    #[inline(always)]
    pub fn new(simd: S, o: [f32x8<S>; 3], d: [f32x8<S>; 3]) -> Self {
        SlabRays {
            axes: three!(axis, AxisSlabs::new(simd, o[axis], 1.0 / d[axis])),
            negative: three!(axis, d[axis].is_sign_negative().to_bitmask()),
        }
    }

    /// One of the rays.
    #[inline(always)]
    pub fn one(&self, simd: S, lane: usize) -> Slabs<S> {
        Slabs {
            axes: three!(axis, self.axes[axis].one(simd, lane)),
            near: three!(axis, (self.negative[axis] >> lane & 1) as usize),
        }
    }

    /// All of them, each in its lane. `None` where they run different ways, or a direction is not a number.
    #[inline(always)]
    pub fn all(&self) -> Option<Slabs<S>> {
        let are_alike = self.negative.iter().all(|negative| [0, (1 << WIDTH) - 1].contains(negative));
        let is_number = |axis: &AxisSlabs<S>| axis.far_inverse.simd_eq(axis.far_inverse).all_true();
        (are_alike && self.axes.iter().all(is_number))
            .then(|| Slabs { axes: self.axes, near: self.negative.map(|negative| (negative & 1) as usize) })
    }
}

impl<S: Simd> Slabs<S> {
    /// The rays of both; `None` if they run different ways.
    #[inline(always)]
    pub fn union(self, other: Self) -> Option<Self> {
        if self.near != other.near {
            return None;
        }
        let axes = three!(axis, self.axes[axis].union(other.axes[axis], self.near[axis] == 1));
        Some(Slabs { axes, near: self.near })
    }

    /// The rays of all lanes, in each lane.
    #[inline(always)]
    pub fn of_all(self, simd: S) -> Self {
        let axes = three!(axis, self.axes[axis].of_all(simd, self.near[axis] == 1));
        Slabs { axes, near: self.near }
    }

    /// Which boxes of a node may be met before `t_max`, as bits, and from which distance on, not negative.
    #[inline(always)]
    pub fn meet(&self, simd: S, node: &Node, t_max: f32) -> (u32, [f32; WIDTH]) {
        let planes = three!(axis, {
            let (planes, near) = (&node.planes[axis], self.near[axis]);
            [f32x8::from_slice(simd, &planes[near & 1]), f32x8::from_slice(simd, &planes[!near & 1])]
        });
        let (near, is_met) = self.within(simd, planes, t_max);
        (is_met.to_bitmask() as u32, near.to_array())
    }

    /// Which of eight boxes may be met, as bits: from their lowest and highest corners.
    #[inline(always)]
    pub fn meet_boxes(&self, simd: S, [low, high]: [[f32x8<S>; 3]; 2], t_max: f32) -> u32 {
        let planes = three!(
            axis,
            match self.near[axis] {
                0 => [low[axis], high[axis]],
                _ => [high[axis], low[axis]],
            }
        );
        self.within(simd, planes, t_max).1.to_bitmask() as u32
    }

    /// Where boxes are entered, and which of them are before a limit.
    #[inline(always)]
    fn within(&self, simd: S, planes: [[f32x8<S>; 2]; 3], t_max: f32) -> (f32x8<S>, mask32x8<S>) {
        let (mut near, mut far) = (splat_f32(simd, 0.0), splat_f32(simd, t_max));
        for (slabs, [first, last]) in self.axes.iter().zip(planes) {
            // A NaN, where infinity meets zero, drops out.
            near = max((first - slabs.near_o) * slabs.near_inverse, near);
            far = min((last - slabs.far_o) * slabs.far_inverse, far);
        }
        (near, near.simd_le(far))
    }
}

impl<S: Simd> AxisSlabs<S> {
    #[inline(always)]
    fn new(simd: S, o: f32x8<S>, inverse: f32x8<S>) -> Self {
        let (least, most) = (splat_f32(simd, f32::MIN_POSITIVE), splat_f32(simd, f32::MAX));
        // More than rounding takes. A box is entered earlier if the origin is moved along the ray.
        let along = (o.abs() * f32::EPSILON + least).copysign(inverse);
        // Too small to be rounded to one part in many.
        let is_tiny = inverse.abs().simd_lt(least);
        let near_inverse = (inverse * (1.0 - SLACK)).max(-most).min(most);
        AxisSlabs {
            near_o: o + along,
            far_o: o - along,
            near_inverse: is_tiny.select(splat_f32(simd, 0.0), near_inverse),
            far_inverse: is_tiny.select(least.copysign(inverse), inverse * (1.0 + SLACK)),
        }
    }

    /// That of one of the rays, in all lanes.
    #[inline(always)]
    fn one(&self, simd: S, lane: usize) -> Self {
        self.map(|x| splat_f32(simd, x[lane]))
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f32x8<S>) -> f32x8<S>) -> Self {
        AxisSlabs {
            near_o: f(self.near_o),
            far_o: f(self.far_o),
            near_inverse: f(self.near_inverse),
            far_inverse: f(self.far_inverse),
        }
    }

    #[inline(always)]
    fn union(self, other: Self, is_negative: bool) -> Self {
        let (a, b) = if is_negative { (other.map(|x| -x), self.map(|x| -x)) } else { (self, other) };
        let union = AxisSlabs {
            near_o: a.near_o.max(b.near_o),
            far_o: a.far_o.min(b.far_o),
            near_inverse: a.near_inverse.min(b.near_inverse),
            far_inverse: a.far_inverse.max(b.far_inverse),
        };
        if is_negative { union.map(|x| -x) } else { union }
    }

    #[inline(always)]
    fn of_all(self, simd: S, is_negative: bool) -> Self {
        let from = if is_negative { self.map(|x| -x) } else { self };
        let union = AxisSlabs {
            near_o: splat_f32(simd, from.near_o.reduce_max()),
            far_o: splat_f32(simd, from.far_o.reduce_min()),
            near_inverse: splat_f32(simd, from.near_inverse.reduce_min()),
            far_inverse: splat_f32(simd, from.far_inverse.reduce_max()),
        };
        if is_negative { union.map(|x| -x) } else { union }
    }
}

/// The greater; `b` where `a` is no number. On x86 `max` gives that, in one instruction.
#[inline(always)]
fn max<S: Simd>(a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
    if cfg!(target_arch = "x86_64") { a.max(b) } else { a.max_precise(b) }
}

/// The less, likewise.
#[inline(always)]
fn min<S: Simd>(a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
    if cfg!(target_arch = "x86_64") { a.min(b) } else { a.min_precise(b) }
}
