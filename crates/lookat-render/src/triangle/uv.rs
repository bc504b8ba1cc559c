//! Texture coordinates of triangles, and derivatives by them (PBR 3.6.2).

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::{DVec2, DVec3};
use lookat_scene::Mesh;

use crate::frame::pbrt_frame;
use crate::number::{V3, Vec2x8, Vec3x8, bits};
use crate::parametric::Parametrics;

/// Coordinates of a triangle whose mesh has none, as pbrt-v3 gives them.
const DEFAULT: [DVec2; 3] = [DVec2::ZERO, DVec2::X, DVec2::ONE];

/// A triangle with less area in texture space has no directions of its own, as in pbrt-v3.
const LEAST_AREA: f64 = 1e-8;

/// The texture coordinates of the corners of a triangle.
pub(crate) fn coordinates(mesh: &Mesh, index: usize) -> [DVec2; 3] {
    if mesh.uvs().is_empty() {
        return DEFAULT;
    }
    mesh.triangle(index).map(|vertex| DVec2::from(mesh.uvs()[vertex]))
}

/// Triangles of any meshes, one in each lane.
pub(crate) struct ParametricTriangles<S: Simd> {
    positions: [Vec3x8<S>; 3],
    normals: [Vec3x8<S>; 3],
    tangents: [Vec3x8<S>; 3],
    uvs: [Vec2x8<S>; 3],
    /// The triangles that ReverseOrientation reverses.
    is_reversed: mask64x8<S>,
    /// The triangles whose meshes have normals.
    has_normals: mask64x8<S>,
    /// The triangles whose meshes have tangents.
    has_tangents: mask64x8<S>,
}

impl<S: Simd> ParametricTriangles<S> {
    /// A triangle in each lane whose coordinates are those of the plane that it lies in: where no other is set, it takes no detour.
    #[inline(always)]
    pub fn new(simd: S) -> Self {
        let none = bits(simd, 0);
        let [positions, normals, tangents] = [DEFAULT, [DVec2::ZERO; 3], [DVec2::ZERO; 3]].map(
            #[inline(always)]
            |corners| corners.map(|corner| Vec3x8::splat(simd, corner.extend(0.0))),
        );
        let uvs = positions.map(|corner| [corner.x, corner.y]);
        ParametricTriangles {
            positions,
            normals,
            tangents,
            uvs,
            is_reversed: none,
            has_normals: none,
            has_tangents: none,
        }
    }

    /// Sets the triangle in some lanes.
    #[inline(always)]
    pub fn set(&mut self, own: mask64x8<S>, (mesh, index): (&Mesh, usize), is_reversed: bool) {
        let (simd, vertices) = (own.token(), mesh.triangle(index));
        spread(&mut self.positions, own, vertices, mesh.positions());
        if !mesh.normals().is_empty() {
            spread(&mut self.normals, own, vertices, mesh.normals());
            self.has_normals |= own;
        }
        if !mesh.tangents().is_empty() {
            spread(&mut self.tangents, own, vertices, mesh.tangents());
            self.has_tangents |= own;
        }
        for (to, from) in self.uvs.iter_mut().zip(coordinates(mesh, index)) {
            *to = [own.select(from.x.simd_into(simd), to[0]), own.select(from.y.simd_into(simd), to[1])];
        }
        self.is_reversed |= own & mask64x8::splat(simd, is_reversed);
    }

    /// The derivatives of the flat triangles, and those by their shading normals, at points with these weights of the first two corners
    /// and these shading normals.
    #[inline(always)]
    pub fn parametrics(&self, [b0, b1]: Vec2x8<S>, ns: Vec3x8<S>) -> [Parametrics<S>; 2] {
        let (simd, uvs, weights) = (b0.token(), self.uvs, [b0, b1, 1.0 - b0 - b1]);
        let Self { is_reversed, has_normals, has_tangents, .. } = *self;
        let flat = flat(uvs, self.positions, weights);
        let is_smooth = has_normals | has_tangents;
        if !is_smooth.any_true() {
            return [flat, flat];
        }
        let [s0, s1, s2] = self.tangents;
        let (tangent, is_valid) = (s0 * weights[0] + s1 * weights[1] + s2 * weights[2]).try_normalize();
        // pbrt-v3 keeps the direction of dpdu only, at length one.
        let along = tangent.keep_where(is_valid & has_tangents, flat.dpdu.normalize_or(DVec3::X));
        // pbrt-v3 knows the normal of the file here, before ReverseOrientation.
        let own = (-ns).keep_where(is_reversed, ns);
        let (across, is_valid) = along.cross(own).try_normalize();
        let [x, y] = pbrt_frame(own);
        let (dpdu, dpdv) = (across.cross(own).keep_where(is_valid, x), across.keep_where(is_valid, y));
        let zero = Vec3x8::splat(simd, DVec3::ZERO);
        let [dndu, dndv] = bending(uvs, self.normals);
        let shading = Parametrics {
            uv: flat.uv,
            dpdu: dpdu.keep_where(is_smooth, flat.dpdu),
            dpdv: (-dpdv).keep_where(is_reversed, dpdv).keep_where(is_smooth, flat.dpdv),
            dndu: dndu.keep_where(has_normals, zero),
            dndv: dndv.keep_where(has_normals, zero),
        };
        [flat, shading]
    }
}

/// Sets what the vertices of a triangle have, in some lanes.
#[inline(always)]
fn spread<S: Simd>(to: &mut [Vec3x8<S>; 3], own: mask64x8<S>, vertices: [usize; 3], from: &[[f64; 3]]) {
    for (to, vertex) in to.iter_mut().zip(vertices) {
        *to = Vec3x8::splat(own.token(), from[vertex]).keep_where(own, *to);
    }
}

/// The derivatives of flat triangles at barycentric coordinates.
#[inline(always)]
fn flat<S: Simd>(
    uvs: [Vec2x8<S>; 3],
    [p0, p1, p2]: [Vec3x8<S>; 3],
    [b0, b1, b2]: [f64x8<S>; 3],
) -> Parametrics<S> {
    let [u, v] = [0, 1].map(
        #[inline(always)]
        |axis: usize| uvs[0][axis] * b0 + uvs[1][axis] * b1 + uvs[2][axis] * b2,
    );
    let ([dpdu, dpdv], is_valid) = by_coordinates(uvs, [p0 - p2, p1 - p2]);
    let is_valid = is_valid & !is_zero(dpdu.cross(dpdv));
    let zero = Vec3x8::splat(b0.token(), DVec3::ZERO);
    let mut flat = Parametrics { uv: [u, v], dpdu, dpdv, dndu: zero, dndv: zero };
    if !is_valid.all_true() {
        let [x, y] = pbrt_frame((p2 - p0).cross(p1 - p0).normalize_or(DVec3::Z));
        (flat.dpdu, flat.dpdv) = (dpdu.keep_where(is_valid, x), dpdv.keep_where(is_valid, y));
    }
    flat
}

/// The derivatives of the normals in the file.
#[inline(always)]
fn bending<S: Simd>(uvs: [Vec2x8<S>; 3], [n0, n1, n2]: [Vec3x8<S>; 3]) -> [Vec3x8<S>; 2] {
    let ([dndu, dndv], is_valid) = by_coordinates(uvs, [n0 - n2, n1 - n2]);
    let across = (n2 - n0).cross(n1 - n0);
    let zero = Vec3x8::splat(across.x.token(), DVec3::ZERO);
    let ([x, y], is_zero) = (pbrt_frame(across), is_zero(across));
    [
        dndu.keep_where(is_valid, zero.keep_where(is_zero, x)),
        dndv.keep_where(is_valid, zero.keep_where(is_zero, y)),
    ]
}

#[inline(always)]
fn is_zero<S: Simd>(v: Vec3x8<S>) -> mask64x8<S> {
    v.x.simd_eq(0.0) & v.y.simd_eq(0.0) & v.z.simd_eq(0.0)
}

/// Derivatives by u and v of what differs by `deltas` from the third corner to the first and second, and where the coordinates span
/// an area.
#[inline(always)]
fn by_coordinates<S: Simd>(
    [uv0, uv1, uv2]: [Vec2x8<S>; 3],
    [d0, d1]: [Vec3x8<S>; 2],
) -> ([Vec3x8<S>; 2], mask64x8<S>) {
    let (a, b) = ([uv0[0] - uv2[0], uv0[1] - uv2[1]], [uv1[0] - uv2[0], uv1[1] - uv2[1]]);
    let determinant = a[0] * b[1] - a[1] * b[0];
    let by = |v: Vec3x8<S>| V3 { x: v.x / determinant, y: v.y / determinant, z: v.z / determinant };
    let derivatives = [by(d0 * b[1] - d1 * a[1]), by(d1 * a[0] - d0 * b[0])];
    (derivatives, determinant.abs().simd_ge(LEAST_AREA))
}
