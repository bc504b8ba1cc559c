//! Holes of meshes, where their alpha is 0.

use glam::DVec3;
use lookat_scene::{Cutout, Mesh, Primitive, Shape};

use crate::ray::ElementId;
use crate::texture::{Footprint, TexturePoint};
use crate::triangle::parametric;

/// Whether there is something at a point of an element of the primitive, and no hole.
#[inline]
pub(crate) fn is_there(
    primitive: &Primitive,
    element: ElementId,
    barycentric: [f64; 2],
    is_shadow: bool,
) -> bool {
    match (&primitive.cutout, &primitive.shape) {
        (Some(cutout), Shape::TriangleMesh(mesh)) => is_left(cutout, mesh, element, barycentric, is_shadow),
        _ => true,
    }
}

#[inline(never)]
fn is_left(cutout: &Cutout, mesh: &Mesh, element: ElementId, [b0, b1]: [f64; 2], is_shadow: bool) -> bool {
    let at = point(mesh, element.index as usize, [b0, b1, 1.0 - b0 - b1]);
    let shadow_alpha = cutout.shadow_alpha.as_ref().filter(|_| is_shadow);
    cutout.alpha.iter().chain(shadow_alpha).all(|alpha| at.value(alpha) != 0.0)
}

/// A point of a triangle. As in pbrt-v3, it is that of the object where it is part of one.
fn point(mesh: &Mesh, index: usize, weights: [f64; 3]) -> TexturePoint {
    let corners = mesh.triangle(index).map(|vertex| DVec3::from(mesh.positions()[vertex]));
    TexturePoint {
        p: corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2],
        // Positions of the mesh are not relative to an origin.
        origin: DVec3::ZERO,
        uv: parametric::flat(mesh, index, weights).uv,
        footprint: Footprint::default(),
    }
}
