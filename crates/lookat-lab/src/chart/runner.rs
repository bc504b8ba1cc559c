//! Renders one scene in many ways, and takes the time.

use std::ops::ControlFlow;
use std::time::Instant;

use lookat_render::{Rendered, Stop};
use lookat_scene::{Sampler, Scene};

use super::method::{Method, Way};
use super::reference::{Origin, Reference, noise};

/// Told every now and then which share of a piece of work is done, from any thread; may break it off.
pub type Watch<'a> = &'a (dyn Fn(f64) -> ControlFlow<()> + Sync);

/// A scene that is rendered in many ways.
#[derive(Debug)]
pub struct Runner {
    scene: Scene,
    /// The scene's own.
    way: Way,
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
        Runner { way: Way::of(&scene, threads), scene }
    }

    /// The scene; its sampler and integrator are those of the last rendering.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The picture that a method makes of so many samples per pixel. `None` if `watch` breaks.
    pub fn render(&mut self, method: &Method, samples: u32, seed: u64, watch: Watch) -> Option<Rendering> {
        let mut way = self.way;
        (method.choose)(&mut way, samples);
        way.settings.seed = seed;
        let (rendered, seconds) = self.run(&way, samples, watch)?;
        let preparation = rendered.preparation.as_secs_f64();
        Some(Rendering {
            pixels: rendered.image.rgb()?,
            seconds: (seconds - preparation).max(0.0),
            preparation,
            samples: rendered.statistics.samples as f64 / self.scene.view.film.crop.area() as f64,
        })
    }

    /// A picture to measure errors by, by the scene's integrator. `None` if `watch` breaks.
    pub fn reference(&mut self, samples: u32, seed: u64, watch: Watch) -> Option<Reference> {
        let mut way = self.way;
        way.sampler = lookat_scene::SamplerKind::Sobol;
        way.settings.seed = seed;
        way.settings.stop = Stop::Samples { error_layers: true };
        let (rendered, seconds) = self.run(&way, samples, watch)?;
        let noise = noise(&rendered.image.errors()?);
        let origin = Origin::Rendered { samples, seed, seconds };
        Some(Reference { pixels: rendered.image.rgb()?, noise, origin })
    }

    /// Renders, and says how many seconds that took in all. `None` if `watch` breaks.
    fn run(&mut self, way: &Way, samples: u32, watch: Watch) -> Option<(Rendered, f64)> {
        self.scene.view.sampler = Sampler { kind: way.sampler, samples_per_pixel: 1 }.with_samples(samples);
        self.scene.view.integrator = way.integrator;
        let started = Instant::now();
        let rendered = lookat_render::render(&self.scene, &way.settings, &|progress| {
            watch(progress.done as f64 / progress.total.max(1) as f64)
        });
        let seconds = started.elapsed().as_secs_f64();
        // A break after the last tile has been asked for all the same.
        (rendered.complete && watch(1.0) == ControlFlow::Continue(())).then_some((rendered, seconds))
    }
}
