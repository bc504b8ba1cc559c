//! Rays side by side, and their hits.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*, u32x8};
use glam::DVec3;

use crate::columns::{ROOM, Stored, columns};
use crate::number::{LANES, Vec3x8, bits, narrow};
use crate::ray::{ElementId, Hit};

/// Rays, relative to the origin.
#[derive(Clone, Copy)]
pub(crate) struct Rays<S: Simd> {
    pub o: Vec3x8<S>,
    pub d: Vec3x8<S>,
    pub t_max: f64x8<S>,
    /// The number, in its group, of the element that each leaves; [`NONE`] of those that leave none.
    pub leaving: f64x8<S>,
    /// The instance of that element, or [`ElementId::WORLD`].
    pub leaving_instance: u32x8<S>,
    /// The label of the element that each shadow ray goes to, [`POINT_LIGHT`] or [`NONE`].
    pub target: f64x8<S>,
    /// See [`Ray::time`](crate::ray::Ray::time).
    pub time: f64x8<S>,
}

impl<S: Simd> Rays<S> {
    /// Unlimited ones that start in free space.
    #[inline(always)]
    pub fn new(o: Vec3x8<S>, d: Vec3x8<S>) -> Self {
        let simd = o.x.token();
        let (none, world) = (NONE.simd_into(simd), ElementId::WORLD.simd_into(simd));
        let t_max = f64::INFINITY.simd_into(simd);
        let time = 0.0.simd_into(simd);
        Rays { o, d, t_max, leaving: none, leaving_instance: world, target: none, time }
    }

    /// Keeps the lanes in `mask` and takes the other lanes from `others`.
    #[inline(always)]
    pub fn keep_where(self, mask: mask64x8<S>, others: Self) -> Self {
        Rays {
            o: self.o.keep_where(mask, others.o),
            d: self.d.keep_where(mask, others.d),
            t_max: mask.select(self.t_max, others.t_max),
            leaving: mask.select(self.leaving, others.leaving),
            leaving_instance: narrow(mask).select(self.leaving_instance, others.leaving_instance),
            target: mask.select(self.target, others.target),
            time: mask.select(self.time, others.time),
        }
    }

    /// One of the rays.
    #[inline(always)]
    pub fn one(&self, lane: usize) -> OneRay {
        OneRay {
            o: self.o.lane(lane),
            d: self.d.lane(lane),
            t_max: self.t_max[lane],
            leaving: self.leaving[lane],
            leaving_instance: self.leaving_instance[lane],
            target: self.target[lane],
            time: self.time[lane],
        }
    }

    /// The points on the rays at distances `t`.
    #[inline(always)]
    pub fn at(&self, t: f64x8<S>) -> Vec3x8<S> {
        self.o + self.d * t
    }
}

columns! {
    /// Rays that are traced together.
    pub(crate) struct RayColumns of Rays {
        o_x: f64 = o.x,
        o_y: f64 = o.y,
        o_z: f64 = o.z,
        d_x: f64 = d.x,
        d_y: f64 = d.y,
        d_z: f64 = d.z,
        t_max: f64 = t_max,
        leaving: f64 = leaving,
        leaving_instance: u32 = leaving_instance,
        target: f64 = target,
        time: f64 = time,
    }
}

/// One of [`Rays`] or [`RayColumns`], with the same fields.
pub(crate) struct OneRay {
    pub o: DVec3,
    pub d: DVec3,
    pub t_max: f64,
    pub leaving: f64,
    pub leaving_instance: u32,
    pub target: f64,
    pub time: f64,
}

impl RayColumns {
    /// The eight rays from one on.
    #[inline(always)]
    pub fn eight<S: Simd>(&self, simd: S, from: usize) -> Rays<S> {
        let zero = Vec3x8::splat(simd, DVec3::ZERO);
        let mut rays = Rays::new(zero, zero);
        self.load(simd, from, &mut rays);
        rays
    }

    /// The origin of one of the rays, and its direction.
    #[inline(always)]
    pub fn line(&self, ray: usize) -> [DVec3; 2] {
        let ray = ray % ROOM;
        [
            DVec3::new(self.o_x[ray], self.o_y[ray], self.o_z[ray]),
            DVec3::new(self.d_x[ray], self.d_y[ray], self.d_z[ray]),
        ]
    }

    /// One of the rays.
    #[inline(always)]
    pub fn one(&self, ray: usize) -> OneRay {
        let [o, d] = self.line(ray);
        let (t_max, leaving, target) = (self.t_max[ray], self.leaving[ray], self.target[ray]);
        let (leaving_instance, time) = (self.leaving_instance[ray], self.time[ray]);
        OneRay { o, d, t_max, leaving, leaving_instance, target, time }
    }

    /// Sets one of the rays.
    #[inline(always)]
    pub fn set(&mut self, ray: usize, of: &OneRay) {
        let ray = ray % ROOM;
        [self.o_x[ray], self.o_y[ray], self.o_z[ray]] = of.o.into();
        [self.d_x[ray], self.d_y[ray], self.d_z[ray]] = of.d.into();
        (self.t_max[ray], self.leaving[ray], self.target[ray]) = (of.t_max, of.leaving, of.target);
        (self.leaving_instance[ray], self.time[ray]) = (of.leaving_instance, of.time);
    }
}

/// The number of no element.
pub(crate) const NONE: f64 = -1.0;
/// The label of [`ElementId::POINT_LIGHT`].
pub(crate) const POINT_LIGHT: f64 = -2.0;

/// 2^32: more than the place of any triangle.
pub(super) const PLACES: f64 = 4_294_967_296.0;

/// 2^52.
const MOST_LABELS: f64 = PLACES * 1_048_576.0;

/// Tells elements of the world, or those of an object, apart, by labels: numbers that are exact; [`NONE`] is no element.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Labels {
    /// A power of two, more than any index, and one over it.
    indices: [f64; 2],
}

impl Labels {
    /// Labels for `primitives` primitives whose elements have indices below `indices`. Panics above 2^52 labels: no memory
    /// holds such a world.
    pub fn new(primitives: usize, indices: usize) -> Self {
        let indices = indices.next_power_of_two() as f64;
        // With the places below them, all are less than 2^53.
        assert!(primitives as f64 * indices <= MOST_LABELS, "more elements than f64 can tell apart");
        Labels { indices: [indices, 1.0 / indices] }
    }

    pub fn of(self, element: ElementId) -> f64 {
        match element {
            ElementId::NONE => NONE,
            ElementId::POINT_LIGHT => POINT_LIGHT,
            element => f64::from(element.primitive) * self.indices[0] + f64::from(element.index),
        }
    }

    /// The number of the element that was hit in a world with a BVH.
    #[inline(always)]
    pub(super) fn number(self, hit: &Hit) -> f64 {
        match hit.place {
            Hit::NO_PLACE => PLACES + self.of(hit.element),
            place => f64::from(place),
        }
    }

    /// The element of a label, and of an instance or the world.
    #[inline(always)]
    pub(super) fn element(self, label: f64, instance: u32) -> ElementId {
        if label < 0.0 {
            return if label == POINT_LIGHT { ElementId::POINT_LIGHT } else { ElementId::NONE };
        }
        let [indices, inverse] = self.indices;
        let primitive = (label * inverse).floor();
        ElementId { instance, primitive: primitive as u32, index: (label - primitive * indices) as u32 }
    }
}

/// The nearest hits.
#[derive(Clone, Copy)]
pub(crate) struct Hits<S: Simd> {
    pub t: f64x8<S>,
    /// Numbers of elements in their groups; [`NONE`] where there is no hit.
    pub element: f64x8<S>,
    /// The instances of the elements, or [`ElementId::WORLD`].
    pub instance: u32x8<S>,
    /// For hits of triangles: in a [`super::List`] unnormalized weights of the corners, in a [`super::Tree`] the barycentric
    /// coordinates.
    pub sides: [f64x8<S>; 3],
    /// The hits on elements that emit light.
    pub emits: mask64x8<S>,
}

impl<S: Simd> Hits<S> {
    /// None at all.
    #[inline(always)]
    pub fn none(simd: S) -> Self {
        let none: f64x8<S> = NONE.simd_into(simd);
        let (instance, emits) = (ElementId::WORLD.simd_into(simd), mask64x8::splat(simd, false));
        Hits { t: none, element: none, instance, sides: [none; 3], emits }
    }

    /// The rays with a hit.
    #[inline(always)]
    pub fn is_hit(&self) -> mask64x8<S> {
        self.element.simd_ge(0.0)
    }
}

columns! {
    /// The nearest hits of [`RayColumns`].
    pub(crate) struct HitColumns of Hits {
        t: f64 = t,
        element: f64 = element,
        instance: u32 = instance,
        side_0: f64 = sides[0],
        side_1: f64 = sides[1],
        side_2: f64 = sides[2],
        emits: f32 = emits,
    }
}

impl HitColumns {
    /// The hits of the eight rays from one on.
    #[inline(always)]
    pub fn eight<S: Simd>(&self, simd: S, from: usize) -> Hits<S> {
        let mut hits = Hits::none(simd);
        self.load(simd, from, &mut hits);
        hits
    }

    /// Sets the hits of the eight rays from one on.
    #[inline(always)]
    pub fn set_eight<S: Simd>(&mut self, simd: S, from: usize, hits: &Hits<S>) {
        self.store(from, &Stored::new(bits(simd, 0xff)), hits);
    }

    /// Sets the hit of one ray to that of others of the same number.
    pub fn copy(&mut self, ray: usize, from: &Self) {
        let ray = ray % ROOM;
        (self.t[ray], self.element[ray]) = (from.t[ray], from.element[ray]);
        (self.instance[ray], self.emits[ray]) = (from.instance[ray], from.emits[ray]);
        (self.side_0[ray], self.side_1[ray], self.side_2[ray]) =
            (from.side_0[ray], from.side_1[ray], from.side_2[ray]);
    }

    /// Removes all hits.
    #[inline(always)]
    pub fn clear(&mut self) {
        (self.element, self.emits) = ([NONE; ROOM], [0.0; ROOM]);
    }

    /// Sets the hit of one ray in a world with a BVH.
    #[inline(always)]
    pub fn set(&mut self, ray: usize, hit: &Hit, labels: Labels, emits: bool) {
        let (ray, [b0, b1]) = (ray % ROOM, hit.barycentric);
        (self.t[ray], self.element[ray]) = (hit.t, labels.number(hit));
        self.instance[ray] = hit.element.instance;
        (self.side_0[ray], self.side_1[ray], self.side_2[ray]) = (b0, b1, 1.0 - b0 - b1);
        self.emits[ray] = f32::from(emits);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_tell_all_elements_apart() {
        let labels = Labels::new(1 << 23, (1 << 29) - 1);
        for (primitive, index) in [(0, 0), (0, 1), (1, 0), ((1 << 23) - 1, (1 << 29) - 2)] {
            let element = ElementId { instance: ElementId::WORLD, primitive, index };
            let number = PLACES + labels.of(element);
            assert_eq!(labels.element(number - PLACES, ElementId::WORLD), element);
        }
    }

    #[test]
    #[should_panic(expected = "more elements")]
    fn labels_that_would_be_rounded_fail() {
        Labels::new((1 << 23) + 1, 1 << 29);
    }
}
