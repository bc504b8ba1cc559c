//! Paths of rays through a lens, to draw them.

use fearless_simd::f64x8;
use fearless_simd::prelude::*;
use lookat_scene::{Camera, Film, Lens};

use super::{RealisticLens, Traced};
use crate::number::{LANES, V3, baseline};

/// The most rays of a bundle.
const RAYS: usize = 7;
/// The rays that look for the edges of a bundle.
const PROBES: usize = 512;

/// Rays from a place on the film that get through the lens.
#[derive(Debug, Clone, PartialEq)]
pub struct LensRays {
    /// The height of the place above the axis.
    pub film: f64,
    /// Each ray: its points, as depth from the film and height, on the film and on each surface.
    pub points: Vec<Vec<[f64; 2]>>,
    /// The direction of each ray in front of the lens.
    pub directions: Vec<[f64; 2]>,
}

impl LensRays {
    /// Rays in a plane through the axis from heights of the film, as shares of half its diagonal. `None` without a lens system.
    pub fn new(camera: &Camera, film: &Film, shares: &[f64]) -> Option<Vec<LensRays>> {
        let lenses = camera.lens_system()?;
        let corner = camera.screen_unit(film) * camera.screen.max.length();
        let focus = camera.lens.map_or(Lens::UNFOCUSED, |lens| lens.focal_distance);
        let lens = RealisticLens::new(lenses, focus, corner);
        Some(shares.iter().map(|share| lens.bundle(share * corner)).collect())
    }
}

impl RealisticLens {
    /// Rays from a height of the film, evenly spread over those that get through.
    fn bundle(&self, film: f64) -> LensRays {
        let ellipse = self.pupil.ellipse(film.abs());
        let heights = |t: f64| (ellipse.center + ellipse.half_x * t) * if film < 0.0 { -1.0 } else { 1.0 };
        let probe = |at: usize| 2.0 * at as f64 / PROBES as f64 - 1.0;
        let passes = |at: &usize| self.paths(film, [heights(probe(*at)); LANES])[0].passes;
        let mut through = (0..=PROBES).filter(passes);
        let (first, last) = (through.next(), through.next_back());
        let (Some(first), Some(last)) = (first, last) else {
            return LensRays { film, points: Vec::new(), directions: Vec::new() };
        };
        let between = |ray: usize| {
            let share = ray.min(RAYS - 1) as f64 / (RAYS - 1) as f64;
            heights(probe(first) + (probe(last) - probe(first)) * share)
        };
        let paths = self.paths(film, std::array::from_fn(between));
        let (points, directions) = paths
            .into_iter()
            .take(RAYS)
            .filter(|path| path.passes)
            .map(|path| (path.points, path.direction))
            .unzip();
        LensRays { film, points, directions }
    }

    fn paths(&self, film: f64, heights: [f64; LANES]) -> [Path; LANES] {
        let mut points: [Vec<[f64; 2]>; LANES] = std::array::from_fn(|_| vec![[0.0, film]]);
        baseline!(simd => {
            let number = |x: f64| -> f64x8<_> { x.simd_into(simd) };
            let x: f64x8<_> = heights.simd_into(simd);
            let d = V3 { x: x - film, y: number(0.0), z: number(self.surfaces.rear) }.normalize();
            let start = Traced { o: V3 { x: number(film), y: number(0.0), z: number(0.0) }, d, clearance: number(1.0) };
            let traced = self.surfaces.trace_along(simd, start, |rays| {
                for (lane, points) in points.iter_mut().enumerate() {
                    points.push([rays.o.z[lane], rays.o.x[lane]]);
                }
            });
            let mut lane = 0..LANES;
            points.map(|points| {
                let lane = lane.next().unwrap_or(0);
                let direction = [traced.d.z[lane], traced.d.x[lane]];
                Path { points, direction, passes: traced.clearance[lane] >= 0.0 }
            })
        })
    }
}

/// A ray through the lens, blocked or not.
struct Path {
    points: Vec<[f64; 2]>,
    direction: [f64; 2],
    passes: bool,
}
