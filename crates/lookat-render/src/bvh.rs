//! A bounding volume hierarchy with eight children per node, and the slab tests of its boxes: in `f32`, conservative, and in `f64`,
//! exact.

mod build;
#[cfg(test)]
mod tests;

use arrayvec::ArrayVec;
use fearless_simd::{Simd, f32x8, f64x8, mask32x8, mask64x8, prelude::*};
use glam::DVec3;

use crate::frame::Bounds;
use crate::number::prefetch;
use crate::number::{Vec3x8, splat_f32, three};
pub(crate) use build::{Reference, around, build};

/// Children of a node, and triangles of a block: what one instruction computes.
pub(crate) const WIDTH: usize = 8;

/// Boxes of up to eight children, plane by plane, so that one instruction tests all.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Node {
    /// The planes of least and of greatest x, of y and of z.
    pub planes: [[[f32; WIDTH]; 2]; 3],
    pub children: [Child; WIDTH],
}

/// An inner node, a leaf or nothing, as one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Child(pub u32);

/// The contents of a leaf.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Leaf {
    /// The number of a block of triangles.
    Block(usize),
    /// The number of a non-triangle.
    NonTriangle(usize),
}

impl Child {
    /// This bit marks a leaf.
    pub const LEAF: u32 = 1 << 31;
    /// This bit marks a leaf that is a non-triangle.
    pub const OTHER: u32 = 1 << 30;
    pub const EMPTY: Child = Child(u32::MAX);
    /// Fewer elements than that can be numbered, and in as many blocks the places of triangles (`triangle::block::place`).
    const MOST: usize = u32::MAX as usize / WIDTH;

    fn inner(node: usize) -> Self {
        Child(node as u32)
    }

    fn leaf(leaf: Leaf) -> Self {
        match leaf {
            Leaf::Block(number) => Child(number as u32 | Child::LEAF),
            Leaf::NonTriangle(number) => Child(number as u32 | Child::LEAF | Child::OTHER),
        }
    }

    #[inline(always)]
    fn as_inner(self) -> Option<usize> {
        (self.0 & Child::LEAF == 0).then_some(self.0 as usize)
    }

    /// The number of a node, a block or a non-triangle.
    #[inline(always)]
    pub fn number(self) -> usize {
        (self.0 & (Child::OTHER - 1)) as usize
    }

    #[inline(always)]
    pub fn as_leaf(self) -> Leaf {
        let number = self.number();
        if self.0 & Child::OTHER == 0 { Leaf::Block(number) } else { Leaf::NonTriangle(number) }
    }
}

/// A tree of boxes over elements that the owner keeps.
#[derive(Debug)]
pub(crate) struct Bvh {
    pub nodes: Vec<Node>,
    pub root: Child,
    pub bounds: Bounds,
}

/// A tree is never deeper than this; see `build`.
const MAX_DEPTH: usize = 88;
/// All children but one of each node on the way down may wait.
pub(crate) const STACK: usize = MAX_DEPTH * (WIDTH - 1) + 1;

impl Bvh {
    /// The number of nodes. 0 if one leaf holds all elements.
    pub fn nodes(&self) -> usize {
        self.nodes.len()
    }

    /// The most nodes on a way from the root to a leaf.
    pub fn depth(&self) -> usize {
        let (mut depth, mut level) = (0, vec![self.root]);
        loop {
            let nodes = level.iter().filter_map(|child| child.as_inner());
            level = nodes.flat_map(|node| self.nodes[node].children).collect();
            if level.is_empty() {
                return depth;
            }
            depth += 1;
        }
    }

    /// Calls `visit` with each leaf that a ray may meet before `t_max`: about from near to far or, where `ANY` hit will do, in
    /// any order. `visit` gives the new limit, or `None` to stop. `boxes` tests the children of a node: which may be met
    /// before a limit, as bits, and from which distance on, not negative. Blocks have an array of their own; blocks that will be
    /// needed a little later are asked for.
    ///
    /// Wald, Benthin and Boulos, "Getting Rid of Packets", 2008.
    #[inline(always)]
    pub fn traverse<const ANY: bool, B>(
        &self,
        blocks: &[B],
        t_max: f64,
        boxes: impl Fn(&Node, f32) -> (u32, [f32; WIDTH]),
        mut visit: impl FnMut(Leaf) -> Option<f64>,
    ) {
        // All but one of the children that are met wait. Without branches: which child is a leaf cannot be foretold.
        let ask = |child: Child| {
            let (number, nodes) = (child.number(), self.nodes.as_ptr());
            let (node, block) = (nodes.wrapping_add(number), blocks.as_ptr().wrapping_add(number));
            prefetch(if child.as_inner().is_some() { node.cast() } else { block.cast::<u8>() }, 0..5);
        };
        let mut limit = not_less(t_max);
        let mut stack = Stack::new();
        let mut at = self.root;
        loop {
            if let Some(inner) = at.as_inner() {
                let node = &self.nodes[inner];
                let (hits, near) = boxes(node, limit);
                if let Some(next) = descend::<ANY>(node, hits, &near, &mut stack, ask) {
                    at = next;
                    continue;
                }
            } else if at != Child::EMPTY {
                match visit(at.as_leaf()) {
                    Some(t_max) => limit = not_less(t_max),
                    None => return,
                }
            }
            let Some(next) = pop(&mut stack, limit) else { return };
            at = next;
        }
    }
}

/// Children that wait, the nearest on top: the distance in the upper half, for distances that are not negative are sorted
/// as their bits are.
type Stack = ArrayVec<u64, STACK>;

/// The nearest of the children that are hit; the others wait, the nearest on top. Where `ANY` hit will do, the farthest, and
/// the others wait in any order: what is around the surface that a ray leaves is seldom in its way.
#[inline(always)]
fn descend<const ANY: bool>(
    node: &Node,
    mut hits: u32,
    near: &[f32; WIDTH],
    stack: &mut Stack,
    waits: impl Fn(Child),
) -> Option<Child> {
    let key = |lane: usize| u64::from(near[lane].to_bits()) << 32 | u64::from(node.children[lane].0);
    let first = next_lane(&mut hits)?;
    // Mostly there are one or two, which need no sorting.
    let Some(second) = next_lane(&mut hits) else { return Some(node.children[first]) };
    let bottom = stack.len();
    let mut best = key(first);
    let mut next = Some(second);
    while let Some(lane) = next {
        let (less, more) = (best.min(key(lane)), best.max(key(lane)));
        let waiting = if ANY { less } else { more };
        best = if ANY { more } else { less };
        waits(Child(waiting as u32));
        stack.push(waiting);
        next = next_lane(&mut hits);
    }
    if !ANY && stack.len() > bottom + 1 {
        sort_descending(&mut stack[bottom..]);
    }
    Some(Child(best as u32))
}

/// The nearest child that waits, if it is not beyond the limit.
#[inline(always)]
fn pop(stack: &mut Stack, limit: f32) -> Option<Child> {
    while let Some(key) = stack.pop() {
        if (key >> 32) as u32 <= limit.to_bits() {
            return Some(Child(key as u32));
        }
    }
    None
}

/// The place of the lowest bit, which is cleared.
#[inline(always)]
fn next_lane(hits: &mut u32) -> Option<usize> {
    let lane = (*hits != 0).then(|| hits.trailing_zeros() as usize % WIDTH);
    *hits &= hits.wrapping_sub(1);
    lane
}

/// A distance in `f32` that is not less.
#[inline(always)]
pub(crate) fn not_less(t: f64) -> f32 {
    t as f32 * (1.0 + f32::EPSILON) + f32::MIN_POSITIVE
}

/// Insertion sort: there are seven at most, mostly one or two.
#[inline(always)]
fn sort_descending(keys: &mut [u64]) {
    for end in 1..keys.len() {
        let key = keys[end];
        let mut at = end;
        while at > 0 && keys[at - 1] < key {
            keys[at] = keys[at - 1];
            at -= 1;
        }
        keys[at] = key;
    }
}

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
    /// Bits of the rays whose directions are negative along each axis.
    negative: [u64; 3],
}

/// Rays prepared for tests against boxes: one ray in all lanes, or many whose directions have the same signs. Many rays
/// enter a box where the first one enters, and leave it where the last one leaves. This fails only for boxes behind the
/// origin, which no ray hits.
#[derive(Clone, Copy)]
pub(crate) struct Slabs<S: Simd> {
    axes: [AxisSlabs<S>; 3],
    /// Along each axis, which of the two planes of a box it is entered at; it is left at the other one.
    near: [usize; 3],
}

/// Covers the rounding of a direction, an inverse, a difference and a product, and more.
const SLACK: f32 = 5.0 * f32::EPSILON;

impl<S: Simd> SlabRays<S> {
    /// Prepares rays whose origins and directions were rounded once to `f32`.
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

    /// All rays, each in its lane. `None` if the signs of the directions differ, or a direction is not a number.
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

    /// Bits of the boxes of a node that the ray may hit before `t_max`, and the distances where it enters them, at least 0.
    #[inline(always)]
    pub fn meet(&self, simd: S, node: &Node, t_max: f32) -> (u32, [f32; WIDTH]) {
        let planes = three!(axis, {
            let (planes, near) = (&node.planes[axis], self.near[axis]);
            [f32x8::from_slice(simd, &planes[near & 1]), f32x8::from_slice(simd, &planes[!near & 1])]
        });
        let (near, is_met) = self.within(simd, planes, t_max);
        (is_met.to_bitmask() as u32, near.to_array())
    }

    /// Bits of the eight boxes that the ray may hit, given their lowest and highest corners.
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

    /// The distances where boxes are entered, and a mask of those before a limit.
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

    /// One of the rays, in all lanes.
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
pub(crate) fn max<S: Simd>(a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
    if cfg!(target_arch = "x86_64") { a.max(b) } else { a.max_precise(b) }
}

/// The less, likewise.
#[inline(always)]
pub(crate) fn min<S: Simd>(a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
    if cfg!(target_arch = "x86_64") { a.min(b) } else { a.min_precise(b) }
}

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

/// The distances where a ray enters and leaves a box.
///
/// Near and far are told by the sign of the direction, before anything is compared; then a NaN, which a ray in the
/// plane of a side gives, drops out, because it compares as false.
#[inline(always)]
fn slabs(o: DVec3, inverse: DVec3, low: DVec3, high: DVec3, t_max: f64) -> (f64, f64) {
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
    /// The rays whose direction is negative along an axis.
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

    /// The distances where each ray enters and leaves the box between two corners, with the bits of [`slabs`].
    #[inline(always)]
    pub fn ends(&self, simd: S, corners: [Vec3x8<S>; 2]) -> (f64x8<S>, f64x8<S>) {
        let [low, high] = corners.map(|corner| [corner.x, corner.y, corner.z]);
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
