//! Worlds in which rays traverse a hierarchy.

use fearless_simd::Simd;

use super::rays::{HitColumns, Hits, Labels, NONE, OneRay, PLACES, RayColumns};
use crate::number::{bits, eights, has_compress, set_lanes, vectorized};
use crate::ray::{ElementId, Hit, Ray};
use crate::trace::{TraversalRays, WideTracer, nothing};
use crate::traceable::Traceable;

/// A world with its tree. The elements of the world, and those of an object, are numbered: triangles by their place, others from
/// 2^32 on, by their names.
pub(crate) struct Tree<'s> {
    pub scene: &'s Traceable,
}

impl<'s> Tree<'s> {
    /// The number of an element that is no triangle, or [`NONE`].
    pub fn number(&self, element: ElementId) -> f64 {
        if element == ElementId::NONE { NONE } else { PLACES + self.scene.labels.of(element) }
    }

    /// Finds the nearest hits of active rays; each bit of `active` is a ray. `hits`: none at first.
    #[inline(always)]
    pub fn nearest<S: Simd>(
        &self,
        simd: S,
        wide: &mut WideTracer,
        rays: &RayColumns,
        active: u64,
        hits: &mut HitColumns,
    ) {
        let mut rest = active;
        // Without it, rays are faster one by one.
        if has_compress(simd) {
            rest = wide.nearest(simd, self.scene, rays, rest, hits);
        }
        if rest != 0 {
            self.nearest_one_by_one(simd, rays, rest, hits);
        }
    }

    /// Finds the nearest hits of active rays, one ray after the other.
    #[inline(never)]
    fn nearest_one_by_one<S: Simd>(&self, simd: S, rays: &RayColumns, active: u64, hits: &mut HitColumns) {
        vectorized!(simd, {
            let scene = self.scene;
            for (first, own) in eights(active) {
                let of = rays.eight(simd, first);
                let forms = TraversalRays::new(simd, of.o, of.d);
                for lane in set_lanes(bits(simd, own)) {
                    let ray = self.ray(&rays.one(first + lane));
                    let mut hit = nothing(&ray);
                    if scene.search::<S, false>(simd, scene.query(&ray, false), (&forms, lane), &mut hit) {
                        hits.set(first + lane, &hit, scene.labels, scene.emits(&hit));
                    }
                }
            }
        })
    }

    /// The active rays that hit anything but their targets, as bits. `is_shadow`: these are shadow rays, which may pass other holes.
    #[inline(always)]
    pub fn occluded<S: Simd>(
        &self,
        simd: S,
        wide: &mut WideTracer,
        rays: &RayColumns,
        active: u64,
        is_shadow: bool,
    ) -> u64 {
        let (mut met, mut rest) = (0, active);
        if has_compress(simd) {
            (met, rest) = wide.occluded(simd, self.scene, rays, rest, is_shadow);
        }
        if rest != 0 {
            met |= self.occluded_one_by_one(simd, rays, rest, is_shadow);
        }
        met
    }

    /// The active rays that hit anything but their targets, as bits, one ray after the other.
    #[inline(never)]
    fn occluded_one_by_one<S: Simd>(&self, simd: S, rays: &RayColumns, active: u64, is_shadow: bool) -> u64 {
        vectorized!(simd, {
            let (scene, mut met) = (self.scene, 0);
            for (first, own) in eights(active) {
                let of = rays.eight(simd, first);
                let forms = TraversalRays::new(simd, of.o, of.d);
                for lane in set_lanes(bits(simd, own)) {
                    let ray = self.ray(&rays.one(first + lane));
                    let query = scene.query(&ray, is_shadow);
                    let is_met = scene.search::<S, true>(simd, query, (&forms, lane), &mut nothing(&ray));
                    met |= u64::from(is_met) << (first + lane);
                }
            }
            met
        })
    }

    /// A ray for the tests of single rays.
    #[inline(always)]
    pub fn ray(&self, &OneRay { o, d, t_max, leaving, leaving_instance, target, time }: &OneRay) -> Ray {
        let (leaving, leaving_place) = self.left(leaving, leaving_instance);
        let target = self.scene.labels.element(target, ElementId::WORLD);
        Ray { t_max, leaving, leaving_place, target, time, ..Ray::new(o, d) }
    }

    /// The name and the place of an element of a number; of triangles, the instance and the place are enough.
    #[inline(always)]
    fn left(&self, number: f64, instance: u32) -> (ElementId, u32) {
        let nameless = ElementId { instance, ..ElementId::NONE };
        match number {
            number if number < 0.0 => (ElementId::NONE, Hit::NO_PLACE),
            number if number < PLACES => (nameless, number as u32),
            number => (self.scene.labels.element(number - PLACES, instance), Hit::NO_PLACE),
        }
    }

    /// The name of an element that is hit, and its place, see [`Hit::place`].
    #[inline(always)]
    pub fn element<S: Simd>(&self, hits: &Hits<S>, lane: usize) -> (ElementId, u32) {
        let (number, instance) = (hits.element[lane], hits.instance[lane]);
        match self.left(number, instance) {
            (element, Hit::NO_PLACE) => (element, Hit::NO_PLACE),
            (_, place) => (self.scene.group(instance).triangle(place).element(instance), place),
        }
    }

    /// One of the hits.
    pub fn hit<S: Simd>(&self, hits: &Hits<S>, lane: usize) -> Hit {
        let (element, place) = self.element(hits, lane);
        let barycentric = [hits.sides[0][lane], hits.sides[1][lane]];
        Hit { t: hits.t[lane], element, barycentric, place }
    }
}

impl<S: Simd> Hits<S> {
    /// Sets the hit of one ray in a world with a BVH.
    pub fn set_lane(&mut self, lane: usize, hit: Option<&Hit>, labels: Labels) {
        let Some(hit) = hit else {
            self.element[lane] = NONE;
            return;
        };
        let [b0, b1] = hit.barycentric;
        (self.t[lane], self.element[lane], self.instance[lane]) =
            (hit.t, labels.number(hit), hit.element.instance);
        (self.sides[0][lane], self.sides[1][lane], self.sides[2][lane]) = (b0, b1, 1.0 - b0 - b1);
    }
}
