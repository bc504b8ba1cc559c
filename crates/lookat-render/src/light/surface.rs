//! Light from shapes of the world.

use glam::{DVec2, DVec3, Vec3};
use lookat_scene::{Mesh, Primitive, Shape};

use super::LightSample;
use super::curved::{self, LightPoint};
use super::mesh::MeshAreas;
use crate::color::strength;
use crate::curved::Curved;
use crate::cutout;
use crate::frame::flipped;
use crate::prepare::Traceable;
use crate::ray::{ElementId, Ray};
use crate::surface::{Surface, on_triangle, reach};

/// A shape of the world that emits.
pub(super) struct SurfaceLight<'s> {
    number: u32,
    primitive: &'s Primitive,
    pub form: SurfaceForm<'s>,
    /// About where it is, and its area.
    pub center: DVec3,
    pub area: f64,
    /// Luminance.
    pub brightness: f64,
    pub samples: u32,
}

pub(super) enum SurfaceForm<'s> {
    Curved(Box<Curved>),
    Mesh { areas: MeshAreas, mesh: &'s Mesh },
}

impl<'s> SurfaceLight<'s> {
    /// The light that a shape of the world is, if it emits and has an area.
    pub fn new(number: u32, primitive: &'s Primitive, traceable: &Traceable) -> Option<Self> {
        let emission = primitive.emission?;
        let (form, center, area) = match (&primitive.shape, traceable.curved(number)) {
            (Shape::TriangleMesh(mesh), _) => {
                let (areas, center) = MeshAreas::new(mesh, traceable.eye);
                let area = areas.total();
                (SurfaceForm::Mesh { areas, mesh }, center, area)
            }
            (Shape::Quadric(_), Some(shape)) => {
                (SurfaceForm::Curved(Box::new(*shape)), shape.center, shape.area())
            }
            (Shape::Quadric(_), None) | (Shape::Curve(_), _) => return None,
        };
        let sides = if emission.two_sided { 2.0 } else { 1.0 };
        let brightness = strength(emission.radiance) * sides;
        let light =
            SurfaceLight { number, primitive, form, center, area, brightness, samples: emission.samples };
        (area > 0.0).then_some(light)
    }

    /// A direction from a point of a surface to the light. `eye`: the world position of the origin.
    pub fn sample(&self, eye: DVec3, from: &Surface, u: DVec2) -> Option<LightSample> {
        let owner = self.primitive;
        let mut element = ElementId { instance: ElementId::WORLD, primitive: self.number, index: 0 };
        let (on_light, visible_pdf) = match &self.form {
            SurfaceForm::Curved(shape) => {
                let LightPoint { p, n, visible_pdf } = curved::sample(shape, from.p, u);
                let magnitude = shape.magnitude();
                let on_light = Surface {
                    p,
                    magnitude,
                    n,
                    ns: n,
                    emitting: flipped(n, owner.reverse_orientation),
                    element,
                    barycentric: [0.0; 2],
                    primitive: owner,
                };
                (on_light, visible_pdf)
            }
            SurfaceForm::Mesh { areas, mesh } => {
                let (index, barycentric) = areas.sample(u);
                element.index = index as u32;
                (on_triangle(owner, mesh, element, barycentric, eye), None)
            }
        };
        // No light comes out of a hole, as none is seen there.
        if !cutout::is_there(owner, element, on_light.barycentric, false) {
            return None;
        }
        let pdf = match visible_pdf {
            Some(pdf) => pdf,
            None => self.pdf(from.p, &on_light)?,
        };
        // The ray ends at the light, which does not block it.
        let to_light = on_light.p - from.p;
        let wi = to_light.try_normalize()?;
        let li = on_light.le(-wi);
        let shadow = Ray {
            t_max: reach(from, to_light.length(), on_light.magnitude),
            target: element,
            ..from.leave(wi)
        };
        if let (SurfaceForm::Curved(shape), None) = (&self.form, visible_pdf)
            && shape.hides_end_of(&shadow)
        {
            return None;
        }
        (li != Vec3::ZERO && pdf > 0.0).then_some(LightSample { li, pdf: Some(pdf), shadow })
    }

    /// Density by solid angle from `p` with which a point of the light is sampled.
    pub fn pdf(&self, p: DVec3, on_light: &Surface) -> Option<f64> {
        match &self.form {
            SurfaceForm::Curved(shape) => curved::pdf(shape, p, on_light),
            SurfaceForm::Mesh { .. } => on_light.pdf_from(p, self.area),
        }
    }
}
