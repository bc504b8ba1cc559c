//! Worlds in which rays of samples are traced side by side, and counted.

use std::array::from_fn;

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};

use crate::camera::lanes::Views;
use crate::integrator::Tracer;
use crate::lanes::{LANES, bits, count, those};
use crate::ray::{Hit, Ray};
use crate::shading::lanes::{ListShading, Shaded, TreeShading};
use crate::surface::Surface;
use crate::trace::BUNDLE;
use crate::trace::lanes::{Found, Hits, List, Rays, Tree};
use crate::traceable::Traceable;

/// A world, and what it is made of.
pub(in crate::integrator) enum World<'s> {
    List(List<'s>, ListShading<'s>),
    Tree(Tree<'s>, TreeShading<'s>),
}

impl<'s> World<'s> {
    /// `None` of one that has copies of objects, or holes, or other than plain materials.
    pub fn new(traceable: &'s Traceable) -> Option<Self> {
        let small = || {
            let list = List::new(traceable)?;
            let shading = ListShading::new(traceable, &list)?;
            Some(World::List(list, shading))
        };
        let tree = || Some(World::Tree(Tree::new(traceable)?, TreeShading::new(traceable)?));
        small().or_else(tree)
    }

    /// Whether all materials are diffuse and nothing else.
    pub fn is_lambert(&self) -> bool {
        match self {
            World::List(_, shading) => shading.is_lambert,
            World::Tree(_, shading) => shading.is_lambert,
        }
    }

    /// Whether any material has textures.
    pub fn has_textures(&self) -> bool {
        match self {
            World::List(_, shading) => shading.has_textures,
            World::Tree(_, shading) => shading.has_textures,
        }
    }

    /// Whether shading normals may differ from geometric ones.
    pub fn has_normals(&self) -> bool {
        match self {
            World::List(_, shading) => shading.has_bumps,
            World::Tree(_, shading) => shading.has_normals,
        }
    }

    /// The nearest hits of the rays that are active. `together`: neighbors mostly meet the same.
    #[inline(always)]
    pub fn nearest<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        rays: &Rays<S>,
        active: mask64x8<S>,
        together: bool,
    ) -> Hits<S> {
        match self {
            World::List(list, _) => {
                tracer.rays += count(active);
                list.nearest(simd, rays, active)
            }
            World::Tree(tree, _) => {
                let mut found = Found::NOTHING;
                if together && active.all_true() && tracer.bundles((LANES / BUNDLE) as u32) {
                    search_bundles(tree, tracer, rays, &mut found);
                } else {
                    tracer.forms.put(simd, rays, active);
                    search(tree, tracer, rays, active, &mut found);
                }
                let [b0, b1]: [f64x8<S>; 2] =
                    [found.weights[0].simd_into(simd), found.weights[1].simd_into(simd)];
                Hits {
                    t: found.t.simd_into(simd),
                    element: found.element.simd_into(simd),
                    sides: [b0, b1, 1.0 - b0 - b1],
                    emits: bits(simd, found.emits),
                }
            }
        }
    }

    /// Which of the rays that are active meet anything but their targets.
    #[inline(always)]
    pub fn met<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        rays: &Rays<S>,
        active: mask64x8<S>,
    ) -> mask64x8<S> {
        match self {
            World::List(list, _) => {
                tracer.rays += count(active);
                list.met(simd, rays, active)
            }
            World::Tree(tree, _) => {
                tracer.forms.put(simd, rays, active);
                bits(simd, occluded(tree, tracer, rays, active))
            }
        }
    }

    /// Where the rays have hit something, and the lobes there; one of them has. `views`: what has found it, if these are camera
    /// rays.
    #[inline(always)]
    pub fn shaded<S: Simd>(
        &self,
        simd: S,
        tracer: &Tracer,
        (rays, hits): (&Rays<S>, &Hits<S>),
        views: Option<&Views>,
        active: mask64x8<S>,
    ) -> Shaded<S> {
        let mut shaded = match self {
            World::List(_, shading) => shading.at(simd, rays, hits, active),
            World::Tree(tree, shading) => shading.at(simd, tree, rays, hits, active),
        };
        for lane in those(shaded.is_textured & active) {
            if let (ray, Some(hit)) = self.one(rays, hits, lane) {
                let camera_ray = views.map(|views| views.ray(lane));
                shaded.paint(simd, lane, tracer.scene, (&ray, &hit), camera_ray.as_ref());
            }
        }
        shaded
    }

    /// One of the rays with what it has hit.
    pub fn one<S: Simd>(&self, rays: &Rays<S>, hits: &Hits<S>, lane: usize) -> (Ray, Option<Hit>) {
        let is_hit = hits.element[lane] >= 0.0;
        match self {
            World::List(list, _) => {
                let ray = Ray::new(rays.o.lane(lane), rays.d.lane(lane));
                (ray, is_hit.then(|| list.hit(hits, lane)))
            }
            World::Tree(tree, _) => (tree.ray(rays, lane), is_hit.then(|| tree.hit(hits, lane))),
        }
    }

    /// The surface that one of the rays has hit.
    pub fn surface<S: Simd>(
        &self,
        tracer: &Tracer<'s>,
        rays: &Rays<S>,
        hits: &Hits<S>,
        lane: usize,
    ) -> Option<Surface<'s>> {
        let (ray, hit) = self.one(rays, hits, lane);
        hit.map(|hit| tracer.surface(&ray, &hit))
    }
}

/// Traces rays down a tree together.
#[inline(never)]
fn search_bundles<S: Simd>(tree: &Tree, tracer: &mut Tracer, rays: &Rays<S>, found: &mut Found) {
    for first in (0..LANES).step_by(BUNDLE) {
        let bundle: [Ray; BUNDLE] = from_fn(|k| tree.ray(rays, first + k));
        for (k, hit) in tracer.nearest_of(&bundle).iter().enumerate() {
            if let Some(hit) = hit {
                found.put(first + k, hit, tracer.emits(hit));
            }
        }
    }
}

/// Traces rays down a tree one by one.
#[inline(never)]
fn search<S: Simd>(tree: &Tree, tracer: &mut Tracer, rays: &Rays<S>, active: mask64x8<S>, found: &mut Found) {
    let mut hit = None;
    for lane in those(active) {
        tracer.find_formed(&tree.ray(rays, lane), lane, &mut hit);
        if let Some(hit) = &hit {
            found.put(lane, hit, tracer.emits(hit));
        }
    }
}

/// The rays that are stopped on their way, as bits.
#[inline(never)]
fn occluded<S: Simd>(tree: &Tree, tracer: &mut Tracer, rays: &Rays<S>, active: mask64x8<S>) -> u64 {
    let mut occluded = 0;
    for lane in those(active) {
        occluded |= u64::from(tracer.occluded_formed(&tree.ray(rays, lane), lane)) << lane;
    }
    occluded
}
