//! Samples of pixels.

use std::array::from_fn;
use std::ops::Range;

use glam::{DVec2, Vec3};
use lookat_scene::{Sampler, View};

use super::control::{Control, Meter};
use crate::camera::{CameraRay, CameraRays};
use crate::film::{Film, Pixel, Scale};
use crate::filter::FilterSampler;
use crate::integrator::lanes::Lanes;
use crate::integrator::{FirstHit, Tracer};
use crate::prepare::Prepared;
use crate::sampler::SampleStream;
use crate::trace::BUNDLE;

/// What every sample needs.
pub(super) struct Context<'a, F> {
    pub(super) prepared: &'a Prepared,
    pub film: &'a Film<'a>,
    /// That of the film.
    pub(super) scale: Scale,
    pub control: &'a Control<'a>,
    pub(super) filter: &'a FilterSampler,
    pub(super) camera: CameraRays,
    /// The distance of samples on the film, in pixels.
    pub(super) spacing: f64,
    /// Light along a camera ray.
    li: F,
    /// The same for samples side by side, of scenes that it serves for.
    pub(super) lanes: Option<Lanes<'a>>,
}

impl<'a, F> Context<'a, F> {
    /// `nominal_samples`: those of a pixel that textures are filtered for. They have to be known in advance, so that all
    /// samples of a pixel have one mean.
    pub fn new(
        prepared: &'a Prepared,
        view: &View,
        nominal_samples: u32,
        (filter, film, control): (&'a FilterSampler, &'a Film<'a>, &'a Control<'a>),
        li: F,
    ) -> Self {
        Context {
            prepared,
            film,
            scale: film.scale(),
            control,
            filter,
            camera: prepared.camera(view),
            spacing: f64::from(nominal_samples).sqrt().recip(),
            li,
            lanes: Lanes::new(view, &prepared.traceable, &prepared.lights),
        }
    }

    pub fn tracer(&self) -> Tracer<'a> {
        Tracer::new(&self.prepared.traceable, &self.prepared.lights)
    }
}

/// Where the samples of a pixel lie.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pattern {
    pub sampler: Sampler,
    pub seed: u64,
    /// Whether the bounds and squares of the samples are asked for.
    pub is_watched: bool,
}

/// Samples to take of a pixel.
#[derive(Debug, Clone)]
pub(super) struct Job {
    pub pattern: Pattern,
    pub place: [u32; 2],
    /// Which of the pattern.
    pub indices: Range<u32>,
    /// What has become of them.
    pub samples: Samples,
}

impl Job {
    pub fn new(pattern: Pattern, place: [u32; 2], indices: Range<u32>) -> Job {
        Job { pattern, place, indices, samples: Samples::default() }
    }
}

/// What samples have shown.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Samples {
    pub pixel: Pixel,
    /// Only of patterns that are watched.
    pub seen: Seen,
    /// The sum of their squared lengths; likewise.
    pub squares: f64,
    /// How many were infinite or not a number.
    pub rejected: u64,
    /// How many were brighter than the film's sums hold.
    pub clamped: u64,
}

/// Bounds of samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Seen {
    pub least: Vec3,
    pub most: Vec3,
}

impl Default for Seen {
    fn default() -> Self {
        Seen::NOTHING
    }
}

impl Seen {
    pub const NOTHING: Seen = Seen { least: Vec3::INFINITY, most: Vec3::NEG_INFINITY };

    pub fn union(self, other: Seen) -> Seen {
        Seen { least: self.least.min(other.least), most: self.most.max(other.most) }
    }

    /// How far apart they are; 0 where there is nothing.
    pub fn range(self) -> Vec3 {
        (self.most - self.least).max(Vec3::ZERO)
    }
}

impl<F> Context<'_, F>
where
    F: Fn(&mut Tracer, &FirstHit, &mut SampleStream) -> Vec3,
{
    /// Does jobs, which are all for one kind and number of samples, as long as there is time: some may be left.
    pub fn sample_all(&self, tracer: &mut Tracer, meter: &mut Meter, jobs: &mut [Job]) {
        if let Some(lanes) = &self.lanes {
            return self.sample_side_by_side(lanes, tracer, meter, jobs);
        }
        for job in jobs {
            let mut from = job.indices.start;
            while from < job.indices.end {
                let to = job.indices.end.min(from.saturating_add(meter.batch()));
                self.sample(tracer, job, from..to);
                if !meter.add(to - from, tracer.rays) {
                    return;
                }
                from = to;
            }
        }
    }

    /// Takes some samples of a job: those whose camera rays are traced together, and those that are left.
    fn sample(&self, tracer: &mut Tracer, job: &mut Job, indices: Range<u32>) {
        let Job { pattern, place, samples, .. } = job;
        let mut stream = SampleStream::new(&pattern.sampler, pattern.seed, *place);
        let mut from = indices.start;
        if indices.len() >= BUNDLE {
            // Apart from what else there is of a sample, and used again: large values are best not moved.
            let mut streams: [_; BUNDLE] = from_fn(|_| stream.clone());
            while let Some(to) = from.checked_add(BUNDLE as u32).filter(|to| *to <= indices.end) {
                let starts = from_fn(|k| self.start(&mut streams[k], *place, from + k as u32));
                let rays = starts.each_ref().map(|start: &Start| start.camera_ray.ray());
                let hits = tracer.nearest_of(&rays);
                for (k, Start { camera_ray, negative }) in starts.iter().enumerate() {
                    let first = FirstHit { camera_ray, ray: &rays[k], hit: hits[k].as_ref() };
                    self.follow(tracer, pattern, &first, *negative, &mut streams[k], samples);
                }
                from = to;
            }
        }
        for index in from..indices.end {
            let Start { camera_ray, negative } = self.start(&mut stream, *place, index);
            let ray = camera_ray.ray();
            let hit = tracer.nearest(&ray);
            let first = FirstHit { camera_ray: &camera_ray, ray: &ray, hit: hit.as_ref() };
            self.follow(tracer, pattern, &first, negative, &mut stream, samples);
        }
    }

    /// Begins a sample of a pixel.
    #[inline(always)]
    fn start(&self, stream: &mut SampleStream, place: [u32; 2], index: u32) -> Start<'_> {
        stream.restart(index);
        let (offset, negative) = self.filter.sample(stream.next_2d());
        let on_lens = if self.camera.has_lens() { stream.next_2d() } else { DVec2::ZERO };
        let camera_ray = CameraRay {
            camera: &self.camera,
            film: center_of(place) + offset,
            on_lens,
            spacing: self.spacing,
        };
        Start { camera_ray, negative }
    }

    /// Adds the light along a camera ray to the samples of its pixel. Not inlined, so that there is one copy of the
    /// integrator.
    #[inline(never)]
    fn follow(
        &self,
        tracer: &mut Tracer,
        pattern: &Pattern,
        first: &FirstHit,
        negative: bool,
        stream: &mut SampleStream,
        samples: &mut Samples,
    ) {
        let radiance = (self.li)(tracer, first, stream);
        self.add(pattern, radiance, negative, samples);
    }

    /// Adds the radiance of a sample to those of its pixel.
    #[inline(always)]
    pub(super) fn add(&self, pattern: &Pattern, mut radiance: Vec3, negative: bool, samples: &mut Samples) {
        if !radiance.is_finite() {
            samples.rejected += 1;
            radiance = Vec3::ZERO;
        }
        let radiance = self.film.limited(radiance);
        samples.clamped += u64::from(self.scale.clamps(radiance));
        samples.pixel.add(radiance, negative, self.scale);
        if pattern.is_watched {
            samples.squares += radiance.as_dvec3().length_squared();
            samples.seen = samples.seen.union(Seen { least: radiance, most: radiance });
        }
    }
}

/// What a sample starts with.
struct Start<'c> {
    camera_ray: CameraRay<'c>,
    /// Whether the filter is negative there.
    negative: bool,
}

/// The middle of a pixel on the film.
#[inline(always)]
pub(super) fn center_of(place: [u32; 2]) -> DVec2 {
    DVec2::new(f64::from(place[0]) + 0.5, f64::from(place[1]) + 0.5)
}
