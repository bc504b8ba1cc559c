//! Samples side by side, of one pixel or several.

#[cfg(test)]
mod tests;

use arrayvec::ArrayVec;
use fearless_simd::Simd;
use glam::{DVec2, Vec3};

use super::control::Meter;
use super::sample::{Context, Job, center_of};
use crate::camera::lanes::{Viewer, Views};
use crate::filter::FilterSampler;
use crate::integrator::lanes::{Lanes, LanesIntegrator};
use crate::integrator::path::lanes::{WAVE, Wave};
use crate::integrator::{FirstHit, Tracer, direct, path};
use crate::lanes::{LANES, first_lanes, side_by_side};
use crate::sampler::SampleStream;
use crate::sampler::lanes::{Sample, Streams};
use crate::trace::lanes::Rays;

/// A sample of a job: the job's number, and which of the pattern.
type Place = (usize, u32);

/// What is used again for one batch of samples after the other.
struct Batch {
    streams: Streams,
    wave: Box<Wave>,
    /// Whether the filter is negative at each sample.
    negative: [bool; WAVE],
}

impl<F> Context<'_, F>
where
    F: Fn(&mut Tracer, &FirstHit, &mut SampleStream) -> Vec3,
{
    /// Does jobs as [`Context::sample_all`] does, many samples at a time. Those of one pixel are added in their order.
    pub(super) fn sample_side_by_side(
        &self,
        lanes: &Lanes,
        tracer: &mut Tracer,
        meter: &mut Meter,
        jobs: &mut [Job],
    ) {
        let Some(Job { pattern, indices, .. }) = jobs.first() else { return };
        let (mut number, mut index) = (0, indices.start);
        let mut batch = Batch {
            streams: Streams::new(&pattern.sampler),
            wave: Box::new(Wave::new()),
            negative: [false; WAVE],
        };
        loop {
            let mut places: ArrayVec<Place, WAVE> = ArrayVec::new();
            let most = if meter.is_slow() { LANES } else { WAVE };
            while places.len() < most && number < jobs.len() {
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
            self.sample_places(lanes, tracer, jobs, &places, &mut batch);
            if !meter.add(places.len() as u32, tracer.rays) {
                return;
            }
        }
    }

    fn sample_places(
        &self,
        lanes: &Lanes,
        tracer: &mut Tracer,
        jobs: &mut [Job],
        places: &[Place],
        batch: &mut Batch,
    ) {
        let sample = |(number, index): &Place| {
            let Job { pattern, place, .. } = &jobs[*number];
            (pattern.seed, *place, *index)
        };
        let samples: ArrayVec<Sample, WAVE> = places.iter().map(sample).collect();
        let sampler = &jobs[places[0].0].pattern.sampler;
        debug_assert!(places.iter().all(|(number, _)| jobs[*number].pattern.sampler == *sampler));
        batch.streams.restart(sampler, &samples);
        let viewer = Viewer { camera: &self.camera, spacing: self.spacing };
        Taker { lanes, viewer, filter: self.filter }.take(tracer, batch, &samples);
        for (at, (number, _)) in places.iter().enumerate() {
            let Job { pattern, samples, .. } = &mut jobs[*number];
            self.add(pattern, batch.wave.radiance[at], batch.negative[at], samples);
        }
    }
}

/// Takes samples, whatever takes them one by one.
struct Taker<'a> {
    lanes: &'a Lanes<'a>,
    viewer: Viewer<'a>,
    filter: &'a FilterSampler,
}

impl Taker<'_> {
    fn take(&self, tracer: &mut Tracer, batch: &mut Batch, samples: &[Sample]) {
        batch.wave.clear();
        let level = self.lanes.level;
        match (&self.lanes.integrator, self.lanes.is_lambert()) {
            (LanesIntegrator::Direct(direct), true) => {
                side_by_side!(level, simd => self.direct::<_, true>(simd, direct, tracer, batch, samples));
            }
            (LanesIntegrator::Direct(direct), false) => {
                side_by_side!(level, simd => self.direct::<_, false>(simd, direct, tracer, batch, samples));
            }
            (LanesIntegrator::Path(path), true) => {
                side_by_side!(level, simd => self.paths::<_, true>(simd, path, tracer, batch, samples));
            }
            (LanesIntegrator::Path(path), false) => {
                side_by_side!(level, simd => self.paths::<_, false>(simd, path, tracer, batch, samples));
            }
        }
    }

    #[inline(always)]
    fn direct<S: Simd, const LAMBERT: bool>(
        &self,
        simd: S,
        direct: &direct::lanes::Lanes,
        tracer: &mut Tracer,
        batch: &mut Batch,
        samples: &[Sample],
    ) {
        for first in (0..samples.len()).step_by(LANES) {
            let (numbers, rays) = self.camera_rays(simd, batch, samples, first);
            let active = first_lanes(simd, numbers.len());
            let views = &Views { of: self.viewer, places: &batch.wave.places, samples: &numbers };
            let radiance = direct.li::<_, LAMBERT>(simd, tracer, (&rays, views), active, &mut batch.streams);
            for (lane, number) in numbers.iter().enumerate() {
                batch.wave.radiance[usize::from(*number)] = radiance.lane(lane);
            }
        }
    }

    #[inline(always)]
    fn paths<S: Simd, const LAMBERT: bool>(
        &self,
        simd: S,
        path: &path::lanes::Lanes,
        tracer: &mut Tracer,
        batch: &mut Batch,
        samples: &[Sample],
    ) {
        for first in (0..samples.len()).step_by(LANES) {
            let (numbers, rays) = self.camera_rays(simd, batch, samples, first);
            path.begin(simd, tracer, &rays, &numbers, &mut batch.wave);
        }
        let dimension = if self.viewer.camera.has_lens() { 4 } else { 2 };
        path.follow::<_, LAMBERT>(
            simd,
            tracer,
            &mut batch.streams,
            &mut batch.wave,
            (self.viewer, dimension),
        );
    }

    /// The camera rays of up to eight samples, from one on, and the numbers of these samples.
    #[inline(always)]
    fn camera_rays<S: Simd>(
        &self,
        simd: S,
        batch: &mut Batch,
        samples: &[Sample],
        first: usize,
    ) -> (ArrayVec<u16, LANES>, Rays<S>) {
        let samples = &samples[first..samples.len().min(first + LANES)];
        let numbers: ArrayVec<u16, LANES> = (first as u16..).take(samples.len()).collect();
        let streams = &mut batch.streams;
        let all = first_lanes(simd, numbers.len());
        streams.choose(&numbers, 0);
        let mut film = streams.next_2d(simd, all);
        for (lane, (_, place, _)) in samples.iter().enumerate() {
            let (offset, is_negative) = self.filter.sample(DVec2::new(film[0][lane], film[1][lane]));
            (film[0][lane], film[1][lane]) = (center_of(*place) + offset).into();
            batch.negative[first + lane] = is_negative;
        }
        let camera = self.viewer.camera;
        let on_lens = camera.has_lens().then(|| streams.next_2d(simd, all));
        // Nothing else asks for these.
        if self.lanes.has_textures() {
            for lane in 0..samples.len() {
                let on_lens = on_lens.as_ref().map_or(DVec2::ZERO, |[u, v]| DVec2::new(u[lane], v[lane]));
                batch.wave.places[first + lane] = (DVec2::new(film[0][lane], film[1][lane]), on_lens);
            }
        }
        let (o, d) = camera.rays(simd, film, on_lens);
        (numbers, Rays::new(o, d))
    }
}
