//! Traces up to 64 rays through the hierarchy side by side.
//!
//! Each ray has a stack of nodes. In each round every ray takes the top node of its stack and tests its eight boxes, without branches on
//! what is hit: nodes go to the stack, and blocks of triangles to a queue, which is tested after each round. So rays hide each other's
//! cache misses, and hardly any branch is mispredicted. What is no triangle waits on the stack, sorted by distance, because its tests are
//! expensive.

mod deferred;
mod slabs;
#[cfg(test)]
mod tests;

use arrayvec::ArrayVec;
use fearless_simd::{Simd, mask32x8, prelude::*, u32x8};

use super::rays::{Hits, PLACES, Rays, WORLD};
use super::{MOST_PACKETS, Query, TraversalRays, Tree};
use crate::bvh::{Child, Leaf, Node, STACK, WIDTH, not_less, sort_descending};
use crate::number::{LANES, prefetch, splat_f32, to_f32, vectorized};
use crate::ray::{ElementId, Hit};
use crate::traceable::Traceable;
use crate::triangle::{Axis, BlockHits, Filter, Turned, UNIT};
use deferred::DeferredHits;
use slabs::FusedSlabs;

/// The most rays that are traced side by side.
const MOST_RAYS: usize = MOST_PACKETS * LANES;
/// The room of each stack: a power of two, and more than any traversal needs.
const ROOM: usize = 1024;
const _: () = assert!(STACK < ROOM);
/// The most leaves that are queued in a round: all children of one node for each ray.
const QUEUE: usize = MOST_RAYS * WIDTH;

/// The stack of each ray: all eight children of a node are written at once, so there is room for eight more. The stacks are no multiple of
/// 4,096 bytes apart, because caches would map these to the same lines.
const STRIDE: usize = ROOM + WIDTH;

/// A number for each place of each stack.
struct Stacks(Box<[u32; MOST_RAYS * STRIDE]>);

impl Stacks {
    fn new() -> Self {
        // Zeros that are never touched take no memory.
        let zeros = vec![0; MOST_RAYS * STRIDE].into_boxed_slice();
        Stacks(zeros.try_into().unwrap_or_else(|_| unreachable!("the length is that of the array")))
    }

    #[inline(always)]
    fn of(&mut self, ray: usize) -> &mut [u32; STRIDE] {
        &mut self.0.as_chunks_mut::<STRIDE>().0[ray % MOST_RAYS]
    }
}

/// Rays on their way through the hierarchy of a world, and room to trace them.
pub(crate) struct WideTracer {
    slabs: FusedSlabs,
    /// See [`Turned`]: the shear, the offset, the start and the direction.
    turned: [[f32; MOST_RAYS]; 6],
    /// See [`Filter::error`].
    error: [f32; MOST_RAYS],
    /// The index of each order of axes in [`Axis::ORDERS`].
    order: [u8; MOST_RAYS],
    /// The distance beyond which hits do not count, or a little more.
    limit: [f32; MOST_RAYS],
    /// The triangles of the world that rays leave, or [`Hit::NO_PLACE`].
    leaving: [u32; MOST_RAYS],
    hits: DeferredHits,
    /// The number of children that wait on each stack.
    waiting: [u32; MOST_RAYS],
    /// The children that wait.
    stacks: Stacks,
    /// The bits of the distances where rays enter the leaves that wait.
    entries: Stacks,
    /// The rays that have not ended.
    live: [u8; MOST_RAYS],
    /// The leaves that are tested after this round, and their rays.
    leaves: [u32; QUEUE + WIDTH],
    leaf_rays: [u32; QUEUE + WIDTH],
    queued: usize,
}

/// The rays that a [`WideTracer`] traces, in packets.
#[derive(Clone, Copy)]
struct Traced<'t, S: Simd> {
    simd: S,
    scene: &'t Traceable,
    packets: &'t [&'t Rays<S>],
    /// True for shadow rays, which may pass other holes.
    is_shadow: bool,
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
            waiting: [0; MOST_RAYS],
            stacks: Stacks::new(),
            entries: Stacks::new(),
            live: [0; MOST_RAYS],
            leaves: [0; QUEUE + WIDTH],
            leaf_rays: [0; QUEUE + WIDTH],
            queued: 0,
        }
    }

    /// Finds the nearest hits of active rays; each bit of `active` is a ray. Replaces `hits`. Returns the active rays that are not traced,
    /// because they are out of the range of `f32`.
    #[inline(never)]
    pub fn nearest<S: Simd>(
        &mut self,
        simd: S,
        scene: &Traceable,
        packets: &[&Rays<S>],
        active: u64,
        hits: &mut [Hits<S>],
    ) -> u64 {
        vectorized!(simd, {
            let (_, rest) =
                self.trace::<S, false>(&Traced { simd, scene, packets, is_shadow: false }, active);
            self.hits.finish(simd, scene, packets);
            self.hits.write(simd, scene, hits);
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
        packets: &[&Rays<S>],
        active: u64,
        is_shadow: bool,
    ) -> (u64, u64) {
        vectorized!(simd, self.trace::<S, true>(&Traced { simd, scene, packets, is_shadow }, active))
    }

    /// Traces active rays. Returns those that hit anything, if `ANY` hit will do, and those that are not traced.
    #[inline(always)]
    fn trace<S: Simd, const ANY: bool>(&mut self, traced: &Traced<S>, active: u64) -> (u64, u64) {
        let Traced { simd, scene, .. } = *traced;
        let (nodes, mut met) = (&scene.world.bvh.nodes[..], 0);
        self.hits.clear();
        let started = self.start(traced, active);
        let mut count = 0;
        let mut rest = started;
        while rest != 0 {
            self.live[count % MOST_RAYS] = rest.trailing_zeros() as u8;
            rest &= rest - 1;
            count += 1;
        }
        if scene.world.bvh.root == Child::EMPTY {
            count = 0;
        }
        while count > 0 {
            let mut left = 0;
            for at in 0..count {
                let ray = usize::from(self.live[at % MOST_RAYS]) % MOST_RAYS;
                let waiting = self.step::<S, ANY>(simd, nodes, ray);
                self.live[left % MOST_RAYS] = ray as u8;
                left += usize::from(waiting > 0);
            }
            count = left;
            met |= self.test_leaves::<S, ANY>(traced, met);
            if ANY && met != 0 {
                let mut left = 0;
                for at in 0..count {
                    let ray = self.live[at % MOST_RAYS];
                    self.live[left % MOST_RAYS] = ray;
                    left += usize::from(met >> (ray % MOST_RAYS as u8) & 1 == 0);
                }
                count = left;
            }
        }
        (met, active & !started)
    }

    /// Puts the active rays at the root. Returns those that are in the range of `f32`.
    #[inline(always)]
    fn start<S: Simd>(&mut self, traced: &Traced<S>, active: u64) -> u64 {
        let Traced { simd, scene, packets, .. } = *traced;
        let bounds = &scene.world.bvh.bounds;
        let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
        let mut started = 0;
        for (packet, rays) in packets.iter().enumerate() {
            let first = packet % MOST_PACKETS * LANES;
            if active >> first & 0xff == 0 {
                continue;
            }
            let own = first..first + LANES;
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
            let in_world = rays.leaving_instance.simd_eq(WORLD);
            let leaves_triangle = rays.leaving.simd_ge(0.0) & rays.leaving.simd_lt(PLACES) & in_world;
            let leaves_triangle = leaves_triangle.to_bitmask();
            for lane in 0..LANES {
                let ray = first + lane;
                self.order[ray] = traversal.order(lane) as u8;
                let leaving = rays.leaving[lane] as u32;
                self.leaving[ray] = if leaves_triangle >> lane & 1 == 1 { leaving } else { Hit::NO_PLACE };
                self.waiting[ray] = 1;
                self.stacks.of(ray)[0] = scene.world.bvh.root.0;
                self.entries.of(ray)[0] = 0;
            }
            let in_range = traversal.magnitude.simd_lt(f32::INFINITY).to_bitmask();
            started |= (active >> first & in_range & 0xff) << first;
        }
        started
    }

    /// Takes the top of the stack of a ray. Of a node, the children that are hit replace it, the nearest on top, or in any order if `ANY`
    /// hit will do; blocks are queued. Returns the number of children that wait then.
    #[inline(always)]
    fn step<S: Simd, const ANY: bool>(&mut self, simd: S, nodes: &[Node], ray: usize) -> u32 {
        let top = (self.waiting[ray] as usize).wrapping_sub(1) % ROOM;
        let stack = self.stacks.of(ray);
        let child = Child(stack[top]);
        let queued = self.queued % QUEUE;
        if child.0 >= Child::LEAF {
            let is_near = ANY || f32::from_bits(self.entries.of(ray)[top]) <= self.limit[ray];
            (self.leaves[queued], self.leaf_rays[queued]) = (child.0, ray as u32);
            self.queued += usize::from(is_near);
            self.waiting[ray] = top as u32;
            return top as u32;
        }
        let node = &nodes[child.0 as usize];
        let (near, hits) = self.slabs.meet(simd, ray, node, self.limit[ray]);
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
        if !ANY && hits & are_others != 0 {
            return self.push_sorted(node, inner, near.to_array(), (ray, top));
        }
        let waiting = top as u32 + inner.count_ones();
        if ANY || inner & inner.wrapping_sub(1) == 0 {
            simd.compress_u32x8(children, of(inner)).store_slice(&mut stack[top..top + WIDTH]);
        } else {
            let own = of(inner).select(near, splat_f32(simd, f32::INFINITY));
            let nearest = own.simd_eq(own.reduce_min()).to_bitmask() as u32 & inner;
            let nearest = nearest.trailing_zeros() as usize % WIDTH;
            let rest = inner & !(1 << nearest);
            simd.compress_u32x8(children, of(rest)).store_slice(&mut stack[top..top + WIDTH]);
            stack[top + rest.count_ones() as usize % WIDTH] = node.children[nearest].0;
        }
        self.waiting[ray] = waiting;
        let next = Child(stack[(waiting as usize).wrapping_sub(1) % ROOM]);
        prefetch(nodes.as_ptr().wrapping_add(next.number()), 0..4);
        waiting
    }

    /// Puts children that are hit on a stack, the nearest on top. Returns the number of children that wait then.
    #[inline(never)]
    fn push_sorted(
        &mut self,
        node: &Node,
        mut hits: u32,
        near: [f32; WIDTH],
        (ray, top): (usize, usize),
    ) -> u32 {
        let mut keys = ArrayVec::<u64, WIDTH>::new();
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize % WIDTH;
            hits &= hits - 1;
            keys.push(u64::from(near[lane].to_bits()) << 32 | u64::from(node.children[lane].0));
        }
        sort_descending(&mut keys);
        let (stack, entries) = (self.stacks.of(ray), self.entries.of(ray));
        for (at, key) in keys.iter().enumerate() {
            (stack[top + at], entries[top + at]) = (*key as u32, (key >> 32) as u32);
        }
        self.waiting[ray] = (top + keys.len()) as u32;
        self.waiting[ray]
    }

    /// Tests the leaves that are queued. Returns the rays that hit anything, if `ANY` hit will do; those in `met` need no test.
    #[inline(always)]
    fn test_leaves<S: Simd, const ANY: bool>(&mut self, traced: &Traced<S>, mut met: u64) -> u64 {
        let world = &traced.scene.world;
        let count = self.queued.min(QUEUE);
        self.queued = 0;
        // All at once, before the first is tested.
        for leaf in &self.leaves[..count] {
            prefetch(world.blocks.as_ptr().wrapping_add(Child(*leaf).number()), 0..5);
        }
        for at in 0..count {
            let (leaf, ray) =
                (Child(self.leaves[at % QUEUE]), self.leaf_rays[at % QUEUE] as usize % MOST_RAYS);
            if ANY && met >> ray & 1 == 1 {
                continue;
            }
            let is_met = match leaf.as_leaf() {
                Leaf::Block(block) => self.test_block::<S, ANY>(traced, ray, block),
                Leaf::NonTriangle(other) => self.test_non_triangle::<S, ANY>(traced, ray, other),
            };
            met |= u64::from(ANY && is_met) << ray;
        }
        met
    }

    /// Tests a ray against a block of triangles. True if it hits one, if `ANY` hit will do.
    #[inline(always)]
    fn test_block<S: Simd, const ANY: bool>(
        &mut self,
        traced: &Traced<S>,
        ray: usize,
        number: usize,
    ) -> bool {
        let Traced { simd, scene, packets, .. } = *traced;
        let block = &scene.world.blocks[number];
        let own = |at: usize| splat_f32(simd, self.turned[at][ray]);
        let turned =
            Turned { shear: [own(0), own(1)], offset: [own(2), own(3)], start: own(4), along: own(5) };
        let axes = Axis::ORDERS[usize::from(self.order[ray]) % 3];
        let filter = Filter { axes, rays: turned, error: self.error[ray] };
        let length = self.turned[5][ray].abs();
        let end = self.limit[ray] * length;
        let left_out = block.bit_of(self.leaving[ray]);
        let Some(hits) = filter.meet::<false>(simd, block, end, left_out) else { return false };
        let certain = hits.certain & block.solid;
        let mut rest = hits.may;
        if ANY {
            // The target of a shadow ray never is wholly before its end.
            if hits.certain_before(end) & block.solid != 0 {
                return true;
            }
            let target = packets[ray / LANES].target[ray % LANES];
            let is_target = |lane: u32| {
                let element = scene.world.triangle(block.place(lane)).element(ElementId::WORLD);
                scene.labels.of(element) == target
            };
            rest = lanes_of(rest).filter(|lane| !is_target(*lane)).fold(0, |rest, lane| rest | 1 << lane);
        } else if certain != 0 {
            rest &= !certain | self.defer(scene, ray, (block.place(0), certain), &hits);
        }
        rest != 0 && self.decide_triangles::<S, ANY>(traced, ray, (block.place(0), rest))
    }

    /// Defers triangles of a block that a ray certainly hits. `certain`: the place of the first triangle of the block, and the bits of these
    /// triangles. Returns the bits of those that must be decided now.
    #[inline(always)]
    fn defer<S: Simd>(
        &mut self,
        scene: &Traceable,
        ray: usize,
        (first, certain): (u32, u32),
        hits: &BlockHits<S>,
    ) -> u32 {
        let [front, back] = hits.depths;
        let mut rest = 0;
        for lane in lanes_of(certain) {
            let at = lane as usize % WIDTH;
            let depths = [front[at] - hits.error, back[at] + hits.error];
            if self.hits.replaces(ray, depths) {
                self.hits.defer(scene, ray, first + lane, depths);
                let farthest = depths[1] * (1.0 + 12.0 * UNIT) / self.turned[5][ray].abs();
                self.limit[ray] = self.limit[ray].min(farthest);
            } else if !self.hits.is_beyond(ray, depths) {
                rest |= 1 << lane;
            }
        }
        rest
    }

    /// Decides about triangles of a block in `f64`. `may`: the place of the first triangle of the block, and the bits of these triangles.
    /// True if the ray hits one.
    #[inline(never)]
    fn decide_triangles<S: Simd, const ANY: bool>(
        &mut self,
        traced: &Traced<S>,
        ray: usize,
        (first, may): (u32, u32),
    ) -> bool {
        let Traced { scene, packets, is_shadow, .. } = *traced;
        let own = Tree { scene }.ray(packets[ray / LANES], ray % LANES);
        let query = Query::new(&scene.world, &own, ElementId::WORLD, is_shadow);
        let mut hit = self.hits.nearest(ray, &own);
        let (mut found, mut sheared) = (false, None);
        for lane in lanes_of(may) {
            found |= scene.meet_triangle::<ANY>(query, first + lane, &mut sheared, &mut hit);
        }
        if found {
            self.record::<ANY>(ray, &hit);
        }
        found
    }

    /// Tests a ray against a non-triangle. True if it hits it, nearer than anything else that is decided.
    #[inline(never)]
    fn test_non_triangle<S: Simd, const ANY: bool>(
        &mut self,
        traced: &Traced<S>,
        ray: usize,
        other: usize,
    ) -> bool {
        let Traced { simd, scene, packets, is_shadow } = *traced;
        let own = Tree { scene }.ray(packets[ray / LANES], ray % LANES);
        let query = Query::new(&scene.world, &own, ElementId::WORLD, is_shadow);
        let mut hit = self.hits.nearest(ray, &own);
        let found =
            scene.meet_non_triangle::<S, ANY>(simd, query, scene.world.non_triangles[other], &mut hit);
        if found {
            self.record::<ANY>(ray, &hit);
        }
        found
    }

    /// Records the nearest hit that is decided.
    #[inline(always)]
    fn record<const ANY: bool>(&mut self, ray: usize, hit: &Hit) {
        if !ANY {
            self.hits.decide(ray, hit);
            self.limit[ray] = self.limit[ray].min(not_less(hit.t));
        }
    }
}

/// The bits that are set.
#[inline(always)]
fn lanes_of(mut bits: u32) -> impl Iterator<Item = u32> {
    std::iter::from_fn(
        #[inline(always)]
        move || {
            let lane = (bits != 0).then(|| bits.trailing_zeros())?;
            bits &= bits - 1;
            Some(lane)
        },
    )
}
