//! Packets: eight rays side by side against the triangles of a block.

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};

use super::Tree;
use super::forms::Forms;
use super::rays::{Hits, NONE, Rays, WORLD};
use super::{Query, nothing};
use crate::bvh::{Slabs, WIDTH};
use crate::number::{bits, splat_f32, those, to_f32};
use crate::ray::{ElementId, Hit, Ray};
use crate::traceable::{Other, Traceable};
use crate::triangle::block::{Block, Tolerance};
use crate::triangle::filter::Filter;
use crate::triangle::sheared::{BoxedTriangle, ShearedRays};
use crate::triangle::{Axis, Triangle};

/// Eight rays whose direction is longest along one axis, and their nearest hits so far.
pub(super) struct Packet<S: Simd> {
    rays: ShearedRays<S>,
    /// Leaves out triangles that are not met; `f64` decides about the others.
    pub filter: Filter<S>,
    /// How far along the longest axis the nearest hits are.
    depth: f32x8<S>,
    active: mask64x8<S>,
    pub hits: Hits<S>,
}

impl<S: Simd> Packet<S> {
    /// And how the rays are tested against boxes. `None` of rays that are longest along different axes, that run different ways, or
    /// of which `f32` says nothing.
    #[inline(always)]
    pub fn new(simd: S, rays: &Rays<S>, active: mask64x8<S>) -> Option<(Self, Slabs<S>)> {
        let (sheared, forms) = (ShearedRays::new(rays.o, rays.d, active), Forms::new(simd, rays.o, rays.d));
        let filter = forms.all()?;
        if !forms.magnitude.simd_lt(f32::INFINITY).all_true() {
            return None;
        }
        // Those that are not active are at their end.
        let t = active.select(rays.t_max, NONE.simd_into(simd));
        let (depth, hits) = (to_f32(t) * filter.length(), Hits { t, ..Hits::none(simd) });
        Some((Packet { rays: sheared, filter, depth, active, hits }, forms.slabs.all()?))
    }

    /// Which rays may meet a triangle of a block nearer than what they have met, as bits.
    #[inline(always)]
    pub fn may_meet(&self, simd: S, block: &Block, lane: usize, tolerance: &Tolerance) -> u64 {
        let corner = |at: usize, axis: Axis| splat_f32(simd, block.corners[at][axis as usize][lane % WIDTH]);
        let passes = self.filter.sides(corner).pass(tolerance);
        let [front, back] = self.filter.depths(corner);
        // The depths are products of rounded factors.
        let farthest = self.depth * (1.0 + 8.0 * f32::EPSILON) + tolerance.error;
        let is_out = passes | front.simd_gt(farthest) | back.simd_lt(-tolerance.error);
        !is_out.to_bitmask() & ((1 << WIDTH) - 1)
    }

    /// Puts the triangle at a place where it is the nearest that the rays of some bits meet. Whether any does.
    #[inline(always)]
    pub fn meet(&mut self, simd: S, scene: &Traceable, place: u32, may: u64) -> bool {
        let triangle = scene.world.triangle(place);
        let (met, t, sides) =
            self.rays.intersect(simd, &BoxedTriangle::new(triangle), bits(simd, may) & self.active);
        let mut nearer = met & t.simd_lt(self.hits.t);
        let as_near = met & t.simd_eq(self.hits.t);
        if as_near.any_true() {
            nearer |= self.named_earlier(simd, scene, triangle, as_near);
        }
        nearer = scene.meet_solid(simd, (triangle, &sides), nearer, false);
        if !nearer.any_true() {
            return false;
        }
        let element: f64x8<S> = f64::from(place).simd_into(simd);
        let hits = &mut self.hits;
        hits.t = nearer.select(t, hits.t);
        hits.element = nearer.select(element, hits.element);
        hits.instance = nearer.select(WORLD.simd_into(simd), hits.instance);
        for (own, weight) in hits.sides.iter_mut().zip(triangle.weights(sides)) {
            *own = nearer.select(weight, *own);
        }
        let emits = scene.primitive(triangle.primitive).emission.is_some();
        hits.emits = if emits { hits.emits | nearer } else { hits.emits & !nearer };
        self.depth = to_f32(hits.t) * self.filter.length();
        true
    }

    /// Those of the rays that have met what is named later than a triangle, or nothing.
    #[cold]
    #[inline(never)]
    fn named_earlier(
        &self,
        simd: S,
        scene: &Traceable,
        triangle: &Triangle,
        rays: mask64x8<S>,
    ) -> mask64x8<S> {
        let mut earlier = 0;
        for lane in those(rays) {
            let hit = self.hit(scene, lane);
            earlier |= u64::from(hit.yields_to(hit.t, triangle.element(ElementId::WORLD))) << lane;
        }
        bits(simd, earlier)
    }

    /// Lets one ray after the other meet what is no triangle.
    #[inline(never)]
    pub fn meet_other(&mut self, simd: S, scene: &Traceable, rays: &Rays<S>, other: Other) {
        let tree = Tree { scene };
        for lane in those(self.active) {
            let (ray, mut hit) = (tree.ray(rays, lane), self.hit(scene, lane));
            let query = Query::new(&scene.world, &ray, ElementId::WORLD, false);
            if scene.meet_other::<S, false>(simd, query, other, &mut hit) {
                let hits = &mut self.hits;
                hits.put(lane, Some(&hit), scene.labels);
                let (own, emits) = (bits(simd, 1 << lane), scene.emits(&hit));
                hits.emits = if emits { hits.emits | own } else { hits.emits & !own };
            }
        }
        self.depth = to_f32(self.hits.t) * self.filter.length();
    }

    /// What a ray has met so far.
    fn hit(&self, scene: &Traceable, lane: usize) -> Hit {
        if self.hits.element[lane] < 0.0 {
            return Hit {
                t: self.hits.t[lane],
                ..nothing(&Ray::new(Default::default(), Default::default()))
            };
        }
        Tree { scene }.hit(&self.hits, lane)
    }
}
