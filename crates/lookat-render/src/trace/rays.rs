//! Rays side by side, and their hits.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};

use crate::number::Vec3x8;
use crate::ray::ElementId;

/// Rays, relative to the origin.
#[derive(Clone, Copy)]
pub(crate) struct Rays<S: Simd> {
    pub o: Vec3x8<S>,
    pub d: Vec3x8<S>,
    pub t_max: f64x8<S>,
    /// The number, in its group, of the element that each leaves; [`NONE`] of those that leave none.
    pub leaving: f64x8<S>,
    /// The instance of that element, or [`WORLD`].
    pub leaving_instance: f64x8<S>,
    /// The label of the element that each shadow ray goes to, [`POINT_LIGHT`] or [`NONE`].
    pub target: f64x8<S>,
}

impl<S: Simd> Rays<S> {
    /// Unlimited ones that start in free space.
    #[inline(always)]
    pub fn new(o: Vec3x8<S>, d: Vec3x8<S>) -> Self {
        let simd = o.x.token();
        let (none, world) = (NONE.simd_into(simd), WORLD.simd_into(simd));
        let t_max = f64::INFINITY.simd_into(simd);
        Rays { o, d, t_max, leaving: none, leaving_instance: world, target: none }
    }

    /// Keeps the lanes in `mask` and takes the other lanes from `others`.
    #[inline(always)]
    pub fn keep_where(self, mask: mask64x8<S>, others: Self) -> Self {
        Rays {
            o: self.o.keep_where(mask, others.o),
            d: self.d.keep_where(mask, others.d),
            t_max: mask.select(self.t_max, others.t_max),
            leaving: mask.select(self.leaving, others.leaving),
            leaving_instance: mask.select(self.leaving_instance, others.leaving_instance),
            target: mask.select(self.target, others.target),
        }
    }

    /// The points on the rays at distances `t`.
    #[inline(always)]
    pub fn at(&self, t: f64x8<S>) -> Vec3x8<S> {
        self.o + self.d * t
    }
}

/// The number of no element.
pub(crate) const NONE: f64 = -1.0;
/// [`ElementId::WORLD`] as a number.
pub(crate) const WORLD: f64 = ElementId::WORLD as f64;
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
    /// The instances of the elements, or [`WORLD`].
    pub instance: f64x8<S>,
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
        let (instance, emits) = (WORLD.simd_into(simd), mask64x8::splat(simd, false));
        Hits { t: none, element: none, instance, sides: [none; 3], emits }
    }

    /// The rays with a hit.
    #[inline(always)]
    pub fn is_hit(&self) -> mask64x8<S> {
        self.element.simd_ge(0.0)
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
