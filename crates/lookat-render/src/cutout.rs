//! Holes that alpha textures cut into meshes.

use fearless_simd::Level;
use glam::DVec3;
use lookat_scene::{Cutout, Mesh, Primitive, Shape};

use crate::number::{bits, side_by_side};
use crate::ray::ElementId;
use crate::texture::TexturePoint;
use crate::triangle::uv;

/// True if an element of the primitive has no hole at a point.
#[inline]
pub(crate) fn is_solid(
    level: Level,
    (primitive, element): (&Primitive, ElementId),
    barycentric: [f64; 2],
    is_shadow: bool,
) -> bool {
    match (&primitive.cutout, &primitive.shape) {
        (Some(cutout), Shape::TriangleMesh(mesh)) => {
            is_left(level, (cutout, mesh, element), barycentric, is_shadow)
        }
        _ => true,
    }
}

#[inline(never)]
fn is_left(
    level: Level,
    (cutout, mesh, element): (&Cutout, &Mesh, ElementId),
    [b0, b1]: [f64; 2],
    is_shadow: bool,
) -> bool {
    let (index, weights) = (element.index as usize, [b0, b1, 1.0 - b0 - b1]);
    // As in pbrt-v3, the point is that of the object where it is part of one. Positions of the mesh are not relative to an origin.
    let corners = mesh.triangle(index).map(|vertex| DVec3::from(mesh.positions()[vertex]));
    let p = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
    let uvs = uv::coordinates(mesh, index);
    let uv = uvs[0] * weights[0] + uvs[1] * weights[1] + uvs[2] * weights[2];
    let shadow_alpha = cutout.shadow_alpha.as_ref().filter(|_| is_shadow);
    side_by_side!(level, simd => {
        let (at, first) = (TexturePoint::splat(simd, p, uv.into()), bits(simd, 1));
        cutout.alpha.iter().chain(shadow_alpha).all(|alpha| at.value(alpha, first)[0] != 0.0)
    })
}
