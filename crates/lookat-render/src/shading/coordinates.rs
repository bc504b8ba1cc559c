//! The texture coordinates of a surface, whatever its shape.

use glam::DVec3;
use lookat_scene::{Mesh, Shape};

use crate::instance::PlacedInstance;
use crate::parametric::Parametric;
use crate::surface::Surface;
use crate::traceable::Traceable;
use crate::triangle::parametric::{flat, smooth};

/// Texture coordinates: of the surface itself, and as its shading normals have it.
pub(super) struct Coordinates {
    pub flat: Parametric,
    pub shading: Parametric,
}

impl Coordinates {
    /// Of a surface that is seen from `wo`.
    pub fn new(scene: &Traceable, surface: &Surface, wo: DVec3) -> Self {
        let instance = scene.instance(surface.element.instance);
        let own = match (&surface.primitive.shape, scene.curved(surface.element.primitive)) {
            (Shape::TriangleMesh(mesh), _) => Coordinates::of_triangle(mesh, surface, instance),
            (Shape::Curve(_), _) => {
                let d = instance.map_or(-wo, |instance| instance.vector_to_object(-wo));
                alike(scene.curves.parametric(surface.element.index, d, surface.barycentric.into()))
            }
            (Shape::Quadric(_), curved) => {
                let p = instance.map_or(surface.p, |instance| instance.to_object(surface.p));
                // Every quadric is one of the curved shapes.
                alike(curved.map(|curved| curved.parametric(p)).unwrap_or_default())
            }
        };
        match instance {
            Some(instance) => Coordinates {
                flat: instance.parametric_to_world(own.flat),
                shading: instance.parametric_to_world(own.shading),
            },
            None => own,
        }
    }

    fn of_triangle(mesh: &Mesh, surface: &Surface, instance: Option<&PlacedInstance>) -> Self {
        let [b0, b1] = surface.barycentric;
        let (index, weights) = (surface.element.index as usize, [b0, b1, 1.0 - b0 - b1]);
        let flat = flat(mesh, index, weights);
        if mesh.normals().is_empty() && mesh.tangents().is_empty() {
            return alike(flat);
        }
        let ns = instance.map_or(surface.ns, |instance| instance.normal_to_object(surface.ns));
        let reversed = surface.primitive.reverse_orientation;
        Coordinates { flat, shading: smooth(mesh, index, weights, ns, reversed, flat) }
    }
}

fn alike(flat: Parametric) -> Coordinates {
    Coordinates { flat, shading: flat }
}
