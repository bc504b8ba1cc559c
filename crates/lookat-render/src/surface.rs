//! The point of a surface that a ray has hit.

pub(crate) mod points;

use glam::{DVec3, Vec3};
use lookat_scene::{Primitive, Shape};

use crate::frame::flipped;
use crate::ray::{ElementId, Hit, Ray};
use crate::traceable::Traceable;
use points::{Point, on_triangle};

/// A point of a surface, relative to the origin. Normals have length one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Surface<'s> {
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
    /// What was hit.
    pub element: ElementId,
    /// As in [`Hit::place`]; [`Hit::NO_PLACE`] of points that are sampled on lights, which no ray leaves.
    pub place: u32,
    /// The shape with its material.
    pub primitive: &'s Primitive,
}

impl<'s> Surface<'s> {
    /// The surface at a hit of `ray`.
    pub fn new(scene: &'s Traceable, ray: &Ray, hit: &Hit) -> Self {
        let Hit { t, element, place, .. } = *hit;
        let (primitive, instance) = (scene.primitive(element.primitive), scene.instance(element.instance));
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
                Point { p, magnitude: shape.magnitude(), n, ns: n, emitting }
            }
            (_, None) => {
                let local = instance.map_or(*ray, |instance| instance.ray(ray, t));
                let n = turned(scene.curves.normal(element.index, &local, hit.barycentric.into()));
                let (p, magnitude) = (local.at(t), local.at(t).abs().max(local.o.abs()).max_element());
                // It turns with the ray, so it has no side that is dark.
                Point { p, magnitude, n, ns: n, emitting: -local.d.normalize_or(DVec3::Z) }
            }
        };
        let Point { mut p, mut magnitude, .. } = point;
        let [mut n, mut ns, mut emitting] = [point.n, point.ns, point.emitting];
        if let Some(instance) = instance {
            (p, magnitude) = (instance.to_world(p), instance.magnitude(magnitude));
            [n, ns, emitting] = [n, ns, emitting].map(|n| instance.normal_to_world(n));
        }
        Surface { p, magnitude, n, ns, emitting, element, place, primitive }
    }

    /// The radiance that the surface emits towards `wo`.
    pub fn le(&self, wo: DVec3) -> Vec3 {
        match &self.primitive.emission {
            Some(emission) if emission.two_sided || self.emitting.dot(wo) > 0.0 => emission.radiance,
            _ => Vec3::ZERO,
        }
    }

    /// The same with its normal on the side that a ray in direction `d` comes from.
    pub fn facing(self, d: DVec3) -> Self {
        Surface { n: flipped(self.n, self.n.dot(d) > 0.0), ..self }
    }

    /// A ray that leaves the surface in direction `d`, unlimited.
    ///
    /// The element itself is not met again. Others that touch it here are told from it by an offset of 2^-40 of the
    /// coordinates, thousands of times their rounding and less than any gap in a scene.
    pub fn leave(&self, d: DVec3) -> Ray {
        let offset = self.n * (self.magnitude * OFFSET).copysign(self.n.dot(d));
        Ray { leaving: self.element, leaving_place: self.place, ..Ray::new(self.p + offset, d) }
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
