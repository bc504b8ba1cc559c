//! Shading: the surfaces that eight rays have hit, their texture coordinates, bumps and BSDFs.

use std::collections::HashMap;
use std::sync::Arc;

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};
use glam::{DVec2, DVec3};
use lookat_scene::{Material, MaterialKind, Primitive, Shape, Texture};

use crate::bsdf::{LobeSlots, PointLobes};
use crate::camera::Views;
use crate::frame::Frames;
use crate::number::{
    LANES, Vec2x8, Vec3x8, baseline, bits, first_lanes, groups, prefetch, set_lanes, vectorized, widen,
};
use crate::parametric::Parametrics;
use crate::ray::{ElementId, Hit, Ray};
use crate::surface::{ShapePoint, Sheet, Surface, Surfaces, Triangles};
use crate::texture::{Footprint, TexturePoint};
use crate::trace::{
    List, Tree,
    rays::{Hits, NONE, Rays},
};
use crate::traceable::Traceable;
use crate::triangle::uv::ParametricTriangles;

/// The texture coordinates of a surface, where a ray has found it.
pub(crate) fn uv(scene: &Traceable, surface: &Surface, ray: &Ray, hit: &Hit) -> DVec2 {
    baseline!(simd => {
        let none = Vec3x8::splat(simd, DVec3::ZERO);
        let (element, instance) = (NONE.simd_into(simd), ElementId::WORLD.simd_into(simd));
        let (magnitude, time) = (0.0.simd_into(simd), 0.0.simd_into(simd));
        let mut surfaces = Surfaces { p: none, n: none.narrow(), ns: none, magnitude, element, instance, time };
        surfaces.set_lane(0, surface);
        let barycentric = hit.barycentric.map(|b| b.simd_into(simd));
        let found = Found { surfaces, elements: [hit.element; LANES], barycentric };
        Coordinates::new(scene, &found, Vec3x8::splat(simd, ray.d), first_lanes(simd, 1)).flat.lane(0).uv
    })
}

/// What rays have found.
#[derive(Clone, Copy)]
pub(crate) struct Found<S: Simd> {
    pub surfaces: Surfaces<S>,
    pub elements: [ElementId; LANES],
    /// Weights of the first two vertices of triangles, u and v of curves.
    pub barycentric: Vec2x8<S>,
}

/// The change of surface points and texture coordinates from camera rays to their neighbors (PBR 10.1.1).
#[inline(never)]
fn footprints<S: Simd>(surfaces: &Surfaces<S>, flat: &Parametrics<S>, views: &Views) -> Footprint<S> {
    let (simd, p, n) = (surfaces.magnitude.token(), surfaces.p, surfaces.n.widen());
    vectorized!(simd, {
        let [right, below] = views.neighbors(simd).map(
            #[inline(always)]
            |(o, d)| o + d * (n.dot(p - o) / n.dot(d)) - p,
        );
        let is_valid = bits(simd, views.direct) & is_finite(right) & is_finite(below);
        let none = Vec3x8::splat(simd, DVec3::ZERO);
        let (right, below) = (right.keep_where(is_valid, none), below.keep_where(is_valid, none));
        let sides = sides(n);
        let (a, b) = (pick(flat.dpdu, sides), pick(flat.dpdv, sides));
        let determinant = a[0] * b[1] - a[1] * b[0];
        let duv = [right, below].map(
            #[inline(always)]
            |dp| {
                let dp = pick(dp, sides);
                let u = (b[1] * dp[0] - b[0] * dp[1]) / determinant;
                let v = (a[0] * dp[1] - a[1] * dp[0]) / determinant;
                let (is_valid, zero) = (u.is_finite() & v.is_finite(), f64x8::splat(simd, 0.0));
                [is_valid.select(u, zero), is_valid.select(v, zero)]
            },
        );
        Footprint { dp: [right, below], duv }
    })
}

/// Masks of the normals that are nearest to the x axis, and of those nearest to y if not to x.
#[inline(always)]
fn sides<S: Simd>(n: Vec3x8<S>) -> [mask64x8<S>; 2] {
    let (x, y, z) = (n.x.abs(), n.y.abs(), n.z.abs());
    [x.simd_gt(y) & x.simd_gt(z), y.simd_gt(z)]
}

/// Two of the three coordinates: those along the axes that the surfaces face least.
#[inline(always)]
fn pick<S: Simd>(v: Vec3x8<S>, [is_x, is_y]: [mask64x8<S>; 2]) -> Vec2x8<S> {
    [is_x.select(v.y, v.x), (is_x | is_y).select(v.z, v.y)]
}

#[inline(always)]
fn is_finite<S: Simd>(v: Vec3x8<S>) -> mask64x8<S> {
    v.x.is_finite() & v.y.is_finite() & v.z.is_finite()
}

/// The step in u or v where there is no neighbor, as in pbrt-v3.
const STEP: f64 = 0.0005;

/// The shading normals and dpdu of surfaces that are bent by a height above them (PBR 9.3).
#[inline(never)]
fn bumped<S: Simd>(
    at: &TexturePoint<S>,
    bump: &Texture<f64>,
    surfaces: &Surfaces<S>,
    shading: &Parametrics<S>,
    active: mask64x8<S>,
) -> (Vec3x8<S>, Vec3x8<S>) {
    let simd = active.token();
    vectorized!(simd, {
        let height = at.value(bump, active);
        let mut slopes = [f64x8::splat(simd, STEP); 2];
        for (axis, slope) in slopes.iter_mut().enumerate() {
            let mut step = *slope;
            if let Some(Footprint { duv: [x, y], .. }) = at.footprint {
                let mean = (x[axis].abs() + y[axis].abs()) * 0.5;
                step = mean.simd_eq(0.0).select(step, mean);
            }
            let along = if axis == 0 { shading.dpdu } else { shading.dpdv };
            let mut moved = TexturePoint { p: at.p + along * step, ..*at };
            moved.uv[axis] += step;
            *slope = (moved.value(bump, active) - height) / step;
        }
        let ns = surfaces.ns;
        let dpdu = shading.dpdu + ns * slopes[0] + shading.dndu * height;
        let dpdv = shading.dpdv + ns * slopes[1] + shading.dndv * height;
        let across = dpdu.cross(dpdv);
        let (bent, is_valid) = across.try_normalize();
        // A height of minus the radius leaves nothing but rounding.
        let whole = (shading.dpdu.length_squared() * shading.dpdv.length_squared()).sqrt();
        let is_valid = is_valid & across.length_squared().sqrt().simd_gt(1e-9 * whole);
        let bent = bent.face_forward(surfaces.n.widen());
        (bent.keep_where(is_valid, ns), dpdu.keep_where(is_valid, shading.dpdu))
    })
}

/// Texture coordinates: of the surfaces themselves, and as their shading normals have it.
struct Coordinates<S: Simd> {
    pub flat: Parametrics<S>,
    pub shading: Parametrics<S>,
}

impl<S: Simd> Coordinates<S> {
    /// The coordinates of the active surfaces. `d`: the directions of the rays.
    #[inline(never)]
    pub fn new(scene: &Traceable, found: &Found<S>, d: Vec3x8<S>, active: mask64x8<S>) -> Self {
        let (simd, Found { surfaces, elements, barycentric }) = (active.token(), found);
        vectorized!(simd, {
            let (mut triangles, mut ns) = (ParametricTriangles::new(simd), surfaces.ns);
            let mut others = 0;
            let time = surfaces.time;
            let is_still = |a: usize, b: usize| scene.is_still(elements[a].instance, [time[a], time[b]]);
            let is_same = |a: usize, b: usize| elements[a] == elements[b] && is_still(a, b);
            for (first, own) in groups(active.to_bitmask(), is_same) {
                let ElementId { primitive, instance, index } = elements[first];
                let primitive = scene.primitive(primitive);
                let Shape::TriangleMesh(mesh) = &primitive.shape else {
                    others |= own;
                    continue;
                };
                let own = bits(simd, own);
                if let Some(instance) = scene.instance(instance, time[first]) {
                    ns = instance.normals_to_object(ns).keep_where(own, ns);
                }
                triangles.set(own, (mesh, index as usize), primitive.reverse_orientation);
            }
            let [flat, shading] = triangles.parametrics(*barycentric, ns);
            let mut all = Coordinates { flat, shading };
            for lane in set_lanes(bits(simd, others)) {
                all.set_other(scene, found, d, lane);
            }
            let placed = (active & !widen(surfaces.instance.simd_eq(ElementId::WORLD))).to_bitmask();
            let is_same = |a: usize, b: usize| elements[a].instance == elements[b].instance && is_still(a, b);
            for (first, own) in groups(placed, is_same) {
                let Some(instance) = scene.instance(elements[first].instance, time[first]) else { continue };
                for parametrics in [&mut all.flat, &mut all.shading] {
                    let placed = instance.parametrics_to_world(parametrics);
                    *parametrics = placed.keep_where(bits(simd, own), parametrics);
                }
            }
            all
        })
    }

    /// Computes the coordinates of a non-triangle, in its object.
    #[inline(never)]
    fn set_other(&mut self, scene: &Traceable, found: &Found<S>, d: Vec3x8<S>, lane: usize) {
        let ElementId { primitive, instance, index } = found.elements[lane];
        let instance = scene.instance(instance, found.surfaces.time[lane]);
        let own = match scene.curved(primitive) {
            Some(curved) => {
                let p = found.surfaces.p.lane(lane);
                curved.parametric(instance.map_or(p, |instance| instance.to_object(p)))
            }
            None => {
                let d = instance.map_or(d.lane(lane), |instance| instance.vector_to_object(d.lane(lane)));
                scene.curves.parametric(index, d, found.barycentric.map(|b| b[lane]).into())
            }
        };
        self.flat.set_lane(lane, &own);
        self.shading.set_lane(lane, &own);
    }
}

/// Surfaces, and their shading frames.
#[derive(Clone, Copy)]
pub(crate) struct Shaded<S: Simd> {
    pub found: Found<S>,
    pub frames: Frames<f32x8<S>>,
    /// The surfaces whose materials have textures. [`Shaded::paint`] computes their lobes.
    pub is_open: mask64x8<S>,
}

impl<S: Simd> Shaded<S> {
    /// Gives surfaces that are open their lobes and shading normals. `d`: the directions of the rays. `views`: what has found the
    /// surfaces, if these are camera rays.
    #[inline(never)]
    pub fn paint<'s>(
        &mut self,
        scene: &'s Traceable,
        d: Vec3x8<S>,
        views: Option<&Views>,
        slots: &mut LobeSlots<'s, S>,
    ) {
        let (simd, Found { surfaces, elements, .. }) = (self.is_open.token(), self.found);
        vectorized!(simd, {
            let coordinates = Coordinates::new(scene, &self.found, d, self.is_open);
            let flat = &coordinates.flat;
            let material = |lane: usize| &scene.primitive(elements[lane].primitive).material;
            let is_same = |a: usize, b: usize| Arc::ptr_eq(material(a), material(b));
            let mut footprint = None;
            for (first, own) in groups(self.is_open.to_bitmask(), is_same) {
                let (material, active) = (material(first), bits(simd, own));
                let views = views.filter(|_| material.needs().footprint);
                let footprint =
                    views.map(|views| &*footprint.get_or_insert_with(|| footprints(&surfaces, flat, views)));
                let at = TexturePoint { p: surfaces.p, origin: scene.origin, uv: flat.uv, footprint };
                let (ns, dpdu) = match material.bump() {
                    Some(bump) => bumped(&at, bump, &surfaces, &coordinates.shading, active),
                    None => (surfaces.ns, coordinates.shading.dpdu),
                };
                let frames = Frames::from_zx(ns, dpdu);
                let ns = &mut self.found.surfaces.ns;
                *ns = frames.z.keep_where(active, *ns);
                self.frames = frames.narrow().keep_where(active, self.frames);
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
    /// True if any surface has no material, so that rays pass it.
    pub has_passed: bool,
    /// True if shading normals may differ from geometric ones.
    pub has_normals: bool,
    /// The lobes of materials without textures. `None` for materials with textures.
    lobes: Vec<Option<PointLobes<'s>>>,
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
        let alike = |material: &&'s Material| {
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

    /// Adds the lobes of points on primitives. Returns the points whose materials have textures, which [`Shaded::paint`]
    /// handles.
    #[inline(always)]
    pub fn lobes<S: Simd>(
        &self,
        simd: S,
        elements: &[ElementId; LANES],
        is_hit: mask64x8<S>,
        slots: &mut LobeSlots<'s, S>,
    ) -> mask64x8<S> {
        let mut is_open = 0;
        let of = |lane: usize| self.number(elements[lane].primitive);
        for (first, own) in groups(is_hit.to_bitmask(), |first, lane| of(first) == of(lane)) {
            match &self.lobes[of(first) as usize] {
                Some(lobes) => slots.add(simd, lobes, bits(simd, own)),
                None => is_open |= own,
            }
        }
        bits(simd, is_open)
    }
}

/// The forms of the elements of a list, and their names.
pub(crate) struct Sheets<'s>(Vec<(Sheet<'s>, ElementId)>);

impl<'s> Sheets<'s> {
    /// `None` where any has normals of its own.
    pub fn new(traceable: &'s Traceable, list: &List<'s>) -> Option<Self> {
        let elements = list.elements.iter().map(|element| {
            let primitive = traceable.primitive(element.id.primitive);
            Some((Sheet::new(traceable.level, element, primitive)?, element.id))
        });
        elements.collect::<Option<Vec<_>>>().map(Sheets)
    }

    /// What is at the hits. At least one ray has a hit.
    #[inline(always)]
    pub fn at<S: Simd>(&self, simd: S, (rays, hits): (&Rays<S>, &Hits<S>), is_hit: mask64x8<S>) -> Found<S> {
        let (mut rest, mut elements) = (is_hit, [ElementId::NONE; LANES]);
        let (mut surfaces, mut barycentric) = self.next(simd, rays, hits, &mut rest, &mut elements);
        // Mostly it is one element.
        while rest.any_true() {
            let others = rest;
            let (own, [b0, b1]) = self.next(simd, rays, hits, &mut rest, &mut elements);
            surfaces = own.keep_where(others, surfaces);
            barycentric = [others.select(b0, barycentric[0]), others.select(b1, barycentric[1])];
        }
        Found { surfaces, elements, barycentric }
    }

    /// The surfaces of the element that the first remaining ray has hit. Removes all rays with this element from `rest`, and
    /// records its name.
    #[inline(always)]
    fn next<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        hits: &Hits<S>,
        rest: &mut mask64x8<S>,
        elements: &mut [ElementId; LANES],
    ) -> (Surfaces<S>, Vec2x8<S>) {
        let element = hits.element[rest.to_bitmask().trailing_zeros() as usize];
        let is_same = hits.element.simd_eq(element);
        *rest &= !is_same;
        let (sheet, name) = &self.0[element as usize];
        for lane in set_lanes(is_same) {
            elements[lane] = *name;
        }
        sheet.points(simd, rays, hits)
    }
}

impl Tree<'_> {
    /// What is at the hits. At least one ray has a hit.
    #[inline(always)]
    pub fn at<S: Simd>(&self, simd: S, (rays, hits): (&Rays<S>, &Hits<S>), is_hit: mask64x8<S>) -> Found<S> {
        // What is far in memory is asked for before any of it is needed.
        let (mut elements, mut places) = ([ElementId::NONE; LANES], [Hit::NO_PLACE; LANES]);
        for lane in set_lanes(is_hit) {
            let (element, place) = self.element(hits, lane);
            (elements[lane], places[lane]) = (element, place);
            if let Shape::TriangleMesh(mesh) = &self.scene.primitive(element.primitive).shape
                && !mesh.normals().is_empty()
            {
                for vertex in mesh.triangle(element.index as usize) {
                    prefetch(&mesh.normals()[vertex], 0..1);
                }
            }
        }
        let (mut triangles, mut there) = (Triangles::default(), 0);
        for lane in set_lanes(is_hit) {
            let element = elements[lane];
            let primitive = self.scene.primitive(element.primitive);
            if let Shape::TriangleMesh(mesh) = &primitive.shape {
                let corners = self.scene.group(element.instance).triangle(places[lane]).in_order();
                triangles.set_lane(lane, primitive, (mesh, element.index as usize, corners));
                there |= 1 << lane;
            }
        }
        let ShapePoint { p, magnitude, n, ns, .. } = triangles.points(simd, hits.sides, bits(simd, there));
        let (others, placed) =
            (is_hit & !bits(simd, there), is_hit & !widen(hits.instance.simd_eq(ElementId::WORLD)));
        let Hits { element, instance, .. } = *hits;
        let time = rays.time;
        let mut surfaces = Surfaces { p, n: n.narrow(), ns, magnitude, element, instance, time };
        let mut rest = 0;
        if others.any_true() {
            rest = self.put_curved(&elements, rays.at(hits.t), others, &mut surfaces);
        }
        if placed.any_true() {
            surfaces.place_in_world(self.scene, placed & !bits(simd, rest));
        }
        if rest != 0 {
            self.put_others(rays, hits, bits(simd, rest), &mut surfaces);
        }
        Found { surfaces, elements, barycentric: [hits.sides[0], hits.sides[1]] }
    }

    /// Adds the hits of curved shapes that several rays have hit, in the spaces of their objects. Returns the other hits of non-triangles. `hits`: their
    /// points, about, in the world.
    #[inline(never)]
    fn put_curved<S: Simd>(
        &self,
        elements: &[ElementId; LANES],
        hits: Vec3x8<S>,
        others: mask64x8<S>,
        surfaces: &mut Surfaces<S>,
    ) -> u64 {
        let (simd, mut rest) = (others.token(), 0);
        vectorized!(simd, {
            for lane in set_lanes(others) {
                if let Some(curved) = self.scene.curved(elements[lane].primitive) {
                    curved.prefetch_place();
                }
            }
            let time = surfaces.time;
            let is_still = |a: usize, b: usize| self.scene.is_still(elements[a].instance, [time[a], time[b]]);
            let is_same = |a: usize, b: usize| elements[a] == elements[b] && is_still(a, b);
            for (first, own) in groups(others.to_bitmask(), is_same) {
                let ElementId { instance, primitive, .. } = elements[first];
                let curved = self.scene.curved(primitive).filter(|_| own.count_ones() > 1);
                let Some(curved) = curved else {
                    rest |= own;
                    continue;
                };
                let instance = self.scene.instance(instance, time[first]);
                let p = instance.map_or(hits, |instance| instance.points_to_object(hits));
                let (p, outward) = curved.project_all(p);
                let Primitive { reverse_orientation, mirrored, .. } = self.scene.primitive(primitive);
                let n = if reverse_orientation != mirrored { -outward } else { outward };
                let magnitude = curved.magnitude().simd_into(simd);
                let found = Surfaces { p, n: n.narrow(), ns: n, magnitude, ..*surfaces };
                *surfaces = found.keep_where(bits(simd, own), *surfaces);
            }
        });
        rest
    }

    /// Adds the hits of non-triangles one by one.
    #[inline(never)]
    fn put_others<S: Simd>(
        &self,
        rays: &Rays<S>,
        hits: &Hits<S>,
        others: mask64x8<S>,
        surfaces: &mut Surfaces<S>,
    ) {
        for lane in set_lanes(others) {
            surfaces
                .set_lane(lane, &Surface::new(self.scene, &self.ray(&rays.one(lane)), &self.hit(hits, lane)));
        }
    }
}
