//! Worlds in which rays are traced one by one, down their tree.

use fearless_simd::Simd;

use super::{Hits, INDICES, MOST_PRIMITIVES, NONE, Rays, labeled};
use crate::lanes::LANES;
use crate::ray::{ElementId, Hit, Ray};
use crate::traceable::{Other, Traceable};

/// A world with its tree. Its elements are numbered: triangles by their place, others from 2^32 on, by their names.
pub(crate) struct Tree<'s> {
    pub scene: &'s Traceable,
}

/// Hits of rays one by one, as numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Found {
    pub t: [f64; LANES],
    pub element: [f64; LANES],
    pub weights: [[f64; LANES]; 2],
    /// Which of them emit, as bits.
    pub emits: u64,
}

impl Found {
    pub const NOTHING: Found =
        Found { t: [0.0; LANES], element: [NONE; LANES], weights: [[0.0; LANES]; 2], emits: 0 };

    #[inline(always)]
    pub fn put(&mut self, lane: usize, hit: &Hit, emits: bool) {
        self.emits |= u64::from(emits) << lane;
        self.t[lane] = hit.t;
        self.element[lane] = match hit.place {
            Hit::NO_PLACE => INDICES + super::label(hit.element),
            place => f64::from(place),
        };
        [self.weights[0][lane], self.weights[1][lane]] = hit.barycentric;
    }
}

impl<'s> Tree<'s> {
    /// `None` of worlds with holes or copies of objects, and of too many primitives.
    pub fn new(scene: &'s Traceable) -> Option<Self> {
        let has_instances = scene.world.others.iter().any(|other| matches!(other, Other::Instance { .. }));
        let are_few = scene.primitives().len() <= MOST_PRIMITIVES;
        (!has_instances && !scene.has_cutouts && are_few).then_some(Tree { scene })
    }

    /// One of the rays.
    #[inline(always)]
    pub fn ray<S: Simd>(&self, rays: &Rays<S>, lane: usize) -> Ray {
        let (leaving, leaving_place) = self.left(rays.leaving[lane]);
        let target = labeled(rays.target[lane]);
        Ray {
            t_max: rays.t_max[lane],
            leaving,
            leaving_place,
            target,
            ..Ray::new(rays.o.lane(lane), rays.d.lane(lane))
        }
    }

    /// The name and the place of an element; of triangles, the place is enough.
    #[inline(always)]
    fn left(&self, number: f64) -> (ElementId, u32) {
        match number {
            number if number < 0.0 => (ElementId::NONE, Hit::NO_PLACE),
            number if number < INDICES => (ElementId::NONE, number as u32),
            number => (labeled(number - INDICES), Hit::NO_PLACE),
        }
    }

    /// The place of a triangle, see [`Hit::place`].
    #[inline(always)]
    pub fn place(&self, number: f64) -> u32 {
        self.left(number).1
    }

    /// The name of an element.
    #[inline(always)]
    pub fn element(&self, number: f64) -> ElementId {
        match number < INDICES {
            true => self.scene.world.triangle(number as u32).element(ElementId::WORLD),
            false => labeled(number - INDICES),
        }
    }

    /// One of the hits.
    pub fn hit<S: Simd>(&self, hits: &Hits<S>, lane: usize) -> Hit {
        Hit {
            t: hits.t[lane],
            element: self.element(hits.element[lane]),
            barycentric: [hits.sides[0][lane], hits.sides[1][lane]],
            place: self.place(hits.element[lane]),
        }
    }
}
