//! Taking samples, of one pixel or several: eight side by side.

#[cfg(test)]
mod tests;

use arrayvec::ArrayVec;
use fearless_simd::Simd;
use glam::DVec2;

use super::control::Meter;
use super::sample::{Context, Job, corner_of};
use crate::camera::Viewer;
use crate::film::Frame;
use crate::integrator::wave::{WAVE, Wave};
use crate::integrator::{Stage, Tracer};
use crate::number::{LANES, side_by_side, vectorized};
use crate::sampler::{Sample, Streams};
use crate::trace::MOST_PACKETS;
use crate::trace::rays::Rays;

/// A sample of a job: the job's number, and which of the pattern.
type Place = (usize, u32);

/// Takes samples, and what is used again for one batch of them after the other.
pub(super) struct Worker<'a> {
    pub tracer: Tracer<'a>,
    pub streams: Streams,
    pub wave: Box<Wave>,
    /// Where each sample lies in the unit square of its pixel.
    pub squares: [DVec2; WAVE],
    /// What samples are added to beside their jobs. `None` where there is no picture.
    pub frame: Option<Frame>,
}

impl<'a> Worker<'a> {
    pub fn new(context: &Context<'a>) -> Self {
        Worker {
            tracer: Tracer::new(&context.prepared.traceable, &context.prepared.lights)
                .supervised(context.control),
            streams: Streams::new(),
            wave: Box::new(Wave::new()),
            squares: [DVec2::ZERO; WAVE],
            frame: None,
        }
    }
}

impl Context<'_> {
    /// Does jobs, which are all for one kind and number of samples, as long as there is time: some may be left. The samples of one
    /// pixel are added in their order.
    pub(super) fn sample_all(&self, worker: &mut Worker, meter: &mut Meter, jobs: &mut [Job]) {
        let Some(Job { indices, .. }) = jobs.first() else { return };
        let (mut number, mut index) = (0, indices.start);
        loop {
            let mut places: ArrayVec<Place, WAVE> = ArrayVec::new();
            while places.len() < meter.wave() && number < jobs.len() {
                if index < jobs[number].indices.end {
                    places.push((number, index));
                    index += 1;
                } else {
                    number += 1;
                    index = jobs.get(number).map_or(0, |job| job.indices.start);
                }
            }
            if places.is_empty() {
                return;
            }
            if !self.sample_places(worker, jobs, &places)
                || !meter.add(places.len() as u32, worker.tracer.rays)
            {
                return;
            }
        }
    }

    /// Takes samples and adds them to their jobs. False, without adding them, if the rendering stops meanwhile.
    ///
    /// A wave that is broken off is dropped as a whole, with the samples that are finished. To keep those would prefer short paths, which
    /// are darker than long ones. So each pixel has the first samples of its pattern, slow or fast.
    pub(super) fn sample_places(&self, worker: &mut Worker, jobs: &mut [Job], places: &[Place]) -> bool {
        worker.tracer.profile(|profiler| profiler.enter(Stage::Camera));
        let sample = |(number, index): &Place| {
            let Job { pattern, place, .. } = &jobs[*number];
            (pattern.seed, *place, *index)
        };
        let samples: ArrayVec<Sample, WAVE> = places.iter().map(sample).collect();
        let sampler = &jobs[places[0].0].pattern.sampler;
        debug_assert!(places.iter().all(|(number, _)| jobs[*number].pattern.sampler == *sampler));
        worker.streams.restart(sampler, &samples);
        worker.wave.clear();
        side_by_side!(self.prepared.traceable.level, simd => self.take(simd, worker, &samples));
        worker.tracer.profile(|profiler| profiler.enter(Stage::Film));
        if worker.tracer.is_stopped {
            return false;
        }
        side_by_side!(self.prepared.traceable.level, simd => self.add_all(simd, worker, jobs, places));
        true
    }

    /// Adds samples to their jobs and to the frame.
    #[inline(never)]
    fn add_all<S: Simd>(&self, simd: S, worker: &mut Worker, jobs: &mut [Job], places: &[Place]) {
        vectorized!(simd, {
            for (at, (number, _)) in places.iter().enumerate() {
                let sample = (worker.squares[at], worker.wave.radiance[at]);
                self.add(sample, worker.frame.as_mut(), &mut jobs[*number]);
            }
        });
    }

    /// Takes samples.
    #[inline(always)]
    fn take<S: Simd>(&self, simd: S, worker: &mut Worker, samples: &[Sample]) {
        let mut packets: ArrayVec<Rays<S>, MOST_PACKETS> = ArrayVec::new();
        let mut numbers: ArrayVec<_, MOST_PACKETS> = ArrayVec::new();
        for first in (0..samples.len()).step_by(LANES) {
            let (own, rays) = self.camera_rays(simd, worker, samples, first);
            packets.push(rays);
            numbers.push(own);
        }
        let viewer = Viewer { camera: &self.camera, spacing: self.spacing };
        let Worker { tracer, streams, wave, .. } = worker;
        let rays = (&packets[..], &numbers[..]);
        self.integrator.li(simd, tracer, streams, wave, rays, viewer);
    }

    /// The camera rays of up to eight samples, from one on, and the numbers of these samples.
    #[inline(never)]
    pub(super) fn camera_rays<S: Simd>(
        &self,
        simd: S,
        worker: &mut Worker,
        samples: &[Sample],
        first: usize,
    ) -> (ArrayVec<u16, LANES>, Rays<S>) {
        vectorized!(simd, {
            let samples = &samples[first..samples.len().min(first + LANES)];
            let numbers: ArrayVec<u16, LANES> = (first as u16..).take(samples.len()).collect();
            let streams = &mut worker.streams;
            streams.choose(simd, &numbers, 0);
            let mut film = streams.next_2d(simd);
            for (lane, (_, place, _)) in samples.iter().enumerate() {
                let square = DVec2::new(film[0][lane], film[1][lane]);
                (film[0][lane], film[1][lane]) = (corner_of(*place) + square).into();
                worker.squares[first + lane] = square;
            }
            let camera = &self.camera;
            let on_lens = camera.has_lens().then(|| streams.next_2d(simd));
            // Nothing else asks for these.
            if self.integrator.world().materials.has_textures {
                for lane in 0..samples.len() {
                    let on_lens = on_lens.as_ref().map_or(DVec2::ZERO, |[u, v]| DVec2::new(u[lane], v[lane]));
                    worker.wave.places[first + lane] = (DVec2::new(film[0][lane], film[1][lane]), on_lens);
                }
            }
            let (o, d) = camera.rays(simd, film, on_lens);
            (numbers, Rays::new(o, d))
        })
    }
}
