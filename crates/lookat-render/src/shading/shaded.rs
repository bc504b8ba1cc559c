//! Surfaces where rays have hit them side by side, and their lobes.

use std::collections::HashMap;
use std::sync::Arc;

use fearless_simd::{Simd, f32x8, mask64x8, prelude::*};
use lookat_scene::{Material, MaterialKind, Primitive, Shape};

use super::{Found, points};
use crate::bsdf::{PointLobes, Slots};
use crate::camera::views::Views;
use crate::frame::Frames;
use crate::number::{LANES, bits, groups, those, vectorized};
use crate::prefetch::prefetch;
use crate::ray::{ElementId, Hit};
use crate::surface::Surface;
use crate::surface::points::{Point, Sheet, Surfaces, Triangles};
use crate::trace::rays::{Hits, Rays, WORLD};
use crate::trace::{List, Tree};
use crate::traceable::Traceable;

/// Surfaces, and their shading frames.
#[derive(Clone, Copy)]
pub(crate) struct Shaded<S: Simd> {
    pub surfaces: Surfaces<S>,
    pub frames: Frames<f32x8<S>>,
    /// Those whose materials have textures: their lobes have to be asked for.
    pub is_open: mask64x8<S>,
}

impl<S: Simd> Shaded<S> {
    /// Gives surfaces that are open their lobes and shading normals; `found` has the rays and hits of these. `views`: what has
    /// found them, if these are camera rays.
    #[inline(never)]
    pub fn paint(
        &mut self,
        scene: &Traceable,
        found: &[Option<Found>; LANES],
        views: Option<&Views>,
        slots: &mut Slots<S>,
    ) {
        let simd = self.is_open.token();
        vectorized!(simd, {
            let material =
                |lane: usize| found[lane].map(|(_, hit)| &scene.primitive(hit.element.primitive).material);
            let is_same = |first: usize, lane: usize| matches!((material(first), material(lane)), (Some(a), Some(b)) if Arc::ptr_eq(a, b));
            for (first, own) in groups(self.is_open.to_bitmask(), is_same) {
                let Some(material) = material(first) else { continue };
                let active = bits(simd, own);
                let (at, frames) = points((scene, material), &self.surfaces, found, views, active);
                self.surfaces.ns = frames.z.or(active, self.surfaces.ns);
                self.frames = frames.narrow().or(active, self.frames);
                slots.build(material.kind(), &at, active);
            }
        })
    }
}

/// The materials of a scene.
pub(crate) struct Materials<'s> {
    /// All, in the order of the first primitives that have them.
    pub all: Vec<&'s Material>,
    pub has_textures: bool,
    /// Whether any surface has none, so that rays pass it.
    pub has_passed: bool,
    /// Whether shading normals may differ from geometric ones.
    pub has_normals: bool,
    /// Their lobes where these are everywhere alike; `None` of those with textures.
    lobes: Vec<Option<PointLobes>>,
    /// The material of each primitive.
    of_primitive: Vec<u32>,
}

impl<'s> Materials<'s> {
    pub fn new(traceable: &'s Traceable) -> Self {
        let (mut known, mut all) = (HashMap::new(), Vec::new());
        let number = |primitive: &'s Primitive| {
            *known.entry(Arc::as_ptr(&primitive.material)).or_insert_with(|| {
                all.push(&*primitive.material);
                all.len() as u32 - 1
            })
        };
        let of_primitive = traceable.primitives().map(number).collect();
        let alike = |material: &&Material| {
            let is_alike = !material.needs().coordinates;
            is_alike.then(|| PointLobes::new(material.kind()))
        };
        let has_normals = |primitive: &Primitive| matches!(&primitive.shape, Shape::TriangleMesh(mesh) if !mesh.normals().is_empty());
        Materials {
            has_textures: all.iter().any(|material| material.needs().coordinates),
            has_passed: all.iter().any(|material| matches!(material.kind(), MaterialKind::None)),
            has_normals: all.iter().any(|material| material.bump().is_some())
                || traceable.primitives().any(has_normals),
            lobes: all.iter().map(alike).collect(),
            all,
            of_primitive,
        }
    }

    /// The number of the material of a primitive.
    pub fn number(&self, primitive: u32) -> u32 {
        self.of_primitive[primitive as usize]
    }

    /// The lobes of points on primitives, and where they have to be asked for.
    #[inline(always)]
    pub fn lobes<S: Simd>(
        &self,
        simd: S,
        primitives: &[u32; LANES],
        is_hit: mask64x8<S>,
        slots: &mut Slots<S>,
    ) -> mask64x8<S> {
        let mut is_open = 0;
        let of = |lane: usize| self.number(primitives[lane]);
        for (first, own) in groups(is_hit.to_bitmask(), |first, lane| of(first) == of(lane)) {
            match &self.lobes[of(first) as usize] {
                Some(lobes) => slots.add(simd, lobes, bits(simd, own)),
                None => is_open |= own,
            }
        }
        bits(simd, is_open)
    }
}

/// The forms of the elements of a list, and the primitives that they are of.
pub(crate) struct Sheets<'s>(Vec<(Sheet<'s>, u32)>);

impl<'s> Sheets<'s> {
    /// `None` where any has normals of its own.
    pub fn new(traceable: &'s Traceable, list: &List<'s>) -> Option<Self> {
        let elements = list.elements.iter().map(|element| {
            let number = element.id.primitive;
            Some((Sheet::new(traceable.level, element, traceable.primitive(number))?, number))
        });
        elements.collect::<Option<Vec<_>>>().map(Sheets)
    }

    /// Where rays have hit something, and the primitives there; one of them has.
    #[inline(always)]
    pub fn at<S: Simd>(
        &self,
        simd: S,
        (rays, hits): (&Rays<S>, &Hits<S>),
        is_hit: mask64x8<S>,
    ) -> (Surfaces<S>, [u32; LANES]) {
        let (mut rest, mut primitives) = (is_hit, [0; LANES]);
        let mut surfaces = self.next(simd, rays, hits, &mut rest, &mut primitives);
        // Mostly it is one element.
        while rest.any_true() {
            let others = rest;
            surfaces = self.next(simd, rays, hits, &mut rest, &mut primitives).or(others, surfaces);
        }
        (surfaces, primitives)
    }

    /// The same of the element that the first of the rest has hit. Takes all that have hit it from the rest, and notes its primitive.
    #[inline(always)]
    fn next<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        hits: &Hits<S>,
        rest: &mut mask64x8<S>,
        primitives: &mut [u32; LANES],
    ) -> Surfaces<S> {
        let element = hits.element[rest.to_bitmask().trailing_zeros() as usize];
        let is_same = hits.element.simd_eq(element);
        *rest &= !is_same;
        let (sheet, primitive) = &self.0[element as usize];
        for lane in those(is_same) {
            primitives[lane] = *primitive;
        }
        sheet.points(simd, rays, hits)
    }
}

impl Tree<'_> {
    /// Where rays have hit something, and the primitives there; one of them has.
    #[inline(always)]
    pub fn at<S: Simd>(
        &self,
        simd: S,
        (rays, hits): (&Rays<S>, &Hits<S>),
        is_hit: mask64x8<S>,
    ) -> (Surfaces<S>, [u32; LANES]) {
        // What is far in memory is asked for before any of it is needed.
        let mut elements = [(ElementId::NONE, Hit::NO_PLACE); LANES];
        for lane in those(is_hit) {
            elements[lane] = self.element(hits, lane);
            let (element, _) = elements[lane];
            if let Shape::TriangleMesh(mesh) = &self.scene.primitive(element.primitive).shape
                && !mesh.normals().is_empty()
            {
                for vertex in mesh.triangle(element.index as usize) {
                    prefetch(&mesh.normals()[vertex], 0..1);
                }
            }
        }
        let (mut primitives, mut there) = ([0; LANES], 0);
        let mut triangles = Triangles::default();
        for lane in those(is_hit) {
            let (element, place) = elements[lane];
            primitives[lane] = element.primitive;
            let primitive = self.scene.primitive(element.primitive);
            if let Shape::TriangleMesh(mesh) = &primitive.shape {
                let corners = self.scene.group(element.instance).triangle(place).in_order();
                triangles.put(lane, primitive, (mesh, element.index as usize, corners));
                there |= 1 << lane;
            }
        }
        let Point { p, magnitude, n, ns, .. } = triangles.points(simd, hits.sides, bits(simd, there));
        let (others, placed) = (is_hit & !bits(simd, there), is_hit & !hits.instance.simd_eq(WORLD));
        let Hits { element, instance, .. } = *hits;
        let mut surfaces = Surfaces { p, n, ns, magnitude, element, instance };
        if placed.any_true() {
            surfaces.place_in_world(self.scene, placed);
        }
        if others.any_true() {
            self.put_others(rays, hits, others, &mut surfaces);
        }
        (surfaces, primitives)
    }

    /// Those that are no triangles.
    #[inline(never)]
    fn put_others<S: Simd>(
        &self,
        rays: &Rays<S>,
        hits: &Hits<S>,
        others: mask64x8<S>,
        surfaces: &mut Surfaces<S>,
    ) {
        for lane in those(others) {
            surfaces.put(lane, &Surface::new(self.scene, &self.ray(rays, lane), &self.hit(hits, lane)));
        }
    }
}
