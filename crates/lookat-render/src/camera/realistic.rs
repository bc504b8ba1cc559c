//! Rays from a film through a system of lenses (PBR 6.4), and the exit pupil that they are aimed at.

mod exit_pupil;
mod paths;
#[cfg(test)]
mod tests;

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use lookat_scene::{LensSystem, Weighting};

use crate::camera::realistic::exit_pupil::{ExitPupil, simple_area};
pub use crate::camera::realistic::paths::LensRays;
use crate::number::{V3, Vec2x8, Vec3x8, vectorized};
use crate::warp::square_to_disk;

/// A system of lenses in focus, prepared to send rays from its film.
#[derive(Debug)]
pub(super) struct RealisticLens {
    surfaces: Surfaces,
    pupil: ExitPupil,
    /// The weight of a ray along the axis from a pupil of area 1.
    weight: f64,
}

/// The surfaces of a lens from the film to the scene.
#[derive(Debug)]
pub(super) struct Surfaces {
    surfaces: Vec<Surface>,
    /// The depth of the vertex of the rear surface, which is next to the film.
    pub rear: f64,
    /// The radius of its opening.
    pub rear_radius: f64,
}

/// A surface, in camera space: the film is at z = 0, and the scene at larger z.
#[derive(Debug, Clone, Copy)]
struct Surface {
    /// The depth of its vertex.
    z: f64,
    /// One over its radius, positive if the center is on the side of the scene. 0 for the stop.
    curvature: f64,
    /// The index of refraction on the side of the film, divided by that on the side of the scene.
    eta: f64,
    /// One over the square of the radius of its opening.
    opening: f64,
}

/// Rays that have gone through a lens.
#[derive(Clone, Copy)]
pub(super) struct Traced<S: Simd> {
    /// Origins on the last surface that the rays have met, and unit directions.
    pub o: Vec3x8<S>,
    pub d: Vec3x8<S>,
    /// The least of 1 - (r / a)², over surfaces with openings of radius a that a ray meets at distance r from the axis. Negative for rays
    /// that the lens blocks.
    pub clearance: f64x8<S>,
}

/// Rays of a camera, and their weights.
pub(super) struct Weighted<S: Simd> {
    pub o: Vec3x8<S>,
    pub d: Vec3x8<S>,
    /// 0 for rays that the lens blocks.
    pub weights: f64x8<S>,
}

/// The clearance of rays that miss a surface, or are reflected by it.
const LOST: f64 = -1e30;

impl Surfaces {
    /// The surfaces of a lens at a distance from its film.
    pub fn new(lenses: &LensSystem, film_distance: f64) -> Surfaces {
        let mut z = film_distance;
        let mut surfaces: Vec<Surface> = Vec::new();
        for (at, element) in lenses.elements.iter().enumerate().rev() {
            if !surfaces.is_empty() {
                z += element.thickness;
            }
            let (curvature, eta) = match element.is_stop() {
                true => (0.0, 1.0),
                false => (-1.0 / element.curvature_radius, element.eta / lenses.eta_before(at)),
            };
            let opening = element.aperture_radius.powi(-2);
            surfaces.push(Surface { z, curvature, eta, opening });
        }
        let rear_radius = lenses.elements.last().map_or(0.0, |element| element.aperture_radius);
        Surfaces { surfaces, rear: film_distance, rear_radius }
    }

    /// Traces rays with unit directions from the film into the scene. A ray that misses a surface ends at the one before; others go on,
    /// blocked or not.
    #[inline(always)]
    pub fn trace<S: Simd>(&self, simd: S, o: Vec3x8<S>, d: Vec3x8<S>) -> Traced<S> {
        self.trace_along(
            simd,
            Traced { o, d, clearance: 1.0.simd_into(simd) },
            #[inline(always)]
            |_| {},
        )
    }

    /// Traces rays, and tells where they are after each surface.
    #[inline(always)]
    pub fn trace_along<S: Simd>(
        &self,
        simd: S,
        mut traced: Traced<S>,
        mut met: impl FnMut(&Traced<S>),
    ) -> Traced<S> {
        for surface in &self.surfaces {
            surface.refract(simd, &mut traced);
            met(&traced);
        }
        traced
    }
}

impl Surface {
    /// Takes rays to this surface and refracts them there.
    #[inline(always)]
    fn refract<S: Simd>(&self, simd: S, rays: &mut Traced<S>) {
        let Surface { z, curvature, eta, opening } = *self;
        let zero: f64x8<S> = 0.0.simd_into(simd);
        let (d, o) = (rays.d, V3 { z: rays.o.z - z, ..rays.o });
        // Of the two intersections with the sphere, the one on the side of its vertex; without cancellation, also for a plane.
        let b = o.dot(d) * curvature - d.z;
        let c = o.length_squared() * curvature - o.z * 2.0;
        let discriminant = b * b - c * curvature;
        let t = c / (discriminant.max(0.0).sqrt() - b);
        let p = o + d * t;
        // The normal faces the film.
        let n = V3 { x: p.x * curvature, y: p.y * curvature, z: p.z * curvature - 1.0 };
        let cos_in = -d.dot(n);
        let sin2_out = (1.0 - cos_in * cos_in) * (eta * eta);
        let cos_out = (1.0 - sin2_out).max(0.0).sqrt();
        let eta: f64x8<S> = eta.simd_into(simd);
        let refracted = d * eta + n * (cos_in * eta - cos_out);
        let meets = discriminant.simd_ge(zero) & t.simd_ge(zero) & d.z.simd_gt(zero) & cos_in.simd_gt(zero);
        let is_through: mask64x8<S> = meets & sin2_out.simd_lt(1.0);
        let clearance = rays.clearance.min(1.0 - (p.x * p.x + p.y * p.y) * opening);
        rays.clearance = is_through.select(clearance, LOST.simd_into(simd));
        rays.o = V3 { z: p.z + z, ..p }.keep_where(is_through, rays.o);
        rays.d = refracted.keep_where(is_through, rays.d);
    }
}

impl RealisticLens {
    /// A lens that focuses on a distance from the film, whose corners are at `corner` from its middle.
    pub fn new(lenses: &LensSystem, focus_distance: f64, corner: f64) -> RealisticLens {
        let focal_length = lenses.thick_lens().map_or(0.0, |lens| lens.focal_length);
        let film_distance = lenses.film_distance(focus_distance).unwrap_or(focal_length);
        let surfaces = Surfaces::new(lenses, film_distance);
        let pupil = ExitPupil::new(&surfaces, corner);
        let weight = match lenses.weighting {
            Weighting::Simple => 1.0 / simple_area(&surfaces, &pupil, corner),
            Weighting::Exposure { time } => time / (film_distance * film_distance),
        };
        RealisticLens { surfaces, pupil, weight }
    }

    /// Rays from places of the film through points of the exit pupil that `u` chooses, with unit directions.
    #[inline(never)]
    pub fn rays<S: Simd>(&self, simd: S, film: Vec2x8<S>, u: Vec2x8<S>) -> Weighted<S> {
        // Out of line, for the instruction cache of other cameras.
        vectorized!(simd, {
            let bounds = self.pupil.at(simd, film);
            let [x, y] = square_to_disk(u);
            let [x, y] = bounds.place([x, y]);
            let rear: f64x8<S> = self.surfaces.rear.simd_into(simd);
            let zero: f64x8<S> = 0.0.simd_into(simd);
            let o = V3 { x: film[0], y: film[1], z: zero };
            let d = V3 { x: x - film[0], y: y - film[1], z: rear }.normalize();
            let traced = self.surfaces.trace(simd, o, d);
            let cos2 = d.z * d.z;
            let weights = cos2 * cos2 * bounds.area() * self.weight;
            let weights = traced.clearance.simd_ge(zero).select(weights, zero);
            Weighted { o: traced.o, d: traced.d, weights }
        })
    }
}
