//! From a scene to a picture, on all threads.

mod adaptive;
mod control;
mod fixed;
mod forecast;
mod lanes;
mod rounds;
mod sample;
mod stop;
mod target;

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use glam::Vec3;
use lookat_image::Image;
use lookat_scene::{Integrator, Scene, View};

use crate::arithmetic::Precision;
use crate::film::{Film, pixel_bytes};
use crate::filter::FilterSampler;
use crate::integrator::{FirstHit, Tracer, ambient, direct, path};
use crate::prepare::Prepared;
use crate::sampler::SampleStream;
use crate::threads::{self, threads};
use adaptive::Adaptive;
use control::Control;
use fixed::Fixed;
pub use forecast::TimeLeft;
use sample::Context;
use target::Target;

/// How to render, apart from what the scene says.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Settings {
    /// Chooses the random numbers. The same scene, seed and version give the same picture. Default 0.
    pub seed: u64,
    /// Threads of its own, or as many of them as the system gives. 0, the default, uses those of the process: see
    /// [`crate::start_threads`]. They do not change the picture.
    pub threads: usize,
    /// Whether to estimate the error of each pixel, and to give it as the layers of [`lookat_image::PixelError`].
    /// The samples of a pixel are then split into independent replicates, each a pattern of its own, because samples of
    /// one pattern do not tell how large its error is. Smaller patterns are noisier, so the picture is another one, and
    /// up to a few times noisier in smooth scenes. Default false. It goes with a target error, but not with a time alone
    /// or with `adaptive`, which leave it out.
    pub error_layers: bool,
    /// What intersections are computed with.
    pub precision: Precision,
    /// Sample each pixel until its error is so small, in place of the scene's number of samples; always by Sobol's
    /// sequence. Pixels then depend on their neighbors, and on the mean of the picture. Default none.
    pub target_error: Option<TargetError>,
    /// End after so long, counted from the call of [`render`]. Without a target error, samples are taken up to then,
    /// however many the scene asks for; Halton and stratified samples, whose number has to be known, are then replaced by
    /// Sobol's. Such a picture is another one each time. Default none.
    pub time: Option<Duration>,
    /// The most samples of a pixel with a target error or a time. Default 65,536 with a target error, at least 64 there;
    /// without one 2^30.
    pub max_samples: Option<u32>,
    /// Give more samples to pixels among noisy neighbors, and fewer to others, so that the mean squared error of the
    /// picture is small; what the scene asks for, or `max_samples` with a time, is then the mean. A pixel has at least
    /// half of it. By Sobol's sequence, unless the scene's samples are random. Default false; a target error leaves it
    /// out.
    pub adaptive: bool,
}

/// How exact each pixel is to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetError {
    /// The error of each of red, green and blue over the luminance of the pixel, more than 0. Pixels darker than
    /// [`DARK`] of the picture count as if they were that bright: nothing is exact relative to black.
    pub relative: f64,
    /// The probability with which a pixel is as exact as that, between 0 and 1.
    pub confidence: f64,
}

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

/// Pixels with a target error take so many bytes more, about, until they are done.
const TARGET_BYTES: usize = 370;

/// Pixels take so many bytes more while samples go where the noise is: squares, variances, sums of neighbors, and sample
/// counts; and then for each of up to 16 threads the levels of a class.
const ADAPTIVE_BYTES: usize = 44;
const LEVEL_BYTES: usize = 8;

/// Bytes of a film while it is rendered, about: the sums of each pixel, and the picture that they become. Writing the picture
/// as EXR copies it, but the sums are gone then, which take more.
pub fn film_bytes(view: &View, settings: &Settings) -> u64 {
    let has_lobes = FilterSampler::new(&view.filter).weight() != 1.0;
    let policy = match settings.target_error {
        Some(_) => TARGET_BYTES,
        None if settings.adaptive => ADAPTIVE_BYTES + LEVEL_BYTES * settings.threads.max(threads()).min(16),
        None => 0,
    };
    view.film.crop.area() * (pixel_bytes(has_lobes, settings.error_layers) + policy) as u64
}

/// Renders a scene. `progress` is called from any thread every now and then; when it breaks, the rendering ends soon and
/// gives what there is: every pixel with the samples that it has so far.
pub fn render(
    scene: &Scene,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Rendered {
    let deadline = settings.deadline();
    on_threads(settings, || {
        let started = Instant::now();
        let mut prepared = Prepared::new(scene);
        let preparation = started.elapsed();
        prepared.traceable.precision = settings.precision;
        Rendered { preparation, ..run(&prepared, &scene.view, settings, deadline, progress) }
    })
}

impl Settings {
    fn deadline(&self) -> Option<Instant> {
        self.time.and_then(|time| Instant::now().checked_add(time))
    }
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
        let deadline = settings.deadline();
        on_threads(settings, || {
            let preparation = self.look(&view.camera);
            self.traceable.precision = settings.precision;
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
    let has_spreads = settings.target_error.is_some() || fixed::has_spreads(settings);
    let film = Film::new(&view.film, &filter, prepared.scale(view), has_spreads);
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
    let is_open = settings.target_error.is_some() || settings.time.is_some();
    let nominal = if is_open { target::FIRST } else { view.sampler.samples_per_pixel };
    let context = Context::new(prepared, view, nominal, all, li);
    let (film, control, seed) = (context.film, context.control, settings.seed);
    let target = match &settings.target_error {
        Some(error) => {
            let mut target = Target::new(settings, error);
            let parts = rounds::render(&context, seed, &mut target);
            Some(target.reached(film, &parts))
        }
        None if settings.adaptive => {
            rounds::render(&context, seed, &mut Adaptive::new(view, settings));
            None
        }
        None => {
            rounds::render(&context, seed, &mut Fixed::new(view, settings));
            None
        }
    };
    let image = film.develop(settings.error_layers);
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
        let plain = Settings { seed: 1, ..Settings::default() };
        let target = Some(TargetError { relative: 0.1, confidence: 0.9 });
        for settings in [
            plain,
            Settings { error_layers: true, ..plain },
            Settings { adaptive: true, ..plain },
            Settings { target_error: target, ..plain },
        ] {
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
