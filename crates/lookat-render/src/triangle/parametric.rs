//! Texture coordinates of triangles, and derivatives by them (PBR 3.6.2).

use glam::{DMat2, DVec2, DVec3};
use lookat_scene::Mesh;

use crate::frame::{flipped, pbrt_frame};
use crate::parametric::Parametric;

/// Coordinates of a triangle whose mesh has none, as pbrt-v3 gives them.
const DEFAULT: [DVec2; 3] = [DVec2::ZERO, DVec2::X, DVec2::ONE];

/// A triangle with less area in texture space has no directions of its own, as in pbrt-v3.
const LEAST_AREA: f64 = 1e-8;

/// The flat triangle at the point with the given weights of its corners.
pub(crate) fn flat(mesh: &Mesh, index: usize, weights: [f64; 3]) -> Parametric {
    let [p0, p1, p2] = mesh.triangle(index).map(|vertex| DVec3::from(mesh.positions()[vertex]));
    let uvs = coordinates(mesh, index);
    let uv = uvs[0] * weights[0] + uvs[1] * weights[1] + uvs[2] * weights[2];
    let (e0, e1) = (p0 - p2, p1 - p2);
    let (dpdu, dpdv) = match by_coordinates(uvs, [e0, e1]) {
        Some((dpdu, dpdv)) if dpdu.cross(dpdv) != DVec3::ZERO => (dpdu, dpdv),
        _ => pbrt_frame((p2 - p0).cross(p1 - p0).normalize_or(DVec3::Z)),
    };
    Parametric { uv, dpdu, dpdv, dndu: DVec3::ZERO, dndv: DVec3::ZERO }
}

/// The same with the shading normal `ns`: pbrt-v3 keeps the direction of dpdu only, at length one. `reversed`: by
/// ReverseOrientation.
pub(crate) fn smooth(
    mesh: &Mesh,
    index: usize,
    [b0, b1, b2]: [f64; 3],
    ns: DVec3,
    reversed: bool,
    flat: Parametric,
) -> Parametric {
    let tangent = || {
        let [s0, s1, s2] = mesh.triangle(index).map(|vertex| DVec3::from(mesh.tangents()[vertex]));
        (s0 * b0 + s1 * b1 + s2 * b2).try_normalize()
    };
    let given = if mesh.tangents().is_empty() { None } else { tangent() };
    let along = given.unwrap_or_else(|| flat.dpdu.normalize_or(DVec3::X));
    // pbrt-v3 knows the normal of the file here, before ReverseOrientation.
    let own = flipped(ns, reversed);
    let (dpdu, dpdv) = match along.cross(own).try_normalize() {
        Some(across) => (across.cross(own), across),
        None => pbrt_frame(own),
    };
    let (dndu, dndv) =
        if mesh.normals().is_empty() { (DVec3::ZERO, DVec3::ZERO) } else { bending(mesh, index) };
    Parametric { uv: flat.uv, dpdu, dpdv: flipped(dpdv, reversed), dndu, dndv }
}

/// How the normals of the file change over a triangle.
fn bending(mesh: &Mesh, index: usize) -> (DVec3, DVec3) {
    let [n0, n1, n2] = mesh.triangle(index).map(|vertex| DVec3::from(mesh.normals()[vertex]));
    let fallback = || match (n2 - n0).cross(n1 - n0) {
        DVec3::ZERO => (DVec3::ZERO, DVec3::ZERO),
        across => pbrt_frame(across),
    };
    by_coordinates(coordinates(mesh, index), [n0 - n2, n1 - n2]).unwrap_or_else(fallback)
}

pub(crate) fn coordinates(mesh: &Mesh, index: usize) -> [DVec2; 3] {
    if mesh.uvs().is_empty() {
        return DEFAULT;
    }
    mesh.triangle(index).map(|vertex| DVec2::from(mesh.uvs()[vertex]))
}

/// Derivatives by u and v of what differs by `deltas` from the third corner to the first and second. `None` where the
/// coordinates span no area.
fn by_coordinates(uvs: [DVec2; 3], [d0, d1]: [DVec3; 2]) -> Option<(DVec3, DVec3)> {
    let (a, b) = (uvs[0] - uvs[2], uvs[1] - uvs[2]);
    let determinant = DMat2::from_cols(a, b).determinant();
    let by = |x: DVec3, y: DVec3| (x - y) / determinant;
    (determinant.abs() >= LEAST_AREA).then(|| (by(d0 * b.y, d1 * a.y), by(d1 * a.x, d0 * b.x)))
}
