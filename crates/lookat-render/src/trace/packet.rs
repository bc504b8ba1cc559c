//! Packets: eight rays side by side against the triangles of a block.

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};

use super::lanes::{Hits, NONE, Rays, Tree, WORLD};
use super::{Query, nothing};
use crate::bvh::WIDTH;
use crate::lanes::{Vec3x8, bits, splat_f32, those, to_f32};
use crate::ray::{ElementId, Hit, Ray};
use crate::traceable::{Other, Traceable};
use crate::triangle::block::{Block, Tolerance};
use crate::triangle::lanes::{BoxedTriangle, ShearedRays};
use crate::triangle::{Axis, Triangle};

/// Eight rays whose direction is longest along one axis, and their nearest hits so far.
///
/// A filter in `f32` leaves out triangles that are not met, as [`crate::triangle::block::FilterRay`] does for one ray and eight
/// triangles; `f64` decides about the others.
pub(super) struct Packet<S: Simd> {
    rays: ShearedRays<S>,
    axes: [Axis; 3],
    turned: [f32x8<S>; 3],
    shear: [f32x8<S>; 2],
    /// The sign of the directions along the last axis.
    sign: f32x8<S>,
    /// Their size along it.
    length: f32x8<S>,
    /// How far along it the nearest hits are.
    depth: f32x8<S>,
    active: mask64x8<S>,
    pub hits: Hits<S>,
}

impl<S: Simd> Packet<S> {
    /// `None` of rays that are longest along different axes, or so long or short that `f32` says nothing.
    #[inline(always)]
    pub fn new(simd: S, rays: &Rays<S>, active: mask64x8<S>) -> Option<Self> {
        let sheared = ShearedRays::new(rays.o, rays.d, active);
        let axes = sheared.axes()?;
        let (turned, shear) = sheared.turned();
        let along = Axis::of(axes[2], &[rays.d.x, rays.d.y, rays.d.z]);
        let length = along.abs();
        let is_safe = length.simd_ge(1e-100) & length.simd_lt(1e100);
        if !is_safe.all_true() {
            return None;
        }
        let (none, one): (f64x8<S>, f64x8<S>) = (NONE.simd_into(simd), 1.0.simd_into(simd));
        let length = to_f32(length);
        // Those that are not active are at their end.
        let t = active.select(rays.t_max, none);
        Some(Packet {
            rays: sheared,
            axes,
            turned: [to_f32(turned.x), to_f32(turned.y), to_f32(turned.z)],
            shear: [to_f32(shear.x), to_f32(shear.y)],
            sign: to_f32(one.copysign(along)),
            length,
            depth: to_f32(t) * length,
            active,
            hits: Hits { t, ..Hits::none(simd) },
        })
    }

    /// One over the directions.
    #[inline(always)]
    pub fn inverse(&self) -> Vec3x8<S> {
        self.rays.inverse()
    }

    /// Which rays may meet a triangle of a block nearer than what they have met, as bits.
    #[inline(always)]
    pub fn may_meet(&self, simd: S, block: &Block, lane: usize, tolerance: &Tolerance) -> u64 {
        let a = self.sheared(simd, block.corner(0, lane));
        let b = self.sheared(simd, block.corner(1, lane));
        let c = self.sheared(simd, block.corner(2, lane));
        let (u, v, w) = (cross(c, b), cross(a, c), cross(b, a));
        let (least, greatest) = (u.min(v).min(w), u.max(v).max(w));
        let (front, back) = (a[2].min(b[2]).min(c[2]), a[2].max(b[2]).max(c[2]));
        let passes = least.simd_lt(-tolerance.side) & greatest.simd_gt(tolerance.side);
        // The depths are products of rounded factors.
        let farthest = self.depth * (1.0 + 8.0 * f32::EPSILON) + tolerance.error;
        let is_out = passes | front.simd_gt(farthest) | back.simd_lt(-tolerance.error);
        !is_out.to_bitmask() & ((1 << WIDTH) - 1)
    }

    /// A corner of a triangle in `f32`, as [`ShearedRays`] has it, and its depth along the rays.
    #[inline(always)]
    fn sheared(&self, simd: S, corner: [f32; 3]) -> [f32x8<S>; 3] {
        let [x, y, z] = self.axes;
        let x = splat_f32(simd, x.of(&corner)) - self.turned[0];
        let y = splat_f32(simd, y.of(&corner)) - self.turned[1];
        let z = splat_f32(simd, z.of(&corner)) - self.turned[2];
        [(-self.shear[0]).mul_add(z, x), (-self.shear[1]).mul_add(z, y), z * self.sign]
    }

    /// Puts a triangle, at its place, where it is the nearest that the rays of some bits meet. Whether any does.
    #[inline(always)]
    pub fn meet(&mut self, simd: S, scene: &Traceable, triangle: &Triangle, place: u32, may: u64) -> bool {
        let (met, t, sides) =
            self.rays.intersect(simd, &BoxedTriangle::new(triangle), bits(simd, may) & self.active);
        let mut nearer = met & t.simd_lt(self.hits.t);
        let as_near = met & t.simd_eq(self.hits.t);
        if as_near.any_true() {
            nearer |= self.named_earlier(simd, scene, triangle, as_near);
        }
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
        self.depth = to_f32(hits.t) * self.length;
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
            if scene.meet_other::<false>(query, other, &mut hit) {
                let hits = &mut self.hits;
                hits.put(lane, Some(&hit), scene.labels);
                let (own, emits) = (bits(simd, 1 << lane), scene.emits(&hit));
                hits.emits = if emits { hits.emits | own } else { hits.emits & !own };
            }
        }
        self.depth = to_f32(self.hits.t) * self.length;
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

#[inline(always)]
fn cross<S: Simd>(p: [f32x8<S>; 3], q: [f32x8<S>; 3]) -> f32x8<S> {
    p[0].mul_sub(q[1], p[1] * q[0])
}
