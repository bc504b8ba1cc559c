//! Renders one scene in many ways, and takes the time.

use std::ops::ControlFlow;
use std::time::Instant;

use lookat_render::{Rendered, Settings};
use lookat_scene::{Sampler, Scene};

use super::method::{Method, REFERENCE};
use super::reference::{Origin, Reference, noise};

/// Told every now and then which share of a piece of work is done, from any thread; may break it off.
pub type Watch<'a> = &'a (dyn Fn(f64) -> ControlFlow<()> + Sync);

/// By how much a run may exceed its budget.
pub(super) const LATE: f64 = 1.15;

/// The wall time of a run, from its start on.
#[derive(Debug, Clone, Copy)]
pub struct Budget {
    /// When the run began.
    pub started: Instant,
    /// How long it may take, in seconds.
    pub seconds: f64,
}

impl Budget {
    /// The seconds that are left; 0 if there are none.
    pub fn left(&self) -> f64 {
        (self.seconds - self.spent()).max(0.0)
    }

    /// Whether it is time to break off.
    pub(super) fn is_exceeded(&self) -> bool {
        self.spent() > LATE * self.seconds
    }

    fn spent(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}

/// A scene that is rendered in many ways.
#[derive(Debug)]
pub struct Runner {
    scene: Scene,
    threads: usize,
}

/// A picture and what it took.
#[derive(Debug)]
pub struct Rendering {
    /// Linear RGB, row by row.
    pub pixels: Vec<[f32; 3]>,
    /// Wall time of rendering in seconds, without `preparation`.
    pub seconds: f64,
    /// Wall time in seconds of what comes before the first sample.
    pub preparation: f64,
    /// Camera samples per pixel.
    pub samples: f64,
}

impl Runner {
    /// Renders this scene on so many threads; 0 is one for each processor.
    pub fn new(scene: Scene, threads: usize) -> Runner {
        Runner { scene, threads }
    }

    /// The picture that a method makes of so many samples per pixel. `None` if `watch` breaks.
    pub fn render(&self, method: &Method, samples: u32, seed: u64, watch: Watch) -> Option<Rendering> {
        let (rendered, seconds) = self.run(method, samples, seed, watch)?;
        let preparation = rendered.preparation.as_secs_f64();
        Some(Rendering {
            pixels: rendered.image.rgb()?,
            seconds: (seconds - preparation).max(0.0),
            preparation,
            samples: rendered.statistics.samples as f64 / self.scene.view.film.crop.area() as f64,
        })
    }

    /// A picture to measure errors by, by the scene's integrator. `None` if `watch` breaks.
    pub fn reference(&self, samples: u32, seed: u64, watch: Watch) -> Option<Reference> {
        let (rendered, seconds) = self.run(&REFERENCE, samples, seed, watch)?;
        let noise = noise(&rendered.image.errors()?);
        let origin = Origin::Rendered { samples, seed, seconds };
        Some(Reference { pixels: rendered.image.rgb()?, noise, origin })
    }

    /// Renders, and says how many seconds that took in all. `None` if `watch` breaks.
    fn run(&self, method: &Method, samples: u32, seed: u64, watch: Watch) -> Option<(Rendered, f64)> {
        let mut scene = self.scene.clone();
        method.apply(&mut scene.view);
        scene.view.sampler = Sampler { samples_per_pixel: 1, ..scene.view.sampler }.with_samples(samples);
        let stop = (method.stop)(samples);
        let settings = Settings { threads: self.threads, seed, stop, ..Settings::default() };
        let started = Instant::now();
        let rendered = lookat_render::render(&scene, &settings, &|progress| {
            watch(progress.done as f64 / progress.total.max(1) as f64)
        });
        let seconds = started.elapsed().as_secs_f64();
        // A break after the last tile has been asked for all the same.
        (rendered.complete && watch(1.0) == ControlFlow::Continue(())).then_some((rendered, seconds))
    }
}
