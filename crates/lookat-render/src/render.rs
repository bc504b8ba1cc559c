//! From a scene to a picture, on all threads.

mod adaptive;
mod control;
mod fixed;
mod forecast;
mod lanes;
mod rounds;
mod sample;
mod settings;
mod stop;
mod target;

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use glam::Vec3;
use lookat_image::Image;
use lookat_scene::{Integrator, Scene, View};

use crate::film::Film;
use crate::filter::FilterSampler;
use crate::integrator::{FirstHit, Tracer, ambient, direct, path};
use crate::prepare::Prepared;
use crate::sampler::SampleStream;
use crate::threads;
use adaptive::Adaptive;
use control::Control;
use fixed::Fixed;
pub use forecast::TimeLeft;
use sample::Context;
pub use settings::{Settings, Stop, TargetError, film_bytes};
use target::Target;

/// The luminance below which errors are not judged relative to the pixel, as a share of the brightness of the picture,
/// which is the square of the mean of the roots of its pixels' luminances.
pub const DARK: f64 = 0.05;

/// How far a rendering is.
#[derive(Debug, Clone, Copy)]
pub struct Progress<'f> {
    /// Camera samples done.
    pub done: u64,
    /// Camera samples in all; with a target error what is guessed so far, with a time the most.
    pub total: u64,
    /// Camera samples left, at least and at most: the same number without a target error. `None` while too few pixels are
    /// known to tell.
    pub left: Option<[u64; 2]>,
    /// Pixels that have reached the target error so far, after whole rounds; 0 without one.
    pub pixels_done: u64,
    film: &'f Film<'f>,
}

impl Progress<'_> {
    /// The picture so far, without error layers: linear RGB, with the film's crop window as data window. Pixels without
    /// samples are black.
    pub fn snapshot(&self) -> Image {
        self.film.develop(false)
    }
}

/// What [`render`] gives.
#[derive(Debug)]
pub struct Rendered {
    /// The picture: linear RGB, with the film's crop window as data window.
    pub image: Image,
    /// What it took.
    pub statistics: Statistics,
    /// How long it took to sort the scene into trees and to weigh its lights, before the first sample.
    pub preparation: Duration,
    /// Whether the rendering came to its end, be it that of its time; not so after the callback broke off.
    pub complete: bool,
}

/// Counts of a rendering.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Camera samples.
    pub samples: u64,
    /// Rays of all kinds.
    pub rays: u64,
    /// Samples that were infinite or not a number, and counted as black.
    pub rejected: u64,
    /// The fewest samples that a pixel has; 0 where the time was too short for some.
    pub least: u32,
    /// The most samples that a pixel has.
    pub most: u32,
    /// What became of the target error; `None` without one.
    pub target: Option<Reached>,
}

/// Pixels, by whether they reached the target error.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Reached {
    /// As exact as the target.
    pub within: u64,
    /// Not so exact after the most samples. Nothing is known of their errors but the layers of the picture.
    pub at_cap: u64,
    /// Not so exact when the rendering was ended.
    pub out_of_time: u64,
    /// Pixels in which a sample was more than 20 times as bright as the brightest pixel around. Where light is so rare, a
    /// pixel may have seen none of it, and be taken for exact: the target may be missed around these.
    pub outliers: u64,
}

/// Renders a scene. `progress` is called from any thread every now and then; when it breaks, the rendering ends soon and
/// gives what there is: every pixel with the samples that it has so far.
pub fn render(
    scene: &Scene,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Rendered {
    let deadline = settings.stop.deadline();
    on_threads(settings, || {
        let started = Instant::now();
        let prepared = Prepared::new(scene);
        let preparation = started.elapsed();
        Rendered { preparation, ..run(&prepared, &scene.view, settings, deadline, progress) }
    })
}

impl Prepared {
    /// Renders a view of the world as [`render`] does, with the same pixels, and prepares only what has to move with the
    /// camera: nothing, unless it has left its cell.
    pub fn render(
        &mut self,
        view: &View,
        settings: &Settings,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Rendered {
        let deadline = settings.stop.deadline();
        on_threads(settings, || {
            let preparation = self.look(&view.camera);
            Rendered { preparation, ..run(self, view, settings, deadline, progress) }
        })
    }
}

/// Runs on the threads that the settings ask for.
fn on_threads<R: Send>(settings: &Settings, run: impl FnOnce() -> R + Send) -> R {
    let pool = if settings.threads > 0 { threads::pool(settings.threads) } else { None };
    match pool {
        Some(pool) => pool.install(run),
        None => rayon::scope(|_| run()),
    }
}

fn run(
    prepared: &Prepared,
    view: &View,
    settings: &Settings,
    deadline: Option<Instant>,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Rendered {
    let filter = FilterSampler::new(&view.filter);
    let film = Film::new(&view.film, &filter, prepared.scale(view), settings.stop.has_spreads());
    let control = Control::new(progress, deadline, &film);
    let all = (&filter, &film, &control);
    // The integrator is chosen here, once, so that the loop over samples is compiled for it.
    match view.integrator {
        Integrator::DirectLighting { strategy, max_depth } => {
            sample(prepared, view, settings, all, |tracer, first, stream| {
                direct::li(tracer, first, stream, strategy, max_depth)
            })
        }
        Integrator::Path { max_depth, roulette_threshold, light_choice } => {
            let path = path::Settings { max_depth, roulette_threshold, light_choice };
            sample(prepared, view, settings, all, |tracer, first, stream| {
                path::li(tracer, first, stream, &path)
            })
        }
        Integrator::AmbientOcclusion { cosine, samples } => {
            sample(prepared, view, settings, all, |tracer, first, stream| {
                ambient::li(tracer, first, stream, cosine, samples)
            })
        }
    }
}

/// Samples the film, in the way that the settings ask for, and develops it.
fn sample<F>(
    prepared: &Prepared,
    view: &View,
    settings: &Settings,
    all: (&FilterSampler, &Film, &Control),
    li: F,
) -> Rendered
where
    F: Fn(&mut Tracer, &FirstHit, &mut SampleStream) -> Vec3 + Sync,
{
    let Settings { seed, stop, .. } = *settings;
    let context = Context::new(prepared, view, stop.nominal_samples(view), all, li);
    let (film, control, sampler) = (context.film, context.control, stop.sampler(view));
    let target = match stop {
        Stop::Error { target, limit, .. } => {
            let mut target = Target::new(sampler, seed, &target, limit.is_some());
            let parts = rounds::render(&context, seed, &mut target);
            Some(target.reached(film, &parts))
        }
        Stop::Adaptive | Stop::Time { adaptive: true, .. } => {
            let is_open = matches!(stop, Stop::Time { .. });
            rounds::render(&context, seed, &mut Adaptive::new(view.film.crop, sampler, seed, is_open));
            None
        }
        Stop::Samples { .. } | Stop::Time { adaptive: false, .. } => {
            rounds::render(&context, seed, &mut Fixed::new(sampler, seed, stop.has_spreads()));
            None
        }
    };
    let image = film.develop(stop.has_error_layers());
    let tiles = film.lock();
    let counts = || tiles.iter().flat_map(|tile| tile.pixels().map(|pixel| pixel.all.count));
    let statistics = Statistics {
        samples: counts().map(u64::from).sum(),
        rays: control.rays(),
        rejected: control.rejected(),
        least: counts().min().unwrap_or(0),
        most: counts().max().unwrap_or(0),
        target,
    };
    Rendered {
        image,
        statistics,
        preparation: Duration::ZERO,
        complete: !control.is_interrupted() || statistics.samples == control.total(),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;
    use crate::testing::scene;

    /// From any thread, at any time; the last one is the picture.
    #[test]
    fn snapshots_grow_into_the_picture() {
        let scene = scene(
            r#"Film "image" "integer xresolution" 40 "integer yresolution" 30 PixelFilter "mitchell"
            Camera "perspective" Sampler "sobol" "integer pixelsamples" 64 Integrator "path" WorldBegin
            LightSource "infinite" Translate 0 0 3 Shape "sphere" WorldEnd"#,
        );
        let target = TargetError { relative: 0.1, confidence: 0.9 };
        for stop in [
            Stop::default(),
            Stop::Samples { error_layers: true },
            Stop::Adaptive,
            Stop::Time { limit: Duration::from_secs(3600), max_samples: 64, adaptive: false },
            Stop::Error { target, max_samples: 1024, limit: None, error_layers: false },
        ] {
            let settings = Settings { stop, ..Settings::default() };
            let snapshots = Mutex::new(Vec::new());
            let rendered = render(&scene, &settings, &|progress: Progress| {
                let share = progress.done as f64 / progress.total.max(1) as f64;
                snapshots.lock().unwrap().push((share, progress.snapshot().rgb().unwrap()));
                ControlFlow::Continue(())
            });
            let picture = rendered.image.rgb().unwrap();
            let snapshots = snapshots.into_inner().unwrap();
            let error = |snapshot: &Vec<[f32; 3]>| -> f32 {
                snapshot.iter().zip(&picture).map(|(a, b)| (a[0] - b[0]).abs()).sum::<f32>() / 1200.0
            };
            assert!(snapshots.len() > 8, "{settings:?}");
            let first = snapshots.iter().map(|(_, snapshot)| error(snapshot)).fold(0.0, f32::max);
            let last = snapshots.iter().map(|(_, snapshot)| error(snapshot)).fold(f32::INFINITY, f32::min);
            assert!(first > 0.3 && last < 0.05, "{settings:?}: {first} {last}");
        }
    }
}
