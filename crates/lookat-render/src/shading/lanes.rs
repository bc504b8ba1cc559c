//! Surfaces where rays have hit them side by side, and their lobes.

use fearless_simd::{Simd, mask64x8, prelude::*};
use lookat_scene::{Material, MaterialKind, Primitive, Shape};

use super::{bsdf, point};
use crate::bsdf::lanes::{Coat, Coats};
use crate::bsdf::{Bsdf, Lobes, lambert};
use crate::camera::CameraRay;
use crate::frame::lanes::Frames;
use crate::lanes::{LANES, bits, those};
use crate::prefetch::prefetch;
use crate::ray::{ElementId, Hit, Ray};
use crate::surface::Surface;
use crate::surface::lanes::{Sheet, Surfaces, Triangles, Turned};
use crate::texture::TexturePoint;
use crate::trace::lanes::{Hits, List, Rays, Tree};
use crate::traceable::Traceable;

/// Surfaces, and how they scatter light.
#[derive(Clone, Copy)]
pub(crate) struct Shaded<S: Simd> {
    pub surfaces: Surfaces<S>,
    pub frames: Frames<S>,
    pub coats: Coats<S>,
    /// Where the lobes have to be asked for one by one.
    pub is_open: mask64x8<S>,
}

impl<S: Simd> Shaded<S> {
    /// Asks for the lobes of one of them, as `shading::bsdf` does; what it scatters by, if these are others than [`Coats`] has.
    #[inline(never)]
    pub fn paint<'l>(
        &mut self,
        simd: S,
        lane: usize,
        scene: &Traceable,
        (ray, hit): (&Ray, &Hit),
        camera_ray: Option<&CameraRay>,
        lobes: &'l mut Lobes,
    ) -> Option<Bsdf<'l>> {
        let (surface, wo) = (Surface::new(scene, ray, hit), -ray.d);
        let material = surface.primitive.material.kind();
        if !matches!(material, MaterialKind::Matte(_) | MaterialKind::Plastic(_)) {
            return Some(bsdf(scene, &surface, wo, camera_ray, lobes));
        }
        let (at, frame) = point(scene, &surface, wo, camera_ray);
        self.frames.put(lane, &frame);
        if let Some(coat) = Coat::at(material, &at) {
            self.coats = Coats::splat(simd, &coat).or(bits(simd, 1 << lane), self.coats);
        }
        None
    }
}

/// That of a material everywhere; `None` of one with textures or other lobes.
fn coat(material: &Material) -> Option<Coat> {
    if material.needs().coordinates { None } else { Coat::at(material.kind(), &TexturePoint::default()) }
}

/// What elements of a list are made of.
pub(crate) struct ListShading<'s> {
    elements: Vec<(Sheet<'s>, Option<Coat>)>,
    pub is_lambert: bool,
    pub has_textures: bool,
    pub has_bumps: bool,
}

impl<'s> ListShading<'s> {
    /// `None` where any has normals of its own, or no material.
    pub fn new(traceable: &'s Traceable, list: &List<'s>) -> Option<Self> {
        if traceable.has_passed() {
            return None;
        }
        let primitives = || list.elements.iter().map(|element| traceable.primitive(element.id.primitive));
        let materials = || primitives().map(|primitive| &*primitive.material);
        let elements = list.elements.iter().map(|element| {
            let primitive = traceable.primitive(element.id.primitive);
            let sheet = Sheet::new(element, primitive)?;
            Some((sheet, coat(&primitive.material)))
        });
        Some(ListShading {
            elements: elements.collect::<Option<Vec<_>>>()?,
            is_lambert: materials().all(|material| lambert(material.kind()).is_some()),
            has_textures: materials().any(|material| material.needs().coordinates),
            has_bumps: materials().any(|material| material.bump().is_some()),
        })
    }

    /// Where the rays have hit something, and the lobes there; one of them has.
    #[inline(always)]
    pub fn at<S: Simd>(&self, simd: S, rays: &Rays<S>, hits: &Hits<S>, active: mask64x8<S>) -> Shaded<S> {
        let mut rest = hits.is_hit() & active;
        let (mut surfaces, mut coats, mut is_open) = self.next(simd, rays, hits, &mut rest);
        // Mostly it is one element.
        while rest.any_true() {
            let others = rest;
            let own = self.next(simd, rays, hits, &mut rest);
            surfaces = own.0.or(others, surfaces);
            coats = own.1.or(others, coats);
            is_open |= own.2;
        }
        Shaded { surfaces, frames: Frames::from_z(surfaces.ns), coats, is_open }
    }

    /// The same of the element that the first of the rest has hit, and which of all are open there. Takes all that have hit it
    /// from the rest.
    #[inline(always)]
    fn next<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        hits: &Hits<S>,
        rest: &mut mask64x8<S>,
    ) -> (Surfaces<S>, Coats<S>, mask64x8<S>) {
        let element = hits.element[rest.to_bitmask().trailing_zeros() as usize];
        let is_same = hits.element.simd_eq(element);
        *rest &= !is_same;
        let (sheet, coat) = &self.elements[element as usize];
        let is_open = if coat.is_none() { is_same } else { bits(simd, 0) };
        (sheet.points(simd, rays, hits), Coats::splat(simd, &coat.unwrap_or(Coat::NONE)), is_open)
    }
}

/// What the primitives of a world with a tree are made of.
pub(crate) struct TreeShading<'s> {
    scene: &'s Traceable,
    primitives: Vec<(Turned, Option<Coat>)>,
    pub is_lambert: bool,
    pub has_textures: bool,
    /// Whether any surface has no material.
    pub has_passed: bool,
    /// Whether shading normals may differ from geometric ones.
    pub has_normals: bool,
}

impl<'s> TreeShading<'s> {
    pub fn new(traceable: &'s Traceable) -> Self {
        let materials = || traceable.primitives().map(|primitive| &*primitive.material);
        let of = |primitive: &Primitive| (Turned::new(primitive), coat(&primitive.material));
        let has_normals =
            |shape: &Shape| matches!(shape, Shape::TriangleMesh(mesh) if !mesh.normals().is_empty());
        let is_bent =
            |primitive: &Primitive| primitive.material.bump().is_some() || has_normals(&primitive.shape);
        TreeShading {
            scene: traceable,
            primitives: traceable.primitives().map(of).collect(),
            is_lambert: materials().all(|material| lambert(material.kind()).is_some()),
            has_textures: materials().any(|material| material.needs().coordinates),
            has_passed: traceable.has_passed(),
            has_normals: traceable.primitives().any(is_bent),
        }
    }

    /// Where the rays have hit something, and the lobes there; one of them has.
    #[inline(always)]
    pub fn at<S: Simd>(
        &self,
        simd: S,
        tree: &Tree,
        rays: &Rays<S>,
        hits: &Hits<S>,
        active: mask64x8<S>,
    ) -> Shaded<S> {
        let is_hit = hits.is_hit() & active;
        // What is far in memory is asked for before any of it is needed.
        let mut elements = [(ElementId::NONE, Hit::NO_PLACE); LANES];
        for lane in those(is_hit) {
            elements[lane] = tree.element(hits, lane);
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
        let mut triangles = Triangles::new();
        for lane in those(is_hit) {
            let (element, place) = elements[lane];
            primitives[lane] = element.primitive;
            match &self.scene.primitive(element.primitive).shape {
                Shape::TriangleMesh(mesh) if element.instance == ElementId::WORLD => {
                    let corners = self.scene.world.triangle(place).in_order();
                    let (turned, _) = self.primitives[element.primitive as usize];
                    triangles.put(lane, corners, mesh, element.index as usize, turned);
                    there |= 1 << lane;
                }
                _ => {}
            }
        }
        let points = triangles.points(simd, hits.sides, bits(simd, there));
        let others = is_hit & !bits(simd, there);
        let mut surfaces = Surfaces {
            p: points.p,
            n: points.n,
            ns: points.ns,
            magnitude: points.magnitude,
            element: hits.element,
            instance: hits.instance,
        };
        if others.any_true() {
            self.put_others(tree, rays, hits, others, &mut surfaces);
        }
        let (coats, is_open) = self.coats(simd, &primitives, is_hit);
        Shaded { surfaces, frames: Frames::from_z(surfaces.ns), coats, is_open }
    }

    /// Those that are no triangles.
    #[inline(never)]
    fn put_others<S: Simd>(
        &self,
        tree: &Tree,
        rays: &Rays<S>,
        hits: &Hits<S>,
        others: mask64x8<S>,
        surfaces: &mut Surfaces<S>,
    ) {
        for lane in those(others) {
            surfaces.put(lane, &Surface::new(self.scene, &tree.ray(rays, lane), &tree.hit(hits, lane)));
        }
    }

    /// The lobes, and where they have to be asked for one by one.
    #[inline(always)]
    fn coats<S: Simd>(
        &self,
        simd: S,
        primitives: &[u32; LANES],
        is_hit: mask64x8<S>,
    ) -> (Coats<S>, mask64x8<S>) {
        let mut coats = Coats::splat(simd, &Coat::NONE);
        let (mut rest, mut is_open) = (is_hit.to_bitmask(), 0);
        while rest != 0 {
            let first = primitives[rest.trailing_zeros() as usize];
            let mut is_same = 0;
            for (lane, primitive) in primitives.iter().enumerate() {
                is_same |= u64::from(*primitive == first) << lane;
            }
            match &self.primitives[first as usize].1 {
                Some(coat) => coats = Coats::splat(simd, coat).or(bits(simd, is_same), coats),
                None => is_open |= is_same,
            }
            rest &= !is_same;
        }
        (coats, bits(simd, is_open))
    }
}
