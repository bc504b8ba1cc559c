//! Light from shapes of the world.

pub(super) mod lanes;

use std::f64::consts::PI;

use glam::{DVec2, DVec3, Vec3};
use lookat_scene::{Mesh, Primitive, Shape};

use super::LightSample;
use super::facing::{Facing, Patch};
use super::mesh::MeshAreas;
use super::receiver::Receiver;
use super::sphere::VisibleCone;
use crate::color::strength;
use crate::curved::Curved;
use crate::cutout;
use crate::frame::flipped;
use crate::ray::{ElementId, Hit, Ray};
use crate::surface::{Surface, on_triangle, reach};
use crate::traceable::Traceable;
use crate::triangle::corners;

/// A shape of the world that emits.
pub(super) struct SurfaceLight {
    /// The primitive of the world.
    pub number: u32,
    pub form: SurfaceForm,
    /// The middle, and how far from it there is something.
    pub center: DVec3,
    pub radius: f64,
    pub area: f64,
    pub facing: Facing,
    /// Luminance of its radiance, about.
    pub brightness: f64,
    pub samples: u32,
}

pub(super) enum SurfaceForm {
    Curved(Box<Curved>),
    Mesh(MeshAreas),
}

impl SurfaceLight {
    /// The light that a shape of the world is, if it emits and has an area.
    pub fn new(number: u32, primitive: &Primitive, traceable: &Traceable) -> Option<Self> {
        let emission = primitive.emission?;
        let (origin, two_sided) = (traceable.origin, emission.two_sided);
        let (form, center, radius, area, facing) = match (&primitive.shape, traceable.curved(number)) {
            (Shape::TriangleMesh(mesh), _) => {
                let (areas, center) = MeshAreas::new(mesh, origin);
                let (area, radius) = (areas.total(), mesh_radius(mesh, origin, center));
                let patches = triangles(number, primitive, (mesh, &areas), origin);
                let facing = Facing::new(patches, center, two_sided);
                (SurfaceForm::Mesh(areas), center, radius, area, facing)
            }
            (Shape::Quadric(_), Some(shape)) => {
                let (center, radius) = (shape.center, shape.half_extent().length());
                let patches: Vec<Patch> = cells(primitive, shape).collect();
                let area = patches.iter().map(|patch| patch.area).sum();
                let facing = Facing::new(patches.into_iter(), center, two_sided);
                (SurfaceForm::Curved(Box::new(*shape)), center, radius, area, facing)
            }
            (Shape::Quadric(_), None) | (Shape::Curve(_), _) => return None,
        };
        let (brightness, samples) = (strength(emission.radiance), emission.samples);
        let light = SurfaceLight { number, form, center, radius, area, facing, brightness, samples };
        (area > 0.0).then_some(light)
    }

    /// About the irradiance that it brings to a surface, were nothing in the way.
    pub fn estimate(&self, at: &Receiver) -> f64 {
        let offset = self.center - at.p;
        let inverse = offset.length_recip();
        // No shape fills more than the sky, which it does from its middle.
        if !inverse.is_finite() {
            return self.brightness * PI;
        }
        let (wi, spread) = (offset * inverse, self.radius * inverse);
        let solid_angle = PI.min(self.area * inverse * inverse * self.facing.share(-wi, spread));
        self.brightness * solid_angle * at.cosine(wi, spread)
    }

    /// A direction from a point of a surface to the light, which is this primitive. `origin`: the world position of the origin.
    pub fn sample(
        &self,
        primitive: &Primitive,
        origin: DVec3,
        from: &Surface,
        u: DVec2,
    ) -> Option<LightSample> {
        match &self.form {
            SurfaceForm::Curved(shape) => match VisibleCone::new(shape, from.p) {
                Some(cone) => self.sample_cone(primitive, (shape, &cone), from, u),
                None => {
                    let sample = self.sample_point(from, &self.on_curved(primitive, shape, u))?;
                    // Another part of the same shape may be in front.
                    (!shape.hides_end_of(&sample.shadow)).then_some(sample)
                }
            },
            SurfaceForm::Mesh(areas) => {
                let Shape::TriangleMesh(mesh) = &primitive.shape else { return None };
                let (index, barycentric) = areas.sample(u);
                let element = element(self.number, index);
                // No light comes out of a hole, as none is seen there.
                let is_there = cutout::is_there(primitive, element, [barycentric[0], barycentric[1]], false);
                is_there
                    .then(|| {
                        on_triangle(
                            primitive,
                            mesh,
                            element,
                            Hit::NO_PLACE,
                            corners(mesh, index, origin),
                            barycentric,
                        )
                    })
                    .and_then(|on_light| self.sample_point(from, &on_light))
            }
        }
    }

    /// A direction in which a whole sphere is seen from outside.
    fn sample_cone(
        &self,
        primitive: &Primitive,
        (shape, cone): (&Curved, &VisibleCone),
        from: &Surface,
        u: DVec2,
    ) -> Option<LightSample> {
        let emission = primitive.emission?;
        if primitive.reverse_orientation && !emission.two_sided {
            return None;
        }
        let (wi, distance) = cone.sample(u);
        let t_max = reach(from, distance, shape.magnitude());
        let shadow = Ray { t_max, target: self.element(), ..from.leave(wi) };
        Some(LightSample { li: emission.radiance, pdf: Some(cone.pdf()), shadow })
    }

    /// The direction to a point of the light.
    fn sample_point(&self, from: &Surface, on_light: &Surface) -> Option<LightSample> {
        let way = from.towards(on_light.p);
        let wi = way.d;
        let li = on_light.le(-wi);
        if li == Vec3::ZERO {
            return None;
        }
        let pdf = self.point_pdf(on_light, wi, (on_light.p - from.p).length_squared())?;
        // The ray ends at the light, which does not block it.
        let t_max = reach(from, way.t_max, on_light.magnitude);
        let shadow = Ray { t_max, target: on_light.element, ..way };
        (pdf > 0.0).then_some(LightSample { li, pdf: Some(pdf), shadow })
    }

    /// A point of a curved shape.
    fn on_curved<'s>(&self, primitive: &'s Primitive, shape: &Curved, u: DVec2) -> Surface<'s> {
        let (p, n) = shape.placed(shape.sample(u));
        Surface {
            p,
            magnitude: shape.magnitude(),
            n,
            ns: n,
            emitting: flipped(n, primitive.reverse_orientation),
            element: self.element(),
            place: Hit::NO_PLACE,
            primitive,
        }
    }

    /// Density by solid angle with which a point of the light is sampled, that is seen from `p` in direction `d`.
    pub fn pdf(&self, p: DVec3, d: DVec3, on_light: &Surface) -> Option<f64> {
        let cone = match &self.form {
            SurfaceForm::Curved(shape) => VisibleCone::new(shape, p),
            SurfaceForm::Mesh(_) => None,
        };
        match cone {
            Some(cone) => Some(cone.pdf()),
            None => self.point_pdf(on_light, d, (on_light.p - p).length_squared()),
        }
    }

    /// The same of points that are sampled on all of the light.
    // Inlined, as its arguments are new.
    #[inline(always)]
    fn point_pdf(&self, on_light: &Surface, d: DVec3, squared_distance: f64) -> Option<f64> {
        let area = match &self.form {
            SurfaceForm::Curved(shape) => shape.stretch(on_light.p),
            SurfaceForm::Mesh(_) => self.area,
        };
        on_light.pdf_from(d, squared_distance, area)
    }

    /// The light, or the first triangle of it.
    fn element(&self) -> ElementId {
        element(self.number, 0)
    }
}

/// The element that is triangle `index` of a primitive of the world, or the first.
fn element(number: u32, index: usize) -> ElementId {
    ElementId { instance: ElementId::WORLD, primitive: number, index: index as u32 }
}

/// The triangles of a mesh.
fn triangles(
    number: u32,
    primitive: &Primitive,
    (mesh, areas): (&Mesh, &MeshAreas),
    origin: DVec3,
) -> impl Iterator<Item = Patch> + Clone {
    (0..mesh.triangles()).map(move |index| {
        let (element, corners) = (element(number, index), corners(mesh, index, origin));
        let middle = on_triangle(primitive, mesh, element, Hit::NO_PLACE, corners, [1.0 / 3.0; 3]);
        // Normals of the file decide, at each point.
        let side = |vertex: usize| DVec3::from(mesh.normals()[vertex]).dot(middle.n);
        let sides = || mesh.triangle(index).map(side);
        let is_same = mesh.normals().is_empty()
            || sides().iter().all(|side| *side > 0.0)
            || sides().iter().all(|side| *side < 0.0);
        let emitting = if is_same { middle.emitting } else { DVec3::ZERO };
        Patch { p: middle.p, emitting, area: areas.of(index) }
    })
}

/// How far from a place there are vertices.
fn mesh_radius(mesh: &Mesh, origin: DVec3, center: DVec3) -> f64 {
    let squared = |p: &[f64; 3]| (DVec3::from(*p) - origin).distance_squared(center);
    mesh.positions().iter().map(squared).fold(0.0, f64::max).sqrt()
}

/// Patches of a curved shape.
fn cells(primitive: &Primitive, shape: &Curved) -> impl Iterator<Item = Patch> {
    let is_reversed = primitive.reverse_orientation;
    shape.cells().map(move |(p, n, area)| Patch { p, emitting: flipped(n, is_reversed), area })
}
