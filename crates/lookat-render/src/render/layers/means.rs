//! Layers that are means over the camera samples of a pixel.

use arrayvec::ArrayVec;
use fearless_simd::{Simd, prelude::*};
use glam::{DVec3, Vec3};

use super::{Layer, Values};
use crate::bsdf::LobeSlots;
use crate::camera::Viewer;
use crate::film::Area;
use crate::integrator::path_record::{PATHS, PathRecord};
use crate::integrator::world::Sees;
use crate::number::{LANES, set_lanes, side_by_side};
use crate::render::rounds::Pass;
use crate::render::sample::Context;
use crate::render::sample::Worker;
use crate::sampler::Sample;

/// The layers, and the least that their values can be.
const LAYERS: [(Layer, f64); 3] = [(Layer::Normal, -1.0), (Layer::ShadingNormal, -1.0), (Layer::Albedo, 0.0)];

/// The value of each layer for a sample.
type LayerValues = [DVec3; LAYERS.len()];

/// Weighted samples of a pixel, and their weights.
#[derive(Clone, Copy, Default)]
struct Sums {
    seen: LayerValues,
    weight: f64,
}

impl Sums {
    fn add(&mut self, seen: &LayerValues, weight: f64) {
        for (sum, seen) in self.seen.iter_mut().zip(seen) {
            *sum += *seen * weight;
        }
        self.weight += weight;
    }
}

impl Context<'_> {
    /// Averages over the camera samples of a tile. The picture has the same samples if it has the scene's samples per pixel.
    /// False after an interruption.
    pub(super) fn average(
        &self,
        worker: &mut Worker,
        passes: &[Pass],
        bounds: Area,
        values: &mut [Values],
    ) -> bool {
        let mut sums = vec![Sums::default(); values.len()];
        let (filter, reach) = (&self.film.filter, self.film.filter.reach());
        let mut weights = Default::default();
        for Pass { pattern, samples, .. } in passes {
            let of_source =
                |pixel| samples.clone().map(move |index| Sample { seed: pattern.seed, pixel, index });
            let mut all = bounds.grown(reach).pixels().flat_map(of_source);
            loop {
                let samples: ArrayVec<Sample, PATHS> = all.by_ref().take(PATHS).collect();
                if samples.is_empty() {
                    break;
                }
                if self.control.is_interrupted() {
                    return false;
                }
                worker.streams.restart(&pattern.sampler, &samples);
                let mut seen = [LayerValues::default(); PATHS];
                side_by_side!(self.prepared.traceable.level, simd => self.layer_values(simd, worker, &samples, &mut seen));
                let squares = worker.squares.iter().zip(&worker.weights);
                for (((square, weight), seen), Sample { pixel: [x, y], .. }) in
                    squares.zip(&seen).zip(&samples)
                {
                    // A lens makes the corners of a picture dark, but not their normals shorter.
                    if *weight == 0.0 {
                        continue;
                    }
                    filter.weigh(*square, &mut weights);
                    let [across, down] = [&weights[0], &weights[1]].map(|weights| weights.iter().zip(0..));
                    for (down, dy) in down {
                        for (across, dx) in across.clone() {
                            let pixel = [x - reach[0].cast_signed() + dx, y - reach[1].cast_signed() + dy];
                            if bounds.contains(pixel) {
                                sums[bounds.index(pixel)].add(seen, across * down);
                            }
                        }
                    }
                }
            }
        }
        for (sums, values) in sums.iter().zip(values) {
            for (at, (layer, least)) in LAYERS.iter().enumerate() {
                let value = sums.seen[at] / if sums.weight == 0.0 { 1.0 } else { sums.weight };
                values[*layer as usize] = value.clamp(DVec3::splat(*least), DVec3::ONE);
            }
        }
        true
    }

    /// Sets the layer values of camera samples, from the first surface with a material.
    #[inline(always)]
    fn layer_values<S: Simd>(
        &self,
        simd: S,
        worker: &mut Worker,
        samples: &[Sample],
        seen: &mut [LayerValues; PATHS],
    ) {
        self.start_paths(simd, worker, samples);
        let Worker { tracer, batch, .. } = worker;
        let (world, camera_samples) = (self.integrator.world(), batch.camera_samples);
        let viewer = Viewer { camera: &self.camera, spacing: self.spacing };
        let columns = batch.camera_paths();
        world.nearest_of_camera(simd, tracer, &columns.rays, columns.all(), &mut columns.hits);
        let paths = &mut PathRecord::none(simd);
        for first in (0..columns.count).step_by(LANES) {
            columns.load(simd, first, columns.count, paths);
            world.pass(simd, tracer, paths, Sees::Nothing, |_, _| {});
            paths.active &= paths.hits.is_hit();
            if !paths.active.any_true() {
                continue;
            }
            let mut slots = LobeSlots::new();
            let views = paths.views(viewer, &camera_samples);
            let surfaces = world.shaded(simd, tracer, paths, Some(&views), &mut slots).found.surfaces;
            let n = surfaces.n.face_forward(-paths.rays.d.narrow()).widen();
            let ns = surfaces.ns.face_forward(n);
            let albedo = slots.albedo(simd);
            for lane in set_lanes(paths.active) {
                let albedo = albedo.lane(lane).max(Vec3::ZERO).min(Vec3::ONE).as_dvec3();
                seen[usize::from(paths.samples[lane])] = [n.lane(lane), ns.lane(lane), albedo];
            }
        }
    }
}
