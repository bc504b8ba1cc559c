//! Traces up to 64 rays through the hierarchy side by side.
//!
//! Each ray has a stack of nodes. In each round every ray takes the top node of its stack and tests its eight boxes, without branches on
//! what is hit: nodes go to the stack, and blocks of triangles to a queue, which is tested after each round. So rays hide each other's
//! cache misses, and hardly any branch is mispredicted. What is no triangle waits on the stack; where there is much of it, with its distance, because
//! its tests are expensive.

mod curve_pairs;
mod curved_pairs;
mod deferred;
mod instances;
mod leaves;
mod pairs;
mod slabs;
#[cfg(test)]
mod tests;
mod triangle_pairs;

use arrayvec::ArrayVec;
use fearless_simd::{Simd, mask32x8, prelude::*, u32x8};

use super::TraversalRays;
use super::rays::{HitColumns, PLACES, RayColumns};
use crate::bvh::{Child, STACK, WIDTH};
use crate::columns::MOST as MOST_RAYS;
use crate::number::{LANES, eights, prefetch, splat_f32, to_f32, vectorized};
use crate::ray::{ElementId, Hit, Ray};
use crate::traceable::{Group, Traceable};
use crate::triangle::{Turned, UNIT};
use curve_pairs::CurvePairs;
use curved_pairs::{CurvedPairs, NO_PAIRS};
use deferred::DeferredHits;
use instances::AtInstance;
use pairs::Pairs;
use slabs::{FusedSlabs, PAD};
use triangle_pairs::TrianglePairs;

/// The room of each stack: a power of two, and more than any traversal needs.
const ROOM: usize = 1024;
const _: () = assert!(STACK < ROOM);
/// The most leaves that are queued in a round: all children of one node for each ray.
const QUEUE: usize = MOST_RAYS * WIDTH;

/// The stack of each ray: all eight children of a node are written at once, so there is room for eight more. The stacks are no multiple of
/// 4,096 bytes apart, because caches would map these to the same lines.
const STRIDE: usize = ROOM + WIDTH;

/// A number for each place of each stack.
struct Stacks<T>(Box<[T; MOST_RAYS * STRIDE]>);

impl<T: Copy> Stacks<T> {
    fn new(zero: T) -> Self {
        // Zeros that are never touched take no memory.
        let zeros = vec![zero; MOST_RAYS * STRIDE].into_boxed_slice();
        Stacks(zeros.try_into().unwrap_or_else(|_| unreachable!("the length is that of the array")))
    }

    #[inline(always)]
    fn of(&mut self, ray: usize) -> &mut [T; STRIDE] {
        &mut self.0.as_chunks_mut::<STRIDE>().0[ray % MOST_RAYS]
    }
}

/// Rays on their way through the hierarchy of a world, and room to trace them.
pub(crate) struct WideTracer {
    slabs: FusedSlabs,
    /// See [`Turned`]: the shear, the offset, the start and the direction.
    turned: [[f32; MOST_RAYS]; 6],
    /// See [`crate::triangle::Filter::error`].
    error: [f32; MOST_RAYS],
    /// The index of each order of axes in [`crate::triangle::Axis::ORDERS`].
    order: [u8; MOST_RAYS],
    /// The distance beyond which hits do not count, or a little more.
    limit: [f32; MOST_RAYS],
    /// The triangles of the world that rays leave, or [`Hit::NO_PLACE`].
    leaving: [u32; MOST_RAYS],
    hits: DeferredHits,
    /// The rays that were needed one by one.
    singles: [Ray; MOST_RAYS],
    has_single: u64,
    /// The number of children that wait on each stack.
    waiting: [u32; MOST_RAYS],
    /// The children that wait.
    stacks: Stacks<u32>,
    /// The distances where rays enter the children that wait, if these are culled.
    entries: Stacks<f32>,
    /// The rays that have not ended.
    live: [u8; MOST_RAYS],
    /// The leaves that are tested after this round, and their rays.
    leaves: [u32; QUEUE + WIDTH],
    leaf_rays: [u32; QUEUE + WIDTH],
    queued: usize,
    curved_pairs: CurvedPairs,
    curve_pairs: CurvePairs,
    /// With triangles that may have holes.
    cut_out_pairs: TrianglePairs,
    /// The rays that wait at an instance, and those instances.
    at_instances: ArrayVec<AtInstance, MOST_RAYS>,
    /// For the elements of instances. `None` before the first one.
    inner: Option<Box<(WideTracer, RayColumns)>>,
}

/// The rays that a [`WideTracer`] traces.
#[derive(Clone, Copy)]
struct Traced<'t, S: Simd> {
    simd: S,
    scene: &'t Traceable,
    /// The world or an object.
    group: &'t Group,
    /// The rays, in the space of the group.
    rays: &'t RayColumns,
    /// The instance that each ray is in, or [`ElementId::WORLD`].
    instances: &'t [u32; MOST_RAYS],
    /// True for shadow rays, which may pass other holes.
    is_shadow: bool,
}

const IN_WORLD: [u32; MOST_RAYS] = [ElementId::WORLD; MOST_RAYS];

impl<'t, S: Simd> Traced<'t, S> {
    fn in_world(simd: S, scene: &'t Traceable, rays: &'t RayColumns, is_shadow: bool) -> Self {
        Traced { simd, scene, group: &scene.world, rays, instances: &IN_WORLD, is_shadow }
    }
}

impl WideTracer {
    pub fn new() -> Self {
        WideTracer {
            slabs: FusedSlabs::new(),
            turned: [[0.0; MOST_RAYS]; 6],
            error: [0.0; MOST_RAYS],
            order: [0; MOST_RAYS],
            limit: [0.0; MOST_RAYS],
            leaving: [0; MOST_RAYS],
            hits: DeferredHits::new(),
            singles: [Ray::new(Default::default(), Default::default()); MOST_RAYS],
            has_single: 0,
            waiting: [0; MOST_RAYS],
            stacks: Stacks::new(0),
            entries: Stacks::new(0.0),
            live: [0; MOST_RAYS],
            leaves: [0; QUEUE + WIDTH],
            leaf_rays: [0; QUEUE + WIDTH],
            queued: 0,
            curved_pairs: NO_PAIRS,
            curve_pairs: CurvePairs::NONE,
            cut_out_pairs: Pairs::none(0),
            at_instances: ArrayVec::new(),
            inner: None,
        }
    }

    /// Finds the nearest hits of active rays; each bit of `active` is a ray. `hits`: none at first.
    /// Returns the active rays that are not traced, because they are out of the range of `f32`.
    #[inline(never)]
    pub fn nearest<S: Simd>(
        &mut self,
        simd: S,
        scene: &Traceable,
        rays: &RayColumns,
        active: u64,
        hits: &mut HitColumns,
    ) -> u64 {
        vectorized!(simd, {
            let traced = &Traced::in_world(simd, scene, rays, false);
            let (_, rest) = self.trace_group::<S, false>(traced, active);
            self.hits.write(scene, hits);
            rest
        })
    }

    /// Finds the active rays that hit anything but their targets. Returns them, and the active rays that are not traced, because they are
    /// out of the range of `f32`. `is_shadow`: these are shadow rays, which may pass other holes.
    #[inline(never)]
    pub fn occluded<S: Simd>(
        &mut self,
        simd: S,
        scene: &Traceable,
        rays: &RayColumns,
        active: u64,
        is_shadow: bool,
    ) -> (u64, u64) {
        self.trace_group::<S, true>(&Traced::in_world(simd, scene, rays, is_shadow), active)
    }

    /// Traces active rays in a group. Returns those that hit anything, if `ANY` hit will do, and those that are not traced.
    #[inline(never)]
    fn trace_group<S: Simd, const ANY: bool>(&mut self, traced: &Traced<S>, active: u64) -> (u64, u64) {
        vectorized!(traced.simd, {
            let result = self.trace::<S, ANY>(traced, active);
            if !ANY {
                self.hits.finish(traced);
            }
            result
        })
    }

    /// Does what [`WideTracer::trace_group`] does, but leaves hits deferred.
    #[inline(always)]
    fn trace<S: Simd, const ANY: bool>(&mut self, traced: &Traced<S>, active: u64) -> (u64, u64) {
        let Traced { simd, group, .. } = *traced;
        // Distances pay where many leaves are expensive.
        let culls = 4 * group.non_triangles.len() > group.blocks.len();
        self.hits.clear();
        self.has_single = 0;
        let started = self.start(traced, active);
        let (mut met, mut ready) = (0, if group.bvh.root == Child::EMPTY { 0 } else { started });
        while ready != 0 {
            let mut count = 0;
            while ready != 0 {
                self.live[count % MOST_RAYS] = ready.trailing_zeros() as u8;
                ready &= ready - 1;
                count += 1;
            }
            let mut waiting_at_instances = 0;
            while count > 0 {
                let mut left = 0;
                for at in 0..count {
                    let ray = usize::from(self.live[at % MOST_RAYS]) % MOST_RAYS;
                    let waiting = self.step::<S, ANY>(simd, group, ray, culls);
                    self.live[left % MOST_RAYS] = ray as u8;
                    left += usize::from(waiting > 0);
                }
                count = left;
                let (own, at_instances) = self.test_leaves::<S, ANY>(traced, met);
                met |= own;
                waiting_at_instances |= at_instances;
                let gone = met | waiting_at_instances;
                if gone != 0 {
                    let mut left = 0;
                    for at in 0..count {
                        let ray = self.live[at % MOST_RAYS];
                        self.live[left % MOST_RAYS] = ray;
                        left += usize::from(gone >> (ray % MOST_RAYS as u8) & 1 == 0);
                    }
                    count = left;
                }
            }
            if waiting_at_instances != 0 {
                met |= self.trace_in_instances::<S, ANY>(traced, met);
                let has_more = |ray: usize| self.waiting[ray] > 0;
                ready = (0..MOST_RAYS).fold(0, |ready, ray| ready | u64::from(has_more(ray)) << ray);
                ready &= waiting_at_instances & !met;
            }
        }
        (met, active & !started)
    }

    /// Puts the active rays at the root. Returns those that are in the range of `f32`.
    #[inline(always)]
    fn start<S: Simd>(&mut self, traced: &Traced<S>, active: u64) -> u64 {
        let Traced { simd, group, rays, instances, .. } = *traced;
        let bounds = &group.bvh.bounds;
        let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
        let mut started = 0;
        for (first, active) in eights(active) {
            let (own, rays) = (first..first + LANES, rays.eight(simd, first));
            let traversal = TraversalRays::new(simd, rays.o, rays.d);
            let o = [to_f32(rays.o.x), to_f32(rays.o.y), to_f32(rays.o.z)];
            let d = [to_f32(rays.d.x), to_f32(rays.d.y), to_f32(rays.d.z)];
            self.slabs.set(first, o, d, traversal.magnitude + reach);
            let Turned { shear, offset, start, along } = traversal.turned;
            let turned = [shear[0], shear[1], offset[0], offset[1], start, along];
            for (own_turned, x) in self.turned.iter_mut().zip(turned) {
                x.store_slice(&mut own_turned[own.clone()]);
            }
            (traversal.magnitude * (12.0 * UNIT)).store_slice(&mut self.error[own.clone()]);
            // As `not_less`.
            let limit = to_f32(rays.t_max) * (1.0 + f32::EPSILON) + f32::MIN_POSITIVE;
            limit.store_slice(&mut self.limit[own.clone()]);
            let leaves_triangle = rays.leaving.simd_ge(0.0) & rays.leaving.simd_lt(PLACES);
            let leaves_triangle = leaves_triangle.to_bitmask();
            for lane in 0..LANES {
                let ray = first + lane;
                self.order[ray] = traversal.order(lane) as u8;
                let is_own = rays.leaving_instance[lane] == instances[ray];
                let leaves_own = is_own && leaves_triangle >> lane & 1 == 1;
                self.leaving[ray] = if leaves_own { rays.leaving[lane] as u32 } else { Hit::NO_PLACE };
                self.waiting[ray] = 1;
                self.stacks.of(ray)[0] = group.bvh.root.0;
                self.entries.of(ray)[0] = 0.0;
            }
            let in_range = traversal.magnitude.simd_lt(f32::INFINITY).to_bitmask();
            started |= (active & in_range) << first;
        }
        started
    }

    /// Takes the top of the stack of a ray. Of a node, the children that are hit replace it, the nearest on top, or in any order if `ANY`
    /// hit will do; blocks are queued. Returns the number of children that wait then. `culls`: children
    /// that wait are dropped once they are beyond the limit.
    #[inline(always)]
    fn step<S: Simd, const ANY: bool>(&mut self, simd: S, group: &Group, ray: usize, culls: bool) -> u32 {
        let mut top = (self.waiting[ray] as usize).wrapping_sub(1) % ROOM;
        let (stack, entries, limit) = (self.stacks.of(ray), self.entries.of(ray), self.limit[ray]);
        let farthest = limit * PAD;
        if culls && !ANY {
            while top > 0 && entries[top] > farthest {
                top -= 1;
            }
        }
        let child = Child(stack[top]);
        let queued = self.queued % QUEUE;
        if child.0 >= Child::LEAF {
            let is_near = ANY || !culls || entries[top] <= farthest;
            (self.leaves[queued], self.leaf_rays[queued]) = (child.0, ray as u32);
            self.queued += usize::from(is_near);
            self.waiting[ray] = top as u32;
            ask(group, stack[top.wrapping_sub(1) % ROOM]);
            return top as u32;
        }
        let node = &group.bvh.nodes[child.0 as usize];
        let (near, hits) = self.slabs.meet(simd, ray, node, limit);
        let [a, b, c, d, e, f, g, h] = &node.children;
        let children: u32x8<S> = [a.0, b.0, c.0, d.0, e.0, f.0, g.0, h.0].simd_into(simd);
        let are_leaves = children.simd_ge(u32x8::splat(simd, Child::LEAF)).to_bitmask() as u32;
        let are_others = children.simd_ge(u32x8::splat(simd, Child::LEAF | Child::OTHER)).to_bitmask() as u32;
        let of = |bits: u32| mask32x8::from_bitmask(simd, u64::from(bits));
        let blocks = hits & are_leaves & !are_others;
        let inner = hits & !blocks;
        simd.compress_u32x8(children, of(blocks)).store_slice(&mut self.leaves[queued..queued + WIDTH]);
        u32x8::splat(simd, ray as u32).store_slice(&mut self.leaf_rays[queued..queued + WIDTH]);
        self.queued += blocks.count_ones() as usize;
        let waiting = top as u32 + inner.count_ones();
        let (mut rest, mut nearest) = (inner, None);
        if !ANY && inner & inner.wrapping_sub(1) != 0 {
            let own = of(inner).select(near, splat_f32(simd, f32::INFINITY));
            let lanes = own.simd_eq(own.reduce_min()).to_bitmask() as u32 & inner;
            let lane = lanes.trailing_zeros() as usize % WIDTH;
            rest = inner & !(1 << lane);
            nearest = Some((lane, top + rest.count_ones() as usize % WIDTH));
        }
        simd.compress_u32x8(children, of(rest)).store_slice(&mut stack[top..top + WIDTH]);
        if culls && !ANY {
            simd.compress_f32x8(near, of(rest)).store_slice(&mut entries[top..top + WIDTH]);
            let end = top + rest.count_ones() as usize;
            for next in top + 1..end {
                let mut at = next;
                while at > top && entries[at - 1] < entries[at] {
                    stack.swap(at - 1, at);
                    entries.swap(at - 1, at);
                    at -= 1;
                }
            }
        }
        if let Some((lane, at)) = nearest {
            stack[at] = node.children[lane].0;
            if culls {
                entries[at] = near[lane];
            }
        }
        self.waiting[ray] = waiting;
        ask(group, stack[(waiting as usize).wrapping_sub(1) % ROOM]);
        waiting
    }
}

/// Asks for the memory of a child that waits.
#[inline(always)]
fn ask(group: &Group, child: u32) {
    let number = Child(child).number();
    let node = group.bvh.nodes.as_ptr().wrapping_add(number).cast::<u8>();
    let leaf = group.non_triangles.as_ptr().wrapping_add(number).cast();
    prefetch(if child < Child::LEAF { node } else { leaf }, 0..4);
}
