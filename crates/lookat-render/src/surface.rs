//! Points of surfaces: one that a ray has hit, or eight side by side.

use fearless_simd::{Level, Simd, f64x8, mask64x8, prelude::*, u32x8};
use glam::{DVec3, Vec3};
use lookat_scene::{Mesh, Primitive, Shape};

use crate::curved::Curved;
use crate::frame::flipped;
use crate::number::{
    LANES, Vec2x8, Vec3fx8, Vec3x8, bits, groups, set_lanes, side_by_side, three, vectorized,
};
use crate::ray::{ElementId, Hit, Ray};
use crate::trace::{
    Element, ListedShape,
    rays::{Hits, Rays},
};
use crate::traceable::Traceable;
use crate::triangle::{Triangle, sheared::BoxedTriangle};

/// A point of a surface, relative to [`Prepared::origin`](crate::Prepared::origin). Normals have length one.
#[derive(Debug, Clone, Copy)]
pub struct Surface<'s> {
    /// Position.
    pub p: DVec3,
    /// The largest coordinate that its computation went through: its rounding is in proportion.
    pub magnitude: f64,
    /// The geometric normal, on the side that pbrt-v3 gives it.
    pub n: DVec3,
    /// The shading normal.
    pub ns: DVec3,
    /// The side that emits light.
    pub emitting: DVec3,
    /// The element that was hit.
    pub element: ElementId,
    /// The index of the triangle in its group: see [`Hit::place`]. [`Hit::NO_PLACE`] for points sampled on lights, which no
    /// ray leaves.
    pub place: u32,
    /// The shape with its material.
    pub primitive: &'s Primitive,
    /// See [`Ray::time`].
    pub time: f64,
}

impl<'s> Surface<'s> {
    /// The surface at a hit of `ray`.
    pub(crate) fn new(scene: &'s Traceable, ray: &Ray, hit: &Hit) -> Self {
        let Hit { t, element, place, .. } = *hit;
        let primitive = scene.primitive(element.primitive);
        let instance = scene.instance(element.instance, ray.time);
        let instance = instance.as_deref();
        let turned = |n| flipped(n, primitive.reverse_orientation != primitive.mirrored);
        let point = match (&primitive.shape, scene.curved(element.primitive)) {
            (Shape::TriangleMesh(mesh), _) => {
                let [b0, b1] = hit.barycentric;
                let corners = scene.group(element.instance).triangle(place).in_order();
                let triangle = (&**mesh, element.index as usize, corners);
                on_triangle(scene.level, primitive, triangle, [b0, b1, 1.0 - b0 - b1])
            }
            (_, Some(shape)) => {
                let p = instance.map_or(ray.at(t), |instance| instance.to_object(ray.at(t)));
                // The hit is as exact as its distance; the shape is exacter.
                let (p, outward) = shape.project(p);
                let (n, emitting) = (turned(outward), flipped(outward, primitive.reverse_orientation));
                ShapePoint { p, magnitude: shape.magnitude(), n, ns: n, emitting }
            }
            (_, None) => {
                let local = instance.map_or(*ray, |instance| instance.ray(ray, t));
                let n = turned(scene.curves.normal(element.index, &local, hit.barycentric.into()));
                let (p, magnitude) = (local.at(t), local.at(t).abs().max(local.o.abs()).max_element());
                // It turns with the ray, so it has no side that is dark.
                ShapePoint { p, magnitude, n, ns: n, emitting: -local.d.normalize_or(DVec3::Z) }
            }
        };
        let ShapePoint { mut p, mut magnitude, .. } = point;
        let [mut n, mut ns, mut emitting] = [point.n, point.ns, point.emitting];
        if let Some(instance) = instance {
            (p, magnitude) = (instance.to_world(p), instance.magnitude(magnitude));
            [n, ns, emitting] = [n, ns, emitting].map(|n| instance.normal_to_world(n));
        }
        Surface { p, magnitude, n, ns, emitting, element, place, primitive, time: ray.time }
    }

    /// The radiance that the surface emits towards `wo`.
    pub fn le(&self, wo: DVec3) -> Vec3 {
        match &self.primitive.emission {
            Some(emission) if emission.two_sided || self.emitting.dot(wo) > 0.0 => emission.radiance,
            _ => Vec3::ZERO,
        }
    }

    /// The surface with its normal turned to the side that a ray in direction `d` comes from.
    pub fn facing(self, d: DVec3) -> Self {
        Surface { n: flipped(self.n, self.n.dot(d) > 0.0), ..self }
    }

    /// A ray that leaves the surface in direction `d`, unlimited.
    ///
    /// The element itself is not met again. Others that touch it here are told from it by an offset of 2^-40 of the
    /// coordinates, thousands of times their rounding and less than any gap in a scene.
    pub fn spawn_ray(&self, d: DVec3) -> Ray {
        let offset = self.n * (self.magnitude * OFFSET).copysign(self.n.dot(d));
        let (leaving, leaving_place, time) = (self.element, self.place, self.time);
        Ray { leaving, leaving_place, time, ..Ray::new(self.p + offset, d) }
    }
}

/// The direction of the cross product of two edges, of length one.
fn direction_across(e1: DVec3, e2: DVec3) -> DVec3 {
    let product = e1.cross(e2);
    let squared = product.length_squared();
    if squared > 1e-200 && squared < 1e200 {
        return product * squared.sqrt().recip();
    }
    // Scaled, so that the product of edges of any length neither vanishes nor overflows.
    let size = e1.abs().max_element().max(e2.abs().max_element());
    (e1 / size).cross(e2 / size).normalize_or(DVec3::Z)
}

/// 2^-40.
const OFFSET: f64 = 1.0 / (1_u64 << 40) as f64;

/// Eight points of surfaces, relative to the origin. The fields are those of [`Surface`].
#[derive(Clone, Copy)]
pub(crate) struct Surfaces<S: Simd> {
    pub p: Vec3x8<S>,
    pub n: Vec3fx8<S>,
    /// In `f64` for mirrors and glass: see [`BsdfSample::wi`](crate::bsdf::BsdfSample::wi).
    pub ns: Vec3x8<S>,
    pub magnitude: f64x8<S>,
    /// The numbers of the elements in their groups.
    pub element: f64x8<S>,
    /// The instances of the elements.
    pub instance: u32x8<S>,
    pub time: f64x8<S>,
}

impl<S: Simd> Surfaces<S> {
    /// Keeps the lanes in `mask` and takes the other lanes from `others`.
    #[inline(always)]
    pub fn keep_where(self, mask: mask64x8<S>, others: Self) -> Self {
        Surfaces {
            p: self.p.keep_where(mask, others.p),
            n: self.n.keep_where_wide(mask, others.n),
            ns: self.ns.keep_where(mask, others.ns),
            magnitude: mask.select(self.magnitude, others.magnitude),
            // Of the same hits.
            element: self.element,
            instance: self.instance,
            time: self.time,
        }
    }

    /// Rays that leave the surfaces in directions `d`: see [`Surface::spawn_ray`].
    #[inline(always)]
    pub fn spawn_ray(&self, d: Vec3x8<S>) -> Rays<S> {
        let n = self.n.widen();
        let offset = n * (self.magnitude * OFFSET).copysign(n.dot(d));
        let (leaving, leaving_instance, time) = (self.element, self.instance, self.time);
        Rays { leaving, leaving_instance, time, ..Rays::new(self.p + offset, d) }
    }

    /// Shadow rays to points of a light: from where rays leave the surface to just there. Were they to run beside the lines
    /// from the surface to the light, they would meet the plane that the light lies in before their end.
    #[inline(always)]
    pub fn spawn_ray_to(&self, light: Vec3x8<S>) -> Rays<S> {
        let start = self.spawn_ray(light - self.p);
        let way = light - start.o;
        let distance = way.length_squared().sqrt();
        Rays { d: way * (1.0 / distance.max(f64::MIN_POSITIVE)), t_max: distance, ..start }
    }

    /// The distances up to which shadow rays are blocked on their way to points whose coordinates are up to `magnitude`: all the way, but
    /// for rounding, so that what lies in the plane of a light does not hide it, and the light is not before the end.
    #[inline(always)]
    pub fn reach(&self, distance: f64x8<S>, magnitude: f64x8<S>) -> f64x8<S> {
        distance - self.rounding(magnitude)
    }

    /// The most that rounding and the offsets of rays change distances to points whose coordinates are up to `magnitude`.
    #[inline(always)]
    pub fn rounding(&self, magnitude: f64x8<S>) -> f64x8<S> {
        self.magnitude.max(magnitude) * 4.0 * OFFSET
    }

    /// Transforms the points in `placed` from the space of their objects to the world.
    #[inline(never)]
    pub fn place_in_world(&mut self, scene: &Traceable, placed: mask64x8<S>) {
        let (simd, of, time) = (placed.token(), self.instance, self.time);
        let is_same = |a: usize, b: usize| of[a] == of[b] && scene.is_still(of[a], [time[a], time[b]]);
        vectorized!(simd, {
            for (first, own) in groups(placed.to_bitmask(), is_same) {
                let Some(instance) = scene.instance(of[first], time[first]) else { continue };
                let Surfaces { p, n, ns, magnitude, .. } = *self;
                let in_world = Surfaces {
                    p: instance.points_to_world(p),
                    n: instance.normals_to_world(n.widen()).narrow(),
                    ns: instance.normals_to_world(ns),
                    magnitude: instance.magnitudes(magnitude),
                    ..*self
                };
                *self = in_world.keep_where(bits(simd, own), *self);
            }
        });
    }

    /// Replaces the surface in one lane.
    pub fn set_lane(&mut self, lane: usize, surface: &Surface) {
        self.p.set_lane(lane, surface.p);
        self.n.set_lane(lane, surface.n.as_vec3());
        self.ns.set_lane(lane, surface.ns);
        (self.magnitude[lane], self.time[lane]) = (surface.magnitude, surface.time);
    }
}

/// The data that all points of an element of a [`List`](crate::trace::List) share.
pub(crate) struct Sheet<'s> {
    shape: SheetShape<'s>,
    magnitude: f64,
}

enum SheetShape<'s> {
    /// A triangle, its corners as the mesh has them, and its normal.
    Flat { triangle: &'s Triangle, corners: [DVec3; 3], n: DVec3 },
    /// A curved shape; whether its normal points inwards.
    Round { curved: &'s Curved, is_inward: bool },
}

impl<'s> Sheet<'s> {
    /// `None` for meshes with shading normals.
    pub fn new(level: Level, element: &Element<'s>, primitive: &Primitive) -> Option<Self> {
        match (element.shape, &primitive.shape) {
            (ListedShape::Triangle(BoxedTriangle { triangle, .. }), Shape::TriangleMesh(mesh)) => {
                let corners = triangle.in_order();
                // Normal and magnitude are those of any point.
                let of_mesh = (&**mesh, element.id.index as usize, corners);
                let ShapePoint { magnitude, n, .. } = on_triangle(level, primitive, of_mesh, [1.0, 0.0, 0.0]);
                let shape = SheetShape::Flat { triangle, corners, n };
                mesh.normals().is_empty().then_some(Sheet { shape, magnitude })
            }
            (ListedShape::Curved(curved), _) => {
                let is_inward = primitive.reverse_orientation != primitive.mirrored;
                let shape = SheetShape::Round { curved, is_inward };
                Some(Sheet { shape, magnitude: curved.magnitude() })
            }
            _ => None,
        }
    }

    /// The points where the rays hit the element, and the weights of the first two vertices of a triangle there.
    #[inline(always)]
    pub fn points<S: Simd>(&self, simd: S, rays: &Rays<S>, hits: &Hits<S>) -> (Surfaces<S>, Vec2x8<S>) {
        let (p, n, barycentric) = match &self.shape {
            SheetShape::Flat { triangle, corners: [p0, p1, p2], n } => {
                let [b0, b1, b2] = triangle.weights(hits.sides);
                let (p0, p1, p2) =
                    (Vec3x8::splat(simd, *p0), Vec3x8::splat(simd, *p1), Vec3x8::splat(simd, *p2));
                (p0 * b0 + p1 * b1 + p2 * b2, Vec3x8::splat(simd, *n), [b0, b1])
            }
            SheetShape::Round { curved, is_inward } => {
                let (p, outward) = curved.project_all(rays.at(hits.t));
                (p, if *is_inward { -outward } else { outward }, [0.0.simd_into(simd); 2])
            }
        };
        let Hits { element, instance, .. } = *hits;
        let magnitude = self.magnitude.simd_into(simd);
        (Surfaces { p, n: n.narrow(), ns: n, magnitude, element, instance, time: rays.time }, barycentric)
    }
}

/// Triangles of any meshes, one for each point.
#[derive(Default)]
pub(crate) struct Triangles {
    corners: [[[f64; LANES]; 3]; 3],
    normals: [[[f64; LANES]; 3]; 3],
    /// Bits of the triangles whose meshes have normals.
    has_normals: u64,
    /// The lanes that turn the normals that the winding order gives.
    is_n: u64,
    /// The lanes that turn the normals on the side that emits.
    is_emitting: u64,
    /// The lanes that turn the normals that the file gives.
    is_smooth: u64,
}

/// One point of a shape or eight. The fields are those of [`Surface`].
#[derive(Clone, Copy)]
pub(crate) struct ShapePoint<V = DVec3, N = f64> {
    pub p: V,
    pub magnitude: N,
    pub n: V,
    pub ns: V,
    pub emitting: V,
}

pub(crate) type ShapePoints<S> = ShapePoint<Vec3x8<S>, f64x8<S>>;

/// The point of a triangle, of a mesh and with these corners, that the corners weigh so much at.
pub(crate) fn on_triangle(
    level: Level,
    primitive: &Primitive,
    triangle: (&Mesh, usize, [DVec3; 3]),
    weights: [f64; 3],
) -> ShapePoint {
    let mut triangles = Triangles::default();
    triangles.set_lane(0, primitive, triangle);
    side_by_side!(level, simd => {
        let weights = three!(corner, weights[corner].simd_into(simd));
        let ShapePoint { p, magnitude, n, ns, emitting } = triangles.points(simd, weights, bits(simd, 1));
        let [p, n, ns, emitting] = [p.lane(0), n.lane(0), ns.lane(0), emitting.lane(0)];
        ShapePoint { p, magnitude: magnitude[0], n, ns, emitting }
    })
}

impl Triangles {
    /// Sets the triangle in one lane.
    #[inline(always)]
    pub fn set_lane(
        &mut self,
        lane: usize,
        primitive: &Primitive,
        (mesh, index, corners): (&Mesh, usize, [DVec3; 3]),
    ) {
        for (own, corner) in self.corners.iter_mut().zip(corners) {
            [own[0][lane], own[1][lane], own[2][lane]] = corner.into();
        }
        if !mesh.normals().is_empty() {
            self.has_normals |= 1 << lane;
            for (own, vertex) in self.normals.iter_mut().zip(mesh.triangle(index)) {
                [own[0][lane], own[1][lane], own[2][lane]] = mesh.normals()[vertex];
            }
        }
        let Primitive { reverse_orientation, mirrored, .. } = *primitive;
        // With tangents, pbrt-v3 reverses once more.
        let is_n = mirrored != (reverse_orientation && mesh.tangents().is_empty());
        self.is_n |= u64::from(is_n) << lane;
        self.is_emitting |= u64::from(mirrored != reverse_orientation) << lane;
        self.is_smooth |= u64::from(reverse_orientation) << lane;
    }

    /// The corners.
    #[inline(always)]
    pub fn corners<S: Simd>(&self, simd: S) -> [Vec3x8<S>; 3] {
        Vec3x8::three(simd, &self.corners)
    }

    /// The points with these weights of the corners. `there`: the lanes with a triangle.
    #[inline(always)]
    pub fn points<S: Simd>(
        &self,
        simd: S,
        [b0, b1, b2]: [f64x8<S>; 3],
        there: mask64x8<S>,
    ) -> ShapePoints<S> {
        let [p0, p1, p2] = self.corners(simd);
        let p = p0 * b0 + p1 * b1 + p2 * b2;
        let magnitude = p0.magnitude().max(p1.magnitude()).max(p2.magnitude());
        let winding = across(p1 - p0, p2 - p0, there);
        let mut n = (-winding).keep_where(bits(simd, self.is_n), winding);
        let (mut ns, mut emitting) = (n, (-winding).keep_where(bits(simd, self.is_emitting), winding));
        if self.has_normals != 0 {
            let [n0, n1, n2] = Vec3x8::three(simd, &self.normals);
            let (smooth, is_valid) = (n0 * b0 + n1 * b1 + n2 * b2).try_normalize();
            let is_valid = is_valid & bits(simd, self.has_normals);
            let turned = (-smooth).keep_where(bits(simd, self.is_smooth), smooth);
            let own_n = winding.face_forward(turned);
            let own_emitting = winding.face_forward(smooth);
            n = own_n.keep_where(is_valid, n);
            ns = turned.keep_where(is_valid, ns);
            emitting = own_emitting.keep_where(is_valid, emitting);
        }
        ShapePoint { p, magnitude, n, ns, emitting }
    }
}

/// Does what [`direction_across`] does, in eight lanes.
#[inline(always)]
fn across<S: Simd>(e1: Vec3x8<S>, e2: Vec3x8<S>, there: mask64x8<S>) -> Vec3x8<S> {
    let product = e1.cross(e2);
    let squared = product.length_squared();
    let mut direction = product * (1.0 / squared.sqrt());
    let is_usual = squared.simd_gt(1e-200) & squared.simd_lt(1e200);
    for lane in set_lanes(there & !is_usual) {
        direction.set_lane(lane, direction_across(e1.lane(lane), e2.lane(lane)));
    }
    direction
}
