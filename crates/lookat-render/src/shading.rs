//! How surfaces scatter light where rays have hit them: from the material, its textures and its bumps.

mod coordinates;
pub(crate) mod shaded;

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::{DVec2, DVec3};
use lookat_scene::{Material, Texture};

use crate::camera::views::Views;
use crate::frame::Frames;
use crate::number::{LANES, Vec2x8, Vec3x8, baseline, bits, first_lanes, vectorized};
use crate::parametric::Parametrics;
use crate::ray::{Hit, Ray};
use crate::surface::Surface;
use crate::surface::points::Surfaces;
use crate::texture::{Footprint, TexturePoint};
use crate::trace::rays::{NONE, WORLD};
use crate::traceable::Traceable;
use coordinates::Coordinates;

/// A ray, and what it has hit.
pub(crate) type Found = (Ray, Hit);

/// The texture coordinates of a surface, where a ray has found it.
pub(crate) fn uv(scene: &Traceable, surface: &Surface, found: Found) -> DVec2 {
    baseline!(simd => {
        let none = Vec3x8::splat(simd, DVec3::ZERO);
        let (element, instance) = (NONE.simd_into(simd), WORLD.simd_into(simd));
        let mut surfaces = Surfaces { p: none, n: none, ns: none, magnitude: 0.0.simd_into(simd), element, instance };
        surfaces.put(0, surface);
        let mut all = [None; LANES];
        all[0] = Some(found);
        Coordinates::new(scene, &surfaces, &all, first_lanes(simd, 1)).flat.lane(0).uv
    })
}

/// Where on surfaces of a material its textures are looked up, and the shading frames there.
#[inline(always)]
fn points<S: Simd>(
    (scene, material): (&Traceable, &Material),
    surfaces: &Surfaces<S>,
    found: &[Option<Found>; LANES],
    views: Option<&Views>,
    active: mask64x8<S>,
) -> (TexturePoint<S>, Frames<f64x8<S>>) {
    let coordinates = Coordinates::new(scene, surfaces, found, active);
    let views = views.filter(|_| material.needs().footprint);
    let footprint = views.map(|views| footprint(surfaces, &coordinates.flat, views));
    let at = TexturePoint { p: surfaces.p, origin: scene.origin, uv: coordinates.flat.uv, footprint };
    let (ns, dpdu) = match material.bump() {
        Some(bump) => bumped(&at, bump, surfaces, &coordinates.shading, active),
        None => (surfaces.ns, coordinates.shading.dpdu),
    };
    (at, Frames::from_zx(ns, dpdu))
}

/// How much the points of surfaces and their coordinates change from camera rays to their neighbors (PBR 10.1.1).
#[inline(never)]
fn footprint<S: Simd>(surfaces: &Surfaces<S>, flat: &Parametrics<S>, views: &Views) -> Footprint<S> {
    let (simd, Surfaces { p, n, .. }) = (surfaces.magnitude.token(), *surfaces);
    vectorized!(simd, {
        let [right, below] = views.neighbors(simd).map(
            #[inline(always)]
            |(o, d)| o + d * (n.dot(p - o) / n.dot(d)) - p,
        );
        let is_there = bits(simd, views.direct) & is_finite(right) & is_finite(below);
        let none = Vec3x8::splat(simd, DVec3::ZERO);
        let (right, below) = (right.or(is_there, none), below.or(is_there, none));
        let sides = sides(n);
        let (a, b) = (pick(flat.dpdu, sides), pick(flat.dpdv, sides));
        let determinant = a[0] * b[1] - a[1] * b[0];
        let duv = [right, below].map(
            #[inline(always)]
            |dp| {
                let dp = pick(dp, sides);
                let u = (b[1] * dp[0] - b[0] * dp[1]) / determinant;
                let v = (a[0] * dp[1] - a[1] * dp[0]) / determinant;
                let (is_there, zero) = (u.is_finite() & v.is_finite(), f64x8::splat(simd, 0.0));
                [is_there.select(u, zero), is_there.select(v, zero)]
            },
        );
        Footprint { dp: [right, below], duv }
    })
}

/// Whether normals are nearest to x, and else whether to y.
#[inline(always)]
fn sides<S: Simd>(n: Vec3x8<S>) -> [mask64x8<S>; 2] {
    let (x, y, z) = (n.x.abs(), n.y.abs(), n.z.abs());
    [x.simd_gt(y) & x.simd_gt(z), y.simd_gt(z)]
}

/// Two of three coordinates, those along the axes that surfaces face least.
#[inline(always)]
fn pick<S: Simd>(v: Vec3x8<S>, [is_x, is_y]: [mask64x8<S>; 2]) -> Vec2x8<S> {
    [is_x.select(v.y, v.x), (is_x | is_y).select(v.z, v.y)]
}

#[inline(always)]
fn is_finite<S: Simd>(v: Vec3x8<S>) -> mask64x8<S> {
    v.x.is_finite() & v.y.is_finite() & v.z.is_finite()
}

/// The step in u or v where there is no neighbor, as in pbrt-v3.
const STEP: f64 = 0.0005;

/// The shading normals and dpdu of surfaces that are bent by a height above them (PBR 9.3).
#[inline(never)]
fn bumped<S: Simd>(
    at: &TexturePoint<S>,
    bump: &Texture<f64>,
    surfaces: &Surfaces<S>,
    shading: &Parametrics<S>,
    active: mask64x8<S>,
) -> (Vec3x8<S>, Vec3x8<S>) {
    let simd = active.token();
    vectorized!(simd, {
        let height = at.value(bump, active);
        let mut slopes = [f64x8::splat(simd, STEP); 2];
        for (axis, slope) in slopes.iter_mut().enumerate() {
            let mut step = *slope;
            if let Some(Footprint { duv: [x, y], .. }) = &at.footprint {
                let mean = (x[axis].abs() + y[axis].abs()) * 0.5;
                step = mean.simd_eq(0.0).select(step, mean);
            }
            let along = if axis == 0 { shading.dpdu } else { shading.dpdv };
            let mut moved = TexturePoint { p: at.p + along * step, ..*at };
            moved.uv[axis] += step;
            *slope = (moved.value(bump, active) - height) / step;
        }
        let ns = surfaces.ns;
        let dpdu = shading.dpdu + ns * slopes[0] + shading.dndu * height;
        let dpdv = shading.dpdv + ns * slopes[1] + shading.dndv * height;
        let across = dpdu.cross(dpdv);
        let (bent, is_there) = across.try_normalize();
        // A height of minus the radius leaves nothing but rounding.
        let whole = (shading.dpdu.length_squared() * shading.dpdv.length_squared()).sqrt();
        let is_there = is_there & across.length_squared().sqrt().simd_gt(1e-9 * whole);
        let bent = (-bent).or(bent.dot(surfaces.n).simd_lt(0.0), bent);
        (bent.or(is_there, ns), dpdu.or(is_there, shading.dpdu))
    })
}
