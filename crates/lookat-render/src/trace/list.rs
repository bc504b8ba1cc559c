//! Small worlds, whose elements are tested one after the other without a BVH.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};

use super::rays::{Hits, NONE, POINT_LIGHT, Rays};
use crate::curved::Curved;
use crate::curved::eight::{Meetings, ShapeRays};
use crate::number::{bits, set_lanes, vectorized};
use crate::ray::{ElementId, Hit, NEAR_END, Ray};
use crate::traceable::{NonTriangle, Traceable};
use crate::triangle::sheared::{BoxedTriangle, ShearedRays};
use crate::triangle::{Triangle, holds_end};

/// Above this number of triangles, a BVH is faster.
pub(crate) const MOST: usize = 32;
/// The cost of a sphere, in triangles.
const SPHERE: usize = 2;

/// All elements of a small world, sorted by name.
pub(crate) struct List<'s> {
    scene: &'s Traceable,
    pub elements: Vec<Element<'s>>,
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
    Sphere(&'s Curved),
}

impl<'s> List<'s> {
    /// `None` of worlds that are too large, or have other elements.
    pub fn new(scene: &'s Traceable) -> Option<Self> {
        let world = &scene.world;
        let count = world.triangles.len() + SPHERE * world.non_triangles.len();
        if count > MOST {
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
            curved.as_sphere()?;
            let id = ElementId { instance: ElementId::WORLD, primitive, index: 0 };
            elements.push(Element::new(scene, id, Hit::NO_PLACE, ListedShape::Sphere(curved)));
        }
        elements.sort_by_key(|element| element.id);
        Some(List { scene, has_emitters: elements.iter().any(|element| element.emits), elements })
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
            ListedShape::Sphere(_) => [0.0; 2],
        };
        Hit { t: hits.t[lane], element: element.id, barycentric, place: element.place }
    }

    /// The nearest hits of the rays that are active.
    #[inline(always)]
    pub fn nearest<S: Simd>(&self, simd: S, rays: &Rays<S>, active: mask64x8<S>) -> Hits<S> {
        let sheared = ShearedRays::new(rays.o, rays.d, active);
        let none: f64x8<S> = NONE.simd_into(simd);
        let mut hits = Hits { t: rays.t_max, ..Hits::none(simd) };
        // They come in the order of their names: of hits as near as each other, the first counts.
        for (number, element) in self.elements.iter().enumerate() {
            let own: f64x8<S> = (number as f64).simd_into(simd);
            let (met, t, sides) = element.meet(own, rays, &sheared, hits.t, active);
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

    /// The active rays that hit anything but their targets. `is_shadow`: these are shadow rays, which may pass other holes.
    #[inline(always)]
    pub fn occluded<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        active: mask64x8<S>,
        is_shadow: bool,
    ) -> mask64x8<S> {
        let sheared = ShearedRays::new(rays.o, rays.d, active);
        let mut free = active;
        for (number, element) in self.elements.iter().enumerate() {
            if !free.any_true() {
                break;
            }
            let own: f64x8<S> = (number as f64).simd_into(simd);
            // Only what emits is ever a target.
            let others = if element.emits { free & !rays.target.simd_eq(element.label) } else { free };
            let (met, t, _) = element.meet(own, rays, &sheared, rays.t_max, others);
            let mut is_blocked = met & t.simd_le(rays.t_max);
            if element.is_cut_out && is_blocked.any_true() {
                is_blocked = element.meet_solid(self.scene, rays, is_blocked, is_shadow);
            }
            let may_be_end = is_blocked & rays.target.simd_eq(POINT_LIGHT) & t.simd_gt(rays.t_max * NEAR_END);
            if may_be_end.any_true() {
                is_blocked &= !element.ends(own, rays, may_be_end);
            }
            free &= !is_blocked;
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
            scene.meet_solid(simd, (boxed.triangle, &sides), met, is_shadow)
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
                ListedShape::Sphere(sphere) => sphere.is_met_at_end(&ray, rays.leaving[lane] == own[lane]),
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
            ListedShape::Sphere(sphere) => {
                let (met, t) = meet_sphere(simd, sphere, rays, t_max, leaving, active);
                (met, t, None)
            }
        }
    }
}

#[inline(always)]
fn meet_sphere<S: Simd>(
    simd: S,
    curved: &Curved,
    rays: &Rays<S>,
    t_max: f64x8<S>,
    leaving: mask64x8<S>,
    active: mask64x8<S>,
) -> (mask64x8<S>, f64x8<S>) {
    let Meetings { met, t, doubtful } =
        curved.meet(&ShapeRays { o: rays.o, d: rays.d, t_max, leaving, active });
    if !doubtful.any_true() {
        return (met, t);
    }
    one_by_one(simd, curved, rays, t_max, leaving, (met, t, doubtful))
}

/// Asks the sphere ray by ray.
#[inline(never)]
fn one_by_one<S: Simd>(
    simd: S,
    curved: &Curved,
    rays: &Rays<S>,
    t_max: f64x8<S>,
    leaving: mask64x8<S>,
    (met, mut t, doubtful): (mask64x8<S>, f64x8<S>, mask64x8<S>),
) -> (mask64x8<S>, f64x8<S>) {
    let (mut met, leaving) = (met.to_bitmask(), leaving.to_bitmask());
    for lane in set_lanes(doubtful) {
        let ray = Ray::new(rays.o.lane(lane), rays.d.lane(lane));
        let found = curved.intersect(&ray, t_max[lane], leaving >> lane & 1 == 1);
        met = met & !(1 << lane) | u64::from(found.is_some()) << lane;
        t[lane] = found.unwrap_or(0.0);
    }
    (bits(simd, met), t)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::number::{Vec3x8, side_by_side};
    use crate::prepare::Prepared;
    use crate::testing::{noise, scene};

    /// Where meshes have holes, others of them for shadow rays, rays meet what they meet in a tree.
    #[test]
    fn rays_pass_the_holes_of_small_worlds() {
        let mesh = "Shape \"trianglemesh\" \"point P\" [-2 -2 0 2 -2 0 2 2 0 -2 2 0] \"integer indices\" [0 1 2 0 2 3]
            \"float uv\" [0 0 1 0 1 1 0 1]";
        let traceable = Prepared::new(&scene(&format!(
            "Film \"image\" Camera \"perspective\" WorldBegin
             Texture \"h\" \"float\" \"checkerboard\" \"float uscale\" 4 \"float vscale\" 4 Translate 0 0 3
             {mesh} \"texture alpha\" \"h\" Translate 0 0 1 {mesh} \"texture shadowalpha\" \"h\" Translate 1 0 1 {mesh} WorldEnd"
        )))
        .traceable;
        let list = List::new(&traceable).unwrap();
        let mut passed = 0;
        side_by_side!(traceable.level, simd => for case in 0..2000 {
            let ray = Ray::new(DVec3::ZERO, DVec3::new(noise(case, 1.1), noise(case, 2.3), 2.0).normalize());
            let (rays, all) = (Rays::new(Vec3x8::splat(simd, ray.o), Vec3x8::splat(simd, ray.d)), bits(simd, 0xff));
            let hits = list.nearest(simd, &rays, all);
            let name = |hit: Hit| (hit.element, hit.t.to_bits(), hit.barycentric.map(f64::to_bits));
            let own = hits.is_hit().all_true().then(|| name(list.hit(&hits, 5)));
            assert_eq!(own, traceable.nearest(&ray).map(name), "{ray:?}");
            assert_eq!(list.occluded(simd, &rays, all, false).all_true(), own.is_some());
            let is_blocked = traceable.occluded(&ray);
            assert_eq!(list.occluded(simd, &rays, all, true).all_true(), is_blocked, "{ray:?}");
            passed += u32::from(own.is_some() && !is_blocked);
        });
        assert!((100..1900).contains(&passed), "{passed} of 2000 pass as shadow rays alone");
    }
}
