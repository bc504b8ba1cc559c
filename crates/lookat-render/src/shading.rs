//! How a surface scatters light where a ray has hit it: from the material, its textures and its bumps.

mod coordinates;
pub(crate) mod lanes;

use glam::{DMat2, DVec2, DVec3};
use lookat_scene::Texture;

use crate::camera::CameraRay;
use crate::frame::{Frame, flipped};
use crate::parametric::Parametric;
use crate::surface::Surface;
use crate::texture::{Footprint, TexturePoint};
use crate::traceable::Traceable;
use coordinates::Coordinates;

/// Where on a surface its textures are looked up, and its shading frame there.
#[inline(always)]
pub(crate) fn point(
    scene: &Traceable,
    surface: &Surface,
    wo: DVec3,
    camera_ray: Option<&CameraRay>,
) -> (TexturePoint, Frame) {
    let material = &surface.primitive.material;
    let coordinates = Coordinates::new(scene, surface, wo);
    let footprint = match camera_ray {
        Some(camera_ray) if material.needs().footprint => footprint(surface, &coordinates.flat, camera_ray),
        _ => Footprint::default(),
    };
    let at = TexturePoint { p: surface.p, origin: scene.origin, uv: coordinates.flat.uv, footprint };
    let (ns, dpdu) = match material.bump() {
        Some(bump) => bumped(&at, bump, surface, &coordinates),
        None => (surface.ns, coordinates.shading.dpdu),
    };
    (at, Frame::from_zx(ns, dpdu))
}

/// How much the point of the surface and its coordinates change from a camera ray to its neighbors (PBR 10.1.1).
fn footprint(surface: &Surface, flat: &Parametric, camera_ray: &CameraRay) -> Footprint {
    let beside = camera_ray.neighbors().map(|(o, d)| {
        let t = surface.n.dot(surface.p - o) / surface.n.dot(d);
        o + d * t - surface.p
    });
    if !beside.iter().all(|dp| dp.is_finite()) {
        return Footprint::default();
    }
    // Two of the three equations, those along the axes that the surface faces least.
    let size = surface.n.abs();
    let pick = |v: DVec3| match () {
        () if size.x > size.y && size.x > size.z => DVec2::new(v.y, v.z),
        () if size.y > size.z => DVec2::new(v.x, v.z),
        () => DVec2::new(v.x, v.y),
    };
    let matrix = DMat2::from_cols(pick(flat.dpdu), pick(flat.dpdv));
    let inverse = matrix.inverse_or_zero();
    let solve = |dp| inverse * pick(dp);
    let duv = beside.map(|dp| Some(solve(dp)).filter(|duv| duv.is_finite()).unwrap_or_default());
    Footprint { dp: beside, duv }
}

/// The step in u or v where there is no neighbor, as in pbrt-v3.
const STEP: f64 = 0.0005;

/// The shading normal and dpdu of a surface that is bent by a height above it (PBR 9.3).
fn bumped(
    at: &TexturePoint,
    bump: &Texture<f64>,
    surface: &Surface,
    coordinates: &Coordinates,
) -> (DVec3, DVec3) {
    let shading = &coordinates.shading;
    let [dx, dy] = at.footprint.duv;
    let step = (dx.abs() + dy.abs()) * 0.5;
    let height = at.value(bump);
    let slope = |step: f64, along: DVec3, across: DVec2| {
        let step = if step == 0.0 { STEP } else { step };
        let moved = TexturePoint { p: at.p + along * step, uv: at.uv + across * step, ..*at };
        (moved.value(bump) - height) / step
    };
    let ns = surface.ns;
    let dpdu = shading.dpdu + ns * slope(step.x, shading.dpdu, DVec2::X) + shading.dndu * height;
    let dpdv = shading.dpdv + ns * slope(step.y, shading.dpdv, DVec2::Y) + shading.dndv * height;
    let across = dpdu.cross(dpdv);
    // A height of minus the radius leaves nothing but rounding.
    let is_left = across.length() > 1e-9 * shading.dpdu.length() * shading.dpdv.length();
    let Some(bent) = across.try_normalize().filter(|_| is_left) else { return (ns, shading.dpdu) };
    (flipped(bent, bent.dot(surface.n) < 0.0), dpdu)
}
