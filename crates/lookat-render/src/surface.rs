//! The point of a surface that a ray has hit.

pub(crate) mod points;

use glam::{DVec3, Vec3};
use lookat_scene::{MaterialKind, Mesh, Primitive, Shape};

use crate::frame::flipped;
use crate::instance::PlacedInstance;
use crate::ray::{ElementId, Hit, Ray};
use crate::traceable::Traceable;
use crate::triangle::corners;

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
    /// Whether light passes straight through, as it has no material.
    pub fn is_passed(&self) -> bool {
        matches!(self.primitive.material.kind(), MaterialKind::None)
    }

    /// The surface at a hit of `ray`.
    #[inline]
    pub fn new(scene: &'s Traceable, ray: &Ray, hit: &Hit) -> Self {
        let primitive = scene.primitive(hit.element.primitive);
        match &primitive.shape {
            Shape::TriangleMesh(mesh) if hit.element.instance == ElementId::WORLD => {
                let [b0, b1] = hit.barycentric;
                let corners = scene.world.triangle(hit.place).in_order();
                on_triangle(primitive, mesh, hit.element, hit.place, corners, [b0, b1, 1.0 - b0 - b1])
            }
            _ => Surface::of_any(scene, primitive, ray, hit),
        }
    }

    /// Out of line, so that triangles of the world, the most of all, are copied nowhere.
    #[inline(never)]
    fn of_any(scene: &Traceable, primitive: &'s Primitive, ray: &Ray, hit: &Hit) -> Self {
        let instance = scene.instance(hit.element.instance);
        let mut surface = Surface::local(scene, primitive, instance, ray, hit);
        if let Some(instance) = instance {
            surface.p = instance.to_world(surface.p);
            surface.magnitude = instance.magnitude(surface.magnitude);
            surface.n = instance.normal_to_world(surface.n);
            surface.ns = instance.normal_to_world(surface.ns);
            surface.emitting = instance.normal_to_world(surface.emitting);
        }
        surface
    }

    /// The surface in the space of its object, or in the world if it has none.
    fn local(
        scene: &Traceable,
        primitive: &'s Primitive,
        instance: Option<&PlacedInstance>,
        ray: &Ray,
        hit: &Hit,
    ) -> Self {
        match &primitive.shape {
            Shape::Quadric(_) => {
                let place = match instance {
                    Some(instance) => instance.to_object(ray.at(hit.t)),
                    None => ray.at(hit.t),
                };
                // The hit is as exact as its distance; the shape is exacter.
                let (p, outward, magnitude) = match scene.curved(hit.element.primitive) {
                    Some(shape) => {
                        let (p, outward) = shape.project(place);
                        (p, outward, shape.magnitude())
                    }
                    None => (place, DVec3::Z, 0.0),
                };
                let n = flipped(outward, primitive.reverse_orientation != primitive.mirrored);
                Surface {
                    p,
                    magnitude,
                    n,
                    ns: n,
                    emitting: flipped(outward, primitive.reverse_orientation),
                    element: hit.element,
                    place: hit.place,
                    primitive,
                }
            }
            Shape::Curve(_) => {
                let local = instance.map_or(*ray, |instance| instance.ray(ray, hit.t));
                let normal = scene.curves.normal(hit.element.index, &local, hit.barycentric.into());
                let p = local.at(hit.t);
                let n = flipped(normal, primitive.reverse_orientation != primitive.mirrored);
                Surface {
                    p,
                    magnitude: p.abs().max(local.o.abs()).max_element(),
                    n,
                    ns: n,
                    // It turns with the ray, so it has no side that is dark.
                    emitting: -local.d.normalize_or(DVec3::Z),
                    element: hit.element,
                    place: hit.place,
                    primitive,
                }
            }
            // That of an object: its vertices are relative to nothing.
            Shape::TriangleMesh(mesh) => {
                let [b0, b1] = hit.barycentric;
                let corners = corners(mesh, hit.element.index as usize, DVec3::ZERO);
                on_triangle(primitive, mesh, hit.element, hit.place, corners, [b0, b1, 1.0 - b0 - b1])
            }
        }
    }

    /// The radiance that the surface emits towards `wo`.
    pub fn le(&self, wo: DVec3) -> Vec3 {
        match &self.primitive.emission {
            Some(emission) if emission.two_sided || self.emitting.dot(wo) > 0.0 => emission.radiance,
            _ => Vec3::ZERO,
        }
    }

    /// The density, by solid angle, of this point when it is chosen evenly on an area, and seen in direction `d`, of length
    /// one, from so far away. `None` where it is seen edge-on.
    #[inline(always)]
    pub fn pdf_from(&self, d: DVec3, squared_distance: f64, area: f64) -> Option<f64> {
        let pdf = squared_distance / (self.n.dot(d).abs() * area);
        pdf.is_finite().then_some(pdf)
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

/// The point of a triangle with the given corners, and weights of these.
pub(crate) fn on_triangle<'s>(
    primitive: &'s Primitive,
    mesh: &Mesh,
    element: ElementId,
    place: u32,
    [p0, p1, p2]: [DVec3; 3],
    [b0, b1, b2]: [f64; 3],
) -> Surface<'s> {
    let p = p0 * b0 + p1 * b1 + p2 * b2;
    let magnitude = p0.abs().max(p1.abs()).max(p2.abs()).max_element();
    let winding = direction_across(p1 - p0, p2 - p0);
    let interpolated = |normals: &[[f64; 3]]| {
        let [n0, n1, n2] = mesh.triangle(element.index as usize).map(|vertex| DVec3::from(normals[vertex]));
        (n0 * b0 + n1 * b1 + n2 * b2).try_normalize()
    };
    let smooth = if mesh.normals().is_empty() { None } else { interpolated(mesh.normals()) };
    // The winding order as the mesh has it, before it was mirrored.
    let own = flipped(winding, primitive.mirrored);
    match smooth {
        // Normals of the file decide the sides.
        Some(smooth) => {
            let ns = flipped(smooth, primitive.reverse_orientation);
            let n = flipped(winding, winding.dot(ns) < 0.0);
            Surface {
                p,
                magnitude,
                n,
                ns,
                emitting: flipped(winding, winding.dot(smooth) < 0.0),
                element,
                place,
                primitive,
            }
        }
        None => {
            // With tangents, pbrt-v3 reverses once more.
            let n = flipped(own, primitive.reverse_orientation && mesh.tangents().is_empty());
            Surface {
                p,
                magnitude,
                n,
                ns: n,
                emitting: flipped(own, primitive.reverse_orientation),
                element,
                place,
                primitive,
            }
        }
    }
}
