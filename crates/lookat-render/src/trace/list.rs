//! Small worlds, whose elements are tested one after the other without a BVH.

mod filter;
#[cfg(test)]
mod tests;

use fearless_simd::{Level, Simd, f64x8, mask64x8, prelude::*};

use super::rays::{HitColumns, Hits, NONE, POINT_LIGHT, RayColumns, Rays};
use crate::curved::Curved;
use crate::curved::side_by_side::ShapeRays;
use crate::number::{LANES, bits, eights, has_compress, set_bits, set_lanes, side_by_side, vectorized};
use crate::ray::{ElementId, Hit, NEAR_END, Ray};
use crate::traceable::{NonTriangle, Traceable};
use crate::triangle::sheared::{BoxedTriangle, ShearedRays};
use crate::triangle::{Triangle, holds_end};
use filter::ListFilter;

/// The most elements of a list: with more, a BVH is faster.
const MOST: usize = 48;
/// As [`MOST`], with instructions that do not move chosen lanes together.
const MOST_WITHOUT_COMPRESS: usize = 16;
/// Room for a number or mask of each element.
const ROOM: usize = 64;
const _: () = assert!(MOST <= ROOM);

fn most(level: Level) -> usize {
    side_by_side!(level, simd => if has_compress(simd) { MOST } else { MOST_WITHOUT_COMPRESS })
}

/// All elements of a small world, sorted by name.
pub(crate) struct List<'s> {
    scene: &'s Traceable,
    pub elements: Vec<Element<'s>>,
    filter: ListFilter,
    has_emitters: bool,
}

pub(crate) struct Element<'s> {
    pub id: ElementId,
    /// The index of the triangle in its group: see [`Hit::place`].
    pub place: u32,
    /// See [`super::rays::Labels`].
    label: f64,
    emits: bool,
    is_cut_out: bool,
    pub shape: ListedShape<'s>,
}

#[derive(Clone, Copy)]
pub(crate) enum ListedShape<'s> {
    Triangle(BoxedTriangle<'s>),
    Curved(&'s Curved),
}

impl<'s> List<'s> {
    /// `None` of worlds that are empty or too large, have curves or instances, or are too small for their distance from the origin.
    pub fn new(scene: &'s Traceable) -> Option<Self> {
        let world = &scene.world;
        if world.triangles.len() + world.non_triangles.len() > most(scene.level) {
            return None;
        }
        let triangle = |(place, triangle): (u32, &'s Triangle)| {
            let shape = ListedShape::Triangle(BoxedTriangle::new(triangle));
            Element::new(scene, triangle.element(ElementId::WORLD), place, shape)
        };
        let mut elements: Vec<Element<'s>> = (0..).zip(&world.triangles).map(triangle).collect();
        for other in &world.non_triangles {
            let NonTriangle::Curved { primitive, shape } = *other else { return None };
            let curved = &scene.curved[shape as usize];
            let id = ElementId { instance: ElementId::WORLD, primitive, index: 0 };
            elements.push(Element::new(scene, id, Hit::NO_PLACE, ListedShape::Curved(curved)));
        }
        elements.sort_by_key(|element| element.id);
        let (filter, has_emitters) =
            (ListFilter::new(&elements)?, elements.iter().any(|element| element.emits));
        Some(List { scene, elements, filter, has_emitters })
    }

    /// The number of an element, or [`NONE`].
    pub fn number(&self, id: ElementId) -> f64 {
        self.elements.iter().position(|element| element.id == id).map_or(NONE, |number| number as f64)
    }

    /// One of the hits.
    pub fn hit<S: Simd>(&self, hits: &Hits<S>, lane: usize) -> Hit {
        let element = &self.elements[hits.element[lane] as usize];
        let barycentric = match element.shape {
            ListedShape::Triangle(BoxedTriangle { triangle, .. }) => {
                triangle.barycentric([hits.sides[0][lane], hits.sides[1][lane], hits.sides[2][lane]])
            }
            ListedShape::Curved(_) => [0.0; 2],
        };
        Hit { t: hits.t[lane], element: element.id, barycentric, place: element.place }
    }

    /// The numbers of the elements that any of eight rays may hit.
    #[inline(always)]
    fn numbers(&self, may: &[u64; ROOM], first: usize) -> impl Iterator<Item = usize> {
        let is_met = |number: usize| u64::from(may[number] >> first & 0xff != 0);
        let count = self.elements.len().min(ROOM);
        set_bits((0..count).fold(0, |set, number| set | is_met(number) << number))
    }

    /// Finds the nearest hits of active rays; each bit of `active` is a ray.
    #[inline(always)]
    pub fn nearest<S: Simd>(&self, simd: S, rays: &RayColumns, active: u64, hits: &mut HitColumns) {
        let mut may = [active; ROOM];
        self.filter.test::<S, false>(simd, rays, active, &mut may);
        for (first, own) in eights(active) {
            let found = self.nearest_of_eight(simd, &rays.eight(simd, first), bits(simd, own), (&may, first));
            hits.set_eight(simd, first, &found);
        }
    }

    /// The nearest hits of the eight rays from `first` on. `may`: bits of the rays that may hit each element.
    #[inline(always)]
    fn nearest_of_eight<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        active: mask64x8<S>,
        (may, first): (&[u64; ROOM], usize),
    ) -> Hits<S> {
        let sheared = ShearedRays::new(rays.o, rays.d, active);
        let none: f64x8<S> = NONE.simd_into(simd);
        let mut hits = Hits { t: rays.t_max, ..Hits::none(simd) };
        // They come in the order of their names: of hits as near as each other, the first counts.
        for number in self.numbers(may, first) {
            let (element, may) = (&self.elements[number], may[number] >> first & 0xff);
            let own: f64x8<S> = (number as f64).simd_into(simd);
            let (met, t, sides) = element.meet(own, rays, &sheared, hits.t, bits(simd, may));
            let nearer = met & (t.simd_lt(hits.t) | (t.simd_eq(hits.t) & hits.element.simd_eq(none)));
            let nearer = if element.is_cut_out && nearer.any_true() {
                element.meet_solid(self.scene, rays, nearer, false)
            } else {
                nearer
            };
            hits.t = nearer.select(t, hits.t);
            hits.element = nearer.select(own, hits.element);
            for (side, known) in sides.into_iter().flatten().zip(&mut hits.sides) {
                *known = nearer.select(side, *known);
            }
        }
        if self.has_emitters {
            for lane in set_lanes(hits.is_hit()) {
                let emits = self.elements[hits.element[lane] as usize].emits;
                hits.emits |= bits(simd, u64::from(emits) << lane);
            }
        }
        hits
    }

    /// The active rays that hit anything but their targets; each bit is a ray. `is_shadow`: these are shadow rays, which may pass other holes.
    #[inline(always)]
    pub fn occluded<S: Simd>(&self, simd: S, rays: &RayColumns, active: u64, is_shadow: bool) -> u64 {
        let mut may = [active; ROOM];
        // Only what emits is ever a target.
        for (may, element) in may.iter_mut().zip(&self.elements).filter(|(_, element)| element.emits) {
            for (first, own) in eights(active) {
                let target = f64x8::from_slice(simd, &rays.target[first..first + LANES]);
                *may &= !((target.simd_eq(element.label).to_bitmask() & own) << first);
            }
        }
        let blocked = self.filter.test::<S, true>(simd, rays, active, &mut may);
        let rest = may[..self.elements.len()].iter().fold(0, |rest, may| rest | may) & !blocked;
        let mut met = blocked;
        for (first, own) in eights(rest) {
            let rays = &rays.eight(simd, first);
            met |= self.occluded_of_eight(simd, rays, own, (&may, first), is_shadow) << first;
        }
        met
    }

    /// Does what [`List::occluded`] does, for the eight rays from `first` on. `may`: bits of the rays that may hit each element.
    #[inline(always)]
    fn occluded_of_eight<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        active: u64,
        (may, first): (&[u64; ROOM], usize),
        is_shadow: bool,
    ) -> u64 {
        let sheared = ShearedRays::new(rays.o, rays.d, bits(simd, active));
        let mut free = active;
        for number in self.numbers(may, first) {
            let (element, may) = (&self.elements[number], may[number] >> first & free);
            let own: f64x8<S> = (number as f64).simd_into(simd);
            let (met, t, _) = element.meet(own, rays, &sheared, rays.t_max, bits(simd, may));
            let mut is_blocked = met & t.simd_le(rays.t_max);
            if element.is_cut_out && is_blocked.any_true() {
                is_blocked = element.meet_solid(self.scene, rays, is_blocked, is_shadow);
            }
            let may_be_end = is_blocked & rays.target.simd_eq(POINT_LIGHT) & t.simd_gt(rays.t_max * NEAR_END);
            if may_be_end.any_true() {
                is_blocked &= !element.ends(own, rays, may_be_end);
            }
            free &= !is_blocked.to_bitmask();
        }
        active & !free
    }
}

impl<'s> Element<'s> {
    fn new(scene: &Traceable, id: ElementId, place: u32, shape: ListedShape<'s>) -> Self {
        let emits = scene.primitive(id.primitive).emission.is_some();
        let (label, is_cut_out) = (scene.labels.of(id), scene.is_cut_out(id.primitive));
        Element { id, place, label, emits, is_cut_out, shape }
    }

    /// The rays that hit the element where it has no hole. Out of line, so that other elements do not pay for it.
    #[cold]
    #[inline(never)]
    fn meet_solid<S: Simd>(
        &self,
        scene: &Traceable,
        rays: &Rays<S>,
        met: mask64x8<S>,
        is_shadow: bool,
    ) -> mask64x8<S> {
        let (simd, ListedShape::Triangle(boxed)) = (met.token(), &self.shape) else { return met };
        vectorized!(simd, {
            let (_, _, sides) = ShearedRays::new(rays.o, rays.d, met).intersect(simd, boxed, met);
            scene.meet_solid((boxed.triangle, &sides), met, is_shadow)
        })
    }

    /// The shadow rays to point lights that hit the element only at their ends. `own`: the number of the element.
    #[cold]
    #[inline(never)]
    fn ends<S: Simd>(&self, own: f64x8<S>, rays: &Rays<S>, met: mask64x8<S>) -> mask64x8<S> {
        let mut ends = 0;
        for lane in set_lanes(met) {
            let ray = Ray { t_max: rays.t_max[lane], ..Ray::new(rays.o.lane(lane), rays.d.lane(lane)) };
            let is_end = match &self.shape {
                ListedShape::Triangle(boxed) => holds_end(&ray, &boxed.triangle.corners),
                ListedShape::Curved(curved) => curved.is_met_at_end(&ray, rays.leaving[lane] == own[lane]),
            };
            ends |= u64::from(is_end) << lane;
        }
        bits(own.token(), ends)
    }

    /// The active rays that hit the element, the distances, and for a triangle the unnormalized weights of its corners.
    /// `own`: the number of the element.
    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        own: f64x8<S>,
        rays: &Rays<S>,
        sheared: &ShearedRays<S>,
        t_max: f64x8<S>,
        active: mask64x8<S>,
    ) -> (mask64x8<S>, f64x8<S>, Option<[f64x8<S>; 3]>) {
        let (simd, leaving) = (own.token(), rays.leaving.simd_eq(own));
        match &self.shape {
            ListedShape::Triangle(boxed) => {
                let (met, t, sides) = sheared.intersect(simd, boxed, active & !leaving);
                (met, t, Some(sides))
            }
            ListedShape::Curved(curved) => {
                let rays = ShapeRays { o: rays.o, d: rays.d, t_max, leaving, active };
                let (met, t) = curved.intersect_all(&rays);
                (met, t, None)
            }
        }
    }
}
