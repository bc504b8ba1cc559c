//! The brightest sample of a pixel, and the path that it has followed.

use std::ops::{ControlFlow, Range};

use arrayvec::ArrayVec;
use lookat_scene::syntax::Span;
use lookat_scene::{PixelBounds, View};

use super::control::Control;
use super::sample::{Context, Job, JobSample, Pattern};
use super::{Progress, Settings, Stop};
use crate::film::{Film, Keeps};
use crate::integrator::path_record::PATHS;
use crate::integrator::{Profiler, Segment, segments};
use crate::number::luminance;
use crate::prepare::Prepared;
use crate::render::rounds::all;
use crate::render::sample::Worker;

/// The brightest sample of a pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct BrightestSample {
    /// The share of this sample in the light of all samples of the pixel, 0 to 1.
    pub share: f64,
    /// The number of samples of the pixel.
    pub samples: u32,
    /// The sum of their luminances, before the scale of the film.
    pub sum: f64,
    /// The light that the sum loses if each sample is limited to the luminance `limit`.
    pub loss: f64,
    /// The Shape directives of the surfaces of its path, from the camera on. `None` for shapes made in code.
    pub surfaces: Vec<Option<Span>>,
    /// The end of its path.
    pub end: PathEnd,
}

/// The way a path finds its light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathEnd {
    /// A ray from a surface hits a shape that emits, of this Shape directive.
    Shape(Option<Span>),
    /// A ray from a surface leaves the world, where infinite lights are.
    Sky,
    /// Samples of lights find all of it.
    Sampled,
}

impl Prepared {
    /// The brightest sample of a pixel of the full picture, as [`Prepared::render`] takes them. `limit` is a
    /// luminance before the scale of the film, above 0. `None` for a black pixel, for settings that do not give every pixel the same
    /// samples, and if `flow` breaks.
    pub fn brightest_sample(
        &self,
        view: &View,
        settings: &Settings,
        pixel: [u32; 2],
        limit: f64,
        flow: fn() -> ControlFlow<()>,
    ) -> Option<BrightestSample> {
        let Settings { stop, .. } = *settings;
        let Stop::Samples { .. } = stop else { return None };
        let [x, y] = pixel;
        let pixel = pixel.map(u32::cast_signed);
        let mut view = view.clone();
        view.film.crop = PixelBounds { x0: x, y0: y, x1: x + 1, y1: y + 1 };
        let view = &view;
        let film = Film::new(view, Keeps::Sums, false);
        let progress = &|_: Progress| flow();
        let control = Control::new(progress, &film);
        let context = Context::new(self, view, settings, (&film, &control));
        let mut worker = Worker::new(&context);
        let (mut brightest, mut sum, mut loss, mut samples) = ((0.0, None), 0.0, 0.0, 0);
        for pass in all(stop.sampler(view), settings) {
            for first in pass.samples.clone().step_by(PATHS) {
                let indices = first..pass.samples.end.min(first + PATHS as u32);
                context.radiance(&mut worker, (pass.pattern, pixel), indices.clone())?;
                for (at, index) in indices.enumerate() {
                    let own = luminance(worker.batch.radiance[at]);
                    if !own.is_finite() {
                        continue;
                    }
                    (sum, samples) = (sum + own, samples + 1);
                    loss += (own - limit).max(0.0);
                    if own > brightest.0 {
                        brightest = (own, Some((pass.pattern, index)));
                    }
                }
            }
        }
        let (pattern, index) = brightest.1?;
        worker.tracer.profiler = Some(Box::new(Profiler::new()));
        context.radiance(&mut worker, (pattern, pixel), index..index + 1)?;
        let profiler = worker.tracer.profiler.take()?;
        let path = segments(&profiler, &self.traceable, &self.lights);
        let (surfaces, end) = self.followed(&path);
        Some(BrightestSample { share: brightest.0 / sum, samples, sum, loss, surfaces, end })
    }

    /// The surfaces of a path, and its end.
    fn followed(&self, path: &[Segment]) -> (Vec<Option<Span>>, PathEnd) {
        let span = |primitive: u32| self.traceable.primitive(primitive).span;
        let after_first = path.iter().skip(1);
        let light = after_first.clone().rfind(|segment| segment.finds_light);
        let end = match light.and_then(|segment| segment.primitive) {
            Some(primitive) => PathEnd::Shape(span(primitive)),
            None if self.lights.has_skies() && after_first.clone().any(|it| it.primitive.is_none()) => {
                PathEnd::Sky
            }
            None => PathEnd::Sampled,
        };
        let mut surfaces: Vec<Option<Span>> = Vec::new();
        for (at, segment) in path.iter().enumerate() {
            // Of two rays from a surface, the second one goes on.
            let goes_on = path.get(at + 1).is_none_or(|next| next.from != segment.from);
            let is_surface = goes_on && (at == 0 || !segment.finds_light);
            surfaces.extend(segment.primitive.filter(|_| is_surface).map(span));
        }
        (surfaces, end)
    }
}

impl Context<'_> {
    /// Takes samples of a pattern, at most a batch, and leaves their radiance in the batch. `None` if the rendering stops meanwhile.
    fn radiance(
        &self,
        worker: &mut Worker,
        (pattern, pixel): (Pattern, [i32; 2]),
        indices: Range<u32>,
    ) -> Option<()> {
        let taken: ArrayVec<_, PATHS> = indices.clone().map(|index| JobSample { job: 0, index }).collect();
        self.sample_jobs(worker, &mut [Job::new(pattern, pixel, indices)], &taken).then_some(())
    }
}
