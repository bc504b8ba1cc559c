//! Worlds in which rays are traced one by one, down their tree.

use fearless_simd::{Simd, mask64x8};

use super::rays::{Hits, Labels, NONE, PLACES, Rays};
use crate::number::{bits, set_lanes};
use crate::ray::{ElementId, Hit, Ray};
use crate::trace::TraversalRays;
use crate::trace::nothing;
use crate::traceable::Traceable;

/// A world with its tree. The elements of the world, and those of an object, are numbered: triangles by their place, others from
/// 2^32 on, by their names.
pub(crate) struct Tree<'s> {
    pub scene: &'s Traceable,
}

/// The label of the element that was hit.
#[inline(always)]
fn number(hit: &Hit, labels: Labels) -> f64 {
    match hit.place {
        Hit::NO_PLACE => PLACES + labels.of(hit.element),
        place => f64::from(place),
    }
}

impl<'s> Tree<'s> {
    /// The number of an element that is no triangle, or [`NONE`].
    pub fn number(&self, element: ElementId) -> f64 {
        if element == ElementId::NONE { NONE } else { PLACES + self.scene.labels.of(element) }
    }

    /// The nearest hits of the rays that are active.
    #[inline(always)]
    pub fn nearest<S: Simd>(&self, simd: S, rays: &Rays<S>, active: mask64x8<S>) -> Hits<S> {
        let (scene, forms) = (self.scene, TraversalRays::new(simd, rays.o, rays.d));
        let (mut hits, mut emits) = (Hits::none(simd), 0);
        for lane in set_lanes(active) {
            let ray = self.ray(rays, lane);
            let mut hit = nothing(&ray);
            if scene.search::<S, false>(simd, scene.query(&ray, false), (&forms, lane), &mut hit) {
                hits.set_lane(lane, Some(&hit), scene.labels);
                emits |= u64::from(scene.emits(&hit)) << lane;
            }
        }
        Hits { emits: bits(simd, emits), ..hits }
    }

    /// The active rays that hit anything but their targets. `is_shadow`: these are shadow rays, which may pass other holes.
    #[inline(always)]
    pub fn occluded<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        active: mask64x8<S>,
        is_shadow: bool,
    ) -> mask64x8<S> {
        let (scene, forms) = (self.scene, TraversalRays::new(simd, rays.o, rays.d));
        let mut met = 0;
        for lane in set_lanes(active) {
            let ray = self.ray(rays, lane);
            let query = scene.query(&ray, is_shadow);
            let is_met = scene.search::<S, true>(simd, query, (&forms, lane), &mut nothing(&ray));
            met |= u64::from(is_met) << lane;
        }
        bits(simd, met)
    }

    /// One of the rays.
    #[inline(always)]
    pub fn ray<S: Simd>(&self, rays: &Rays<S>, lane: usize) -> Ray {
        let (leaving, leaving_place) = self.left(rays.leaving[lane], rays.leaving_instance[lane] as u32);
        let target = self.scene.labels.element(rays.target[lane], ElementId::WORLD);
        Ray {
            t_max: rays.t_max[lane],
            leaving,
            leaving_place,
            target,
            ..Ray::new(rays.o.lane(lane), rays.d.lane(lane))
        }
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
        let (number, instance) = (hits.element[lane], hits.instance[lane] as u32);
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
            (hit.t, number(hit, labels), f64::from(hit.element.instance));
        (self.sides[0][lane], self.sides[1][lane], self.sides[2][lane]) = (b0, b1, 1.0 - b0 - b1);
    }
}
