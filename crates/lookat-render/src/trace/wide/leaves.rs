//! Tests of rays against the leaves that they have met: blocks of triangles in `f32` and, where that is not sure, in `f64`; non-triangles one by
//! one.

use fearless_simd::Simd;

use super::curve_pairs::CurvePiece;
use super::curved_pairs::CurvedShape;
use super::{MOST_RAYS, QUEUE, Traced, WideTracer};
use crate::bvh::{Child, Leaf, WIDTH, not_less};
use crate::number::{prefetch, set_bits, splat_f32};
use crate::ray::{ElementId, Hit, Ray};
use crate::trace::{Query, Tree, nothing};
use crate::traceable::{Group, NonTriangle};
use crate::triangle::{Axis, Block, BlockHits, Filter, Turned, UNIT};

impl WideTracer {
    /// Tests the leaves that are queued. Returns the rays that hit anything, if `ANY` hit will do, and the rays that wait at an instance. The
    /// rays in `met` need no test.
    #[inline(always)]
    pub(super) fn test_leaves<S: Simd, const ANY: bool>(
        &mut self,
        traced: &Traced<S>,
        mut met: u64,
    ) -> (u64, u64) {
        let group = traced.group;
        let count = self.queued.min(QUEUE);
        self.queued = 0;
        // All at once, before the first is tested.
        for leaf in &self.leaves[..count] {
            match Child(*leaf).as_leaf() {
                Leaf::Block(block) => prefetch(group.blocks.as_ptr().wrapping_add(block), 0..5),
                Leaf::NonTriangle(other) => traced.scene.prefetch(group.non_triangles[other]),
            }
        }
        let (mut at_instances, any) = (0, if ANY { u64::MAX } else { 0 });
        for at in 0..count {
            let (leaf, ray) =
                (Child(self.leaves[at % QUEUE]), self.leaf_rays[at % QUEUE] as usize % MOST_RAYS);
            if ANY && met >> ray & 1 == 1 {
                continue;
            }
            match leaf.as_leaf() {
                Leaf::Block(block) => {
                    met |= self.test_block::<S, ANY>(traced, ray, block) & any;
                }
                Leaf::NonTriangle(other) => match group.non_triangles[other] {
                    NonTriangle::Curved { primitive, shape } => {
                        met |=
                            self.push_curved::<S, ANY>(traced, ray, CurvedShape { primitive, shape }) & any;
                    }
                    NonTriangle::Curve { primitive, piece } => {
                        met |= self.push_curve::<S, ANY>(traced, ray, CurvePiece { primitive, piece }) & any;
                    }
                    other if self.waits_at(traced, ray, other) => at_instances |= 1 << ray,
                    other => {
                        met |= u64::from(self.test_non_triangle::<S, ANY>(traced, ray, other) && ANY) << ray;
                    }
                },
            }
        }
        if self.cut_out_pairs.len() > 0 {
            met |= self.test_cut_out::<S, ANY>(traced) & any;
        }
        met |= self.test_all_curved::<S, ANY>(traced) & any;
        met |= self.test_all_curves::<S, ANY>(traced) & any;
        (met, at_instances)
    }

    /// Tests a ray against a block of triangles. Returns the rays that hit any: this one, and those that waited for a test of triangles
    /// with holes.
    #[inline(always)]
    fn test_block<S: Simd, const ANY: bool>(&mut self, traced: &Traced<S>, ray: usize, number: usize) -> u64 {
        let Traced { simd, scene, group, rays, instances, .. } = *traced;
        let block = &group.blocks[number];
        let own = |at: usize| splat_f32(simd, self.turned[at][ray]);
        let turned =
            Turned { shear: [own(0), own(1)], offset: [own(2), own(3)], start: own(4), along: own(5) };
        let axes = Axis::ORDERS[usize::from(self.order[ray]) % 3];
        let filter = Filter { axes, rays: turned, error: self.error[ray] };
        let length = self.turned[5][ray].abs();
        let end = self.limit[ray] * length;
        let left_out = block.bit_of(self.leaving[ray]);
        let Some(hits) = filter.meet::<false>(simd, block, end, left_out) else { return 0 };
        let certain = hits.certain & block.solid;
        let mut rest = hits.may;
        if ANY {
            // The target of a shadow ray never is wholly before its end.
            if hits.certain_before(end) & block.solid != 0 {
                return 1 << ray;
            }
            // Nearly always the target is all that is left. It is in the world.
            if instances[ray] == ElementId::WORLD {
                let target = rays.target[ray];
                let element = |lane| group.triangle(block.place(lane)).element(ElementId::WORLD);
                let is_other = |lane: &u32| scene.labels.of(element(*lane)) != target;
                rest = lanes_of(rest).filter(is_other).fold(0, |rest, lane| rest | 1 << lane);
            }
        } else if certain != 0 {
            rest &= !certain | self.defer(group, ray, (block.place(0), certain), &hits);
        }
        if rest == 0 { 0 } else { self.decide_triangles::<S, ANY>(traced, ray, (block, rest)) }
    }

    /// Defers triangles of a block that a ray certainly hits. `certain`: the place of the first triangle of the block, and the bits of these
    /// triangles. Returns the bits of those that must be decided now.
    #[inline(always)]
    fn defer<S: Simd>(
        &mut self,
        group: &Group,
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
                self.hits.defer(group, ray, first + lane, depths);
                let farthest = depths[1] * (1.0 + 12.0 * UNIT) / self.turned[5][ray].abs();
                self.limit[ray] = self.limit[ray].min(farthest);
            } else if !self.hits.is_beyond(ray, depths) {
                rest |= 1 << lane;
            }
        }
        rest
    }

    /// Decides about triangles of a block in `f64`; those that may have holes wait until there are eight. `may`: the bits of the triangles.
    /// Returns the rays that hit any: this one, and those that waited.
    #[inline(never)]
    fn decide_triangles<S: Simd, const ANY: bool>(
        &mut self,
        traced: &Traced<S>,
        ray: usize,
        (block, may): (&Block, u32),
    ) -> u64 {
        let mut met = 0;
        for lane in lanes_of(may & !block.solid) {
            if self.cut_out_pairs.push(ray, block.place(lane)) {
                met |= self.test_cut_out::<S, ANY>(traced);
            }
        }
        let may = may & block.solid;
        if may == 0 {
            return met;
        }
        let found = self.test_exactly::<S, ANY>(traced, ray, |query, hit| {
            let mut sheared = None;
            lanes_of(may).fold(false, |found, lane| {
                found | traced.scene.meet_triangle::<ANY>(query, block.place(lane), &mut sheared, hit)
            })
        });
        met | u64::from(found) << ray
    }

    /// Tests a ray against a non-triangle. True if it hits it, nearer than anything else that is decided.
    #[inline(never)]
    pub(super) fn test_non_triangle<S: Simd, const ANY: bool>(
        &mut self,
        traced: &Traced<S>,
        ray: usize,
        other: NonTriangle,
    ) -> bool {
        self.test_exactly::<S, ANY>(traced, ray, |query, hit| {
            traced.scene.meet_non_triangle::<S, ANY>(traced.simd, query, other, hit)
        })
    }

    /// Runs a test of a single ray, which replaces its nearest hit that is decided if it returns true. Returns that.
    #[inline(always)]
    pub(super) fn test_exactly<S: Simd, const ANY: bool>(
        &mut self,
        traced: &Traced<S>,
        ray: usize,
        test: impl FnOnce(Query, &mut Hit) -> bool,
    ) -> bool {
        let own = self.single(traced, ray);
        let query = Query::new(traced.group, &own, traced.instances[ray], traced.is_shadow);
        let mut hit = self.nearest_of(ray, &own);
        let found = test(query, &mut hit);
        if found {
            self.record::<ANY>(ray, &hit);
        }
        found
    }

    /// Records a hit of a shape that is no triangle if it is nearer than what is decided, and no hole. True if it does.
    pub(super) fn accept<S: Simd, const ANY: bool>(
        &mut self,
        traced: &Traced<S>,
        ray: usize,
        found: Hit,
    ) -> bool {
        self.test_exactly::<S, ANY>(traced, ray, |query, hit| traced.scene.accept::<ANY>(query, found, hit))
    }

    /// The distance of the nearest hit of a ray that is decided, or its end.
    #[inline(always)]
    pub(super) fn end<S: Simd>(&self, traced: &Traced<S>, ray: usize) -> f64 {
        self.hits.nearest(ray).map_or(traced.rays.t_max[ray], |hit| hit.t)
    }

    /// One of the rays.
    #[inline(always)]
    pub(super) fn single<S: Simd>(&mut self, traced: &Traced<S>, ray: usize) -> Ray {
        if self.has_single >> ray & 1 == 0 {
            self.has_single |= 1 << ray;
            let tree = Tree { scene: traced.scene };
            self.singles[ray] = tree.ray(&traced.rays.one(ray));
        }
        self.singles[ray]
    }

    /// The nearest hit of a ray that is decided, or one that any hit replaces.
    #[inline(always)]
    fn nearest_of(&self, ray: usize, own: &Ray) -> Hit {
        self.hits.nearest(ray).copied().unwrap_or_else(|| nothing(own))
    }

    /// Records the nearest hit that is decided.
    #[inline(always)]
    pub(super) fn record<const ANY: bool>(&mut self, ray: usize, hit: &Hit) {
        if !ANY {
            self.hits.decide(ray, hit);
            self.limit[ray] = self.limit[ray].min(not_less(hit.t));
        }
    }
}

/// The lanes whose bits are set.
#[inline(always)]
fn lanes_of(bits: u32) -> impl Iterator<Item = u32> {
    set_bits(u64::from(bits)).map(|lane| lane as u32)
}
