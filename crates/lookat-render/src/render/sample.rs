//! Takes the samples of pixels, eight side by side, and first probes how bright they are, for the scale of the film's sums.

#[cfg(test)]
mod tests;

use std::ops::Range;

use arrayvec::ArrayVec;
use fearless_simd::{Simd, f32x8, prelude::*};
use glam::{DVec2, DVec3, Vec3};
use lookat_scene::{Sampler, SamplerKind, View};
use serde::{Deserialize, Serialize};

use super::Settings;
use super::control::{Control, Meter};
use crate::camera::{CameraRays, CameraSample, Viewer};
use crate::film::{Film, ImageBlock, Scale};
use crate::integrator::{
    SceneIntegrator, Stage, Tracer,
    path_batch::PathBatch,
    path_record::{PATHS, PathRecord},
};
use crate::number::{LANES, first_lanes, side_by_side, vectorized, widen};
use crate::prepare::{Brightest, Prepared};
use crate::sampler::{Sample, Streams};
use crate::trace::rays::Rays;

/// The context of all samples of a rendering.
pub(super) struct Context<'a> {
    pub(super) prepared: &'a Prepared,
    pub film: &'a Film<'a>,
    /// The scale of the film.
    pub(super) scale: Scale,
    pub control: &'a Control<'a>,
    pub(super) camera: CameraRays,
    /// The distance between samples on the film, in pixels.
    pub(super) spacing: f64,
    pub(super) integrator: SceneIntegrator<'a>,
}

impl<'a> Context<'a> {
    /// The samples per pixel that texture filtering assumes have to be known in advance, so that all samples of a pixel have one mean.
    pub fn new(
        prepared: &'a Prepared,
        view: &View,
        settings: &Settings,
        (film, control): (&'a Film<'a>, &'a Control<'a>),
    ) -> Self {
        Context {
            prepared,
            film,
            scale: film.scale(),
            control,
            camera: prepared.camera(view),
            spacing: f64::from(settings.nominal_samples(view)).sqrt().recip(),
            integrator: SceneIntegrator::new(&view.integrator, &prepared.traceable, &prepared.lights),
        }
    }
}

/// The pattern of the samples of a pixel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pattern {
    pub sampler: Sampler,
    pub seed: u64,
    /// True to record the bounds, the sum and the squares of the samples.
    pub is_watched: bool,
}

/// Samples to take of a pixel.
#[derive(Debug, Clone)]
pub(super) struct Job {
    pub pattern: Pattern,
    pub pixel: [i32; 2],
    /// The indices of the samples in the pattern.
    pub indices: Range<u32>,
    /// The weight of each sample.
    pub weight: f64,
    /// The statistics of the samples taken.
    pub samples: Samples,
}

impl Job {
    pub fn new(pattern: Pattern, pixel: [i32; 2], indices: Range<u32>) -> Job {
        Job { pattern, pixel, indices, weight: 1.0, samples: Samples::default() }
    }

    /// True if all samples were taken.
    pub fn is_whole(&self) -> bool {
        self.samples.count as usize == self.indices.len()
    }
}

/// Statistics of samples.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Samples {
    pub count: u32,
    /// Only of patterns that are watched.
    pub sample_bounds: SampleBounds,
    /// The sum of the samples, and the sum of their squared lengths, under the same condition.
    pub sum: DVec3,
    pub squares: f64,
    /// The number of samples that were infinite or not a number.
    pub rejected: u64,
    /// The number of samples that were brighter than the sums of the film can hold.
    pub clamped: u64,
}

/// The range of sample values in each channel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct SampleBounds {
    pub least: Vec3,
    pub most: Vec3,
}

impl Default for SampleBounds {
    fn default() -> Self {
        SampleBounds::EMPTY
    }
}

impl SampleBounds {
    pub const EMPTY: SampleBounds = SampleBounds { least: Vec3::INFINITY, most: Vec3::NEG_INFINITY };

    pub fn union(self, other: SampleBounds) -> SampleBounds {
        SampleBounds { least: self.least.min(other.least), most: self.most.max(other.most) }
    }

    /// The size of the range; 0 for an empty range.
    pub fn range(self) -> Vec3 {
        (self.most - self.least).max(Vec3::ZERO)
    }
}

impl Context<'_> {
    /// Adds the radiance of a sample, which lies at `square` in the unit square of its pixel, to those of its job and to an image block.
    #[inline(always)]
    pub(super) fn add(
        &self,
        (square, mut radiance): (DVec2, Vec3),
        block: Option<&mut ImageBlock>,
        Job { pattern, pixel: source, weight, samples, .. }: &mut Job,
    ) {
        if !radiance.is_finite() {
            samples.rejected += 1;
            radiance = Vec3::ZERO;
        }
        let radiance = self.film.limited(radiance);
        samples.clamped += u64::from(self.scale.clamps(radiance));
        samples.count += 1;
        let sample = self.scale.clamped(radiance);
        if let Some(block) = block {
            block.add(&self.film.filter, *source, square, self.scale.units(sample.extend(1.0) * *weight));
        }
        if pattern.is_watched {
            samples.sum += sample;
            samples.squares += sample.length_squared();
            samples.sample_bounds =
                samples.sample_bounds.union(SampleBounds { least: radiance, most: radiance });
        }
    }
}

/// The corner of a pixel on the film.
#[inline(always)]
pub(super) fn corner_of([x, y]: [i32; 2]) -> DVec2 {
    DVec2::new(x.into(), y.into())
}

/// Pixels of the full picture across which brightness is looked for, in each direction.
const PROBES: u32 = 16;

/// A sample may be eight times as bright as the brightest light that a camera ray can hit: [`Scale`] has room for 2^31.
const SHARE_OF_BRIGHTEST: f64 = 1.0 / (1 << 28) as f64;

impl Context<'_> {
    /// Sets the scale of sums: by the root mean square of a few samples that depend on no seed and no crop window, and by the
    /// brightest light, which these samples may miss.
    pub fn expose(&mut self) {
        let sampler = Sampler { kind: SamplerKind::SOBOL, samples_per_pixel: 1 };
        let pattern = Pattern { sampler, seed: 0, is_watched: true };
        let [width, height] = self.film.settings.resolution.map(u64::from);
        let pixel = |at: u64| {
            let [x, y] = [at % u64::from(PROBES), at / u64::from(PROBES)];
            [x * width, y * height].map(|at| (at / u64::from(PROBES)) as i32)
        };
        let jobs = (0..u64::from(PROBES).pow(2)).map(|at| Job::new(pattern, pixel(at), 0..1));
        let mut jobs: Vec<Job> = jobs.collect();
        self.sample_all(&mut Worker::new(self), &mut Meter::silent(self.control), &mut jobs);
        if self.control.is_stopped() {
            // The scale is not known.
            return;
        }
        let squares: f64 = jobs.iter().map(|job| job.samples.squares).sum();
        let seen = (squares / f64::from(PROBES.pow(2))).sqrt();
        let Brightest { emitted, intensity } = self.prepared.brightest;
        let brightness = seen.max(emitted * SHARE_OF_BRIGHTEST);
        // Where the samples see nothing, the light of points and directions is all that is known.
        let brightness = if brightness > 0.0 { brightness } else { intensity };
        if brightness > 0.0 && brightness.is_finite() {
            self.scale = Scale::new(brightness);
        }
        self.film.set_scale(self.scale);
    }
}

/// A sample of a job.
#[derive(Debug, Clone, Copy)]
pub(super) struct JobSample {
    /// The number of the job.
    pub job: usize,
    /// The index of the sample in the pattern.
    pub index: u32,
}

/// Takes samples on one thread, and owns the buffers that its batches reuse.
pub(super) struct Worker<'a> {
    pub tracer: Tracer<'a>,
    pub streams: Streams,
    pub batch: Box<PathBatch>,
    /// The position of each sample in the unit square of its pixel.
    pub squares: [DVec2; PATHS],
    /// The weights of the camera rays. 1 without a lens system.
    pub weights: [f32; PATHS],
    /// The block of film that samples are added to. `None` if no picture is made.
    pub block: Option<ImageBlock>,
}

impl<'a> Worker<'a> {
    pub fn new(context: &Context<'a>) -> Self {
        Worker {
            tracer: Tracer::new(&context.prepared.traceable, &context.prepared.lights)
                .supervised(context.control),
            streams: Streams::new(),
            batch: Box::new(PathBatch::new()),
            squares: [DVec2::ZERO; PATHS],
            weights: [1.0; PATHS],
            block: None,
        }
    }
}

impl Context<'_> {
    /// Works through jobs, which share a sampler, until time runs out: some may remain. The samples of one pixel are added in
    /// their order.
    pub(super) fn sample_all(&self, worker: &mut Worker, meter: &mut Meter, jobs: &mut [Job]) {
        let Some(Job { indices, .. }) = jobs.first() else { return };
        let (mut number, mut index) = (0, indices.start);
        loop {
            let (mut taken, most) = (ArrayVec::<JobSample, PATHS>::new(), meter.batch());
            while taken.len() < most && number < jobs.len() {
                if index < jobs[number].indices.end {
                    taken.push(JobSample { job: number, index });
                    index += 1;
                } else {
                    number += 1;
                    index = jobs.get(number).map_or(0, |job| job.indices.start);
                }
            }
            if taken.is_empty() {
                return;
            }
            if !self.sample_jobs(worker, jobs, &taken) || !meter.add(taken.len() as u32, worker.tracer.rays) {
                return;
            }
        }
    }

    /// Takes samples and adds them to their jobs. False, without adding them, if the rendering stops meanwhile.
    ///
    /// A batch that is broken off is dropped as a whole, with the samples that are finished. Keeping them would favor short paths, which
    /// are darker than long ones. So each pixel has the first samples of its pattern, slow or fast.
    pub(super) fn sample_jobs(&self, worker: &mut Worker, jobs: &mut [Job], taken: &[JobSample]) -> bool {
        worker.tracer.profile(|profiler| profiler.enter(Stage::Camera));
        let sample = |JobSample { job, index }: &JobSample| {
            let Job { pattern, pixel, .. } = &jobs[*job];
            Sample { seed: pattern.seed, pixel: *pixel, index: *index }
        };
        let samples: ArrayVec<Sample, PATHS> = taken.iter().map(sample).collect();
        let sampler = &jobs[taken[0].job].pattern.sampler;
        debug_assert!(taken.iter().all(|sample| jobs[sample.job].pattern.sampler == *sampler));
        worker.streams.restart(sampler, &samples);
        side_by_side!(self.prepared.traceable.level, simd => self.take(simd, worker, &samples));
        worker.tracer.profile(|profiler| profiler.enter(Stage::Film));
        if worker.tracer.is_stopped {
            return false;
        }
        side_by_side!(self.prepared.traceable.level, simd => self.add_all(simd, worker, jobs, taken));
        true
    }

    /// Adds samples to their jobs and to the image block.
    #[inline(never)]
    fn add_all<S: Simd>(&self, simd: S, worker: &mut Worker, jobs: &mut [Job], taken: &[JobSample]) {
        vectorized!(simd, {
            for (at, JobSample { job, .. }) in taken.iter().enumerate() {
                let sample = (worker.squares[at], worker.batch.radiance[at]);
                self.add(sample, worker.block.as_mut(), &mut jobs[*job]);
            }
        });
    }

    /// Takes samples.
    #[inline(always)]
    fn take<S: Simd>(&self, simd: S, worker: &mut Worker, samples: &[Sample]) {
        self.start_paths(simd, worker, samples);
        let viewer = Viewer { camera: &self.camera, spacing: self.spacing };
        let Worker { tracer, streams, batch, weights, .. } = worker;
        self.integrator.li(simd, tracer, streams, batch, viewer);
        if self.camera.has_weights() {
            for (radiance, weight) in batch.radiance.iter_mut().zip(weights) {
                *radiance *= *weight;
            }
        }
    }

    /// Starts the paths of samples in the batch of a worker.
    #[inline(always)]
    pub(super) fn start_paths<S: Simd>(&self, simd: S, worker: &mut Worker, samples: &[Sample]) {
        worker.batch.clear();
        if self.integrator.world().media.is_some() {
            for (seed, sample) in worker.tracer.seeds.iter_mut().zip(samples) {
                *seed = sample.hash();
            }
        }
        for first in (0..samples.len()).step_by(LANES) {
            let count = LANES.min(samples.len() - first);
            let own = std::array::from_fn(|lane| (first + lane.min(count - 1)) as u16);
            let rays = self.camera_rays(simd, worker, samples, (first, own));
            let mut active = first_lanes(simd, count);
            if self.camera.has_weights() {
                let weights: f32x8<S> = own.map(|sample| worker.weights[usize::from(sample)]).simd_into(simd);
                active &= widen(weights.simd_gt(0.0));
            }
            let paths = PathRecord::new(simd, rays, own, active);
            worker.batch.camera_paths().push(&paths);
        }
    }

    /// The camera rays of up to eight samples, from one on.
    #[inline(never)]
    fn camera_rays<S: Simd>(
        &self,
        simd: S,
        worker: &mut Worker,
        samples: &[Sample],
        (first, own): (usize, [u16; LANES]),
    ) -> Rays<S> {
        vectorized!(simd, {
            let samples = &samples[first..samples.len().min(first + LANES)];
            let streams = &mut worker.streams;
            streams.choose(simd, &own, 0);
            let mut film = streams.next_2d(simd);
            for (lane, Sample { pixel, .. }) in samples.iter().enumerate() {
                let square = DVec2::new(film[0][lane], film[1][lane]);
                (film[0][lane], film[1][lane]) = (corner_of(*pixel) + square).into();
                worker.squares[first + lane] = square;
            }
            let camera = &self.camera;
            let on_lens = camera.has_lens().then(|| streams.next_2d(simd));
            let moves = camera.moves() || self.prepared.traceable.has_motion();
            let time = if moves { camera.times(streams.time(simd)) } else { 0.0.simd_into(simd) };
            // Nothing else asks for these.
            if self.integrator.world().materials.has_textures {
                for lane in 0..samples.len() {
                    let lens = on_lens.as_ref().map_or(DVec2::ZERO, |[u, v]| DVec2::new(u[lane], v[lane]));
                    let film = DVec2::new(film[0][lane], film[1][lane]);
                    let time = time[lane];
                    worker.batch.camera_samples[first + lane] = CameraSample { film, lens, time };
                }
            }
            let (rays, weights) = camera.weighted_rays(simd, film, on_lens, time);
            if let Some(weights) = weights {
                for lane in 0..samples.len() {
                    worker.weights[first + lane] = weights[lane] as f32;
                }
            }
            rays
        })
    }
}
