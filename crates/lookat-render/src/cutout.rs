//! Holes that alpha textures cut into meshes.

use fearless_simd::{Level, Simd, f64x8, mask64x8, prelude::*};
use glam::DVec3;
use lookat_scene::{Cutout, Mesh, Primitive, Shape};

use crate::number::{LANES, Vec2x8, Vec3x8, bits, groups, set_bits, side_by_side, three, vectorized};
use crate::texture::TexturePoint;
use crate::triangle::uv;

/// Points of triangles that may lie in holes.
pub(crate) struct CutoutPoints<'s, S: Simd> {
    pub primitives: [&'s Primitive; LANES],
    /// The indices of the triangles in their meshes.
    pub triangles: [u32; LANES],
    /// The weights of the first two vertices.
    pub barycentric: Vec2x8<S>,
    /// True for hits of shadow rays, which may pass other holes.
    pub is_shadow: bool,
}

impl<S: Simd> CutoutPoints<'_, S> {
    /// The active points that lie in no hole.
    #[inline(never)]
    pub fn solid(&self, active: mask64x8<S>) -> mask64x8<S> {
        vectorized!(active.token(), {
            let is_same = |a: usize, b: usize| std::ptr::eq(self.primitives[a], self.primitives[b]);
            let mut solid = active;
            for (first, own) in groups(active.to_bitmask(), is_same) {
                let Primitive { cutout, shape, .. } = self.primitives[first];
                if let (Some(cutout), Shape::TriangleMesh(mesh)) = (cutout, shape) {
                    solid &= !bits(active.token(), own) | self.left_by(cutout, mesh, own);
                }
            }
            solid
        })
    }

    /// The points of a mesh that its cutout leaves solid. `own`: bits of its points.
    #[inline(always)]
    fn left_by(&self, cutout: &Cutout, mesh: &Mesh, own: u64) -> mask64x8<S> {
        let [b0, b1] = self.barycentric;
        let simd = b0.token();
        let (mut corners, mut uvs) = ([[[0.0; LANES]; 3]; 3], [[[0.0; LANES]; 2]; 3]);
        for lane in set_bits(own) {
            let triangle = self.triangles[lane] as usize;
            let vertices = mesh.triangle(triangle).into_iter().zip(uv::coordinates(mesh, triangle));
            for (at, (vertex, uv)) in vertices.enumerate() {
                // As in pbrt-v3, the point is that of the object where it is part of one. It is not relative to an origin.
                let [x, y, z] = mesh.positions()[vertex];
                (corners[at][0][lane], corners[at][1][lane], corners[at][2][lane]) = (x, y, z);
                (uvs[at][0][lane], uvs[at][1][lane]) = uv.into();
            }
        }
        let weights = [b0, b1, 1.0 - b0 - b1];
        let [p0, p1, p2] = Vec3x8::three(simd, &corners);
        let p = p0 * weights[0] + p1 * weights[1] + p2 * weights[2];
        let uv = [0, 1].map(
            #[inline(always)]
            |axis: usize| {
                let [a, b, c]: [f64x8<S>; 3] = three!(corner, uvs[corner][axis].simd_into(simd));
                a * weights[0] + b * weights[1] + c * weights[2]
            },
        );
        let at = TexturePoint { p, origin: DVec3::ZERO, uv, footprint: None };
        let mut left = bits(simd, own);
        for alpha in cutout.alpha.iter().chain(cutout.shadow_alpha.as_ref().filter(|_| self.is_shadow)) {
            left &= !at.value(alpha, left).simd_eq(0.0);
        }
        left
    }
}

/// True if a triangle of a primitive has no hole at a point. `barycentric`: the weights of its first two vertices.
pub(crate) fn is_solid(
    level: Level,
    primitive: &Primitive,
    triangle: u32,
    barycentric: [f64; 2],
    is_shadow: bool,
) -> bool {
    side_by_side!(level, simd => {
        let barycentric = [barycentric[0].simd_into(simd), barycentric[1].simd_into(simd)];
        let points =
            CutoutPoints { primitives: [primitive; LANES], triangles: [triangle; LANES], barycentric, is_shadow };
        points.solid(bits(simd, 1)).any_true()
    })
}
