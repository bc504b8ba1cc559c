//! From a scene to a picture, on all threads.

mod adaptive;
#[cfg(test)]
mod bits;
mod brightest;
mod control;
mod layer_set;
mod layers;
mod memory;
mod part;
mod profile;
mod rounds;
mod sample;
mod settings;
mod stop_options;
mod stop_rule;
mod target;

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use lookat_image::Image;
use lookat_scene::{Scene, View};
use serde::Serialize;

use crate::film::{Film, FilmSums, FilmSumsError, Keeps, PolicyState, lock};
use crate::integrator::Profiler;
use crate::prepare::Prepared;
pub use crate::render::part::Part;
pub use crate::render::rounds::TimeLeft;
use crate::render::rounds::{Fixed, Rounds};
use crate::threads;
use adaptive::Adaptive;
pub use brightest::{BrightestSample, PathEnd};
use control::{Control, State};
pub use layer_set::{Layer, Layers};
pub use memory::film_bytes;
pub use profile::profile;
use sample::Context;
pub use settings::{Settings, Stop};
pub use stop_options::{StopOptions, StopOptionsError};
pub use stop_rule::TargetError;
use target::Target;

/// The luminance below which errors are not judged relative to the pixel, as a share of the brightness of the picture,
/// which is the square of the mean of the roots of its pixels' luminances.
pub const DARK: f64 = 0.05;

/// The progress of a rendering.
#[derive(Debug, Clone, Copy)]
pub struct Progress<'f> {
    /// Camera samples done.
    pub done: u64,
    /// Camera samples in total. With a target error: an estimate. With a time limit: the most.
    pub total: u64,
    /// The least and the most camera samples left. Both are equal without a target error. `None` while too few pixels have
    /// finished for an estimate.
    pub left: Option<[u64; 2]>,
    /// Pixels that have reached the target error so far, after whole rounds; 0 without one.
    pub pixels_done: u64,
    /// The rays of finished tiles, and their rejected and clamped samples.
    pub statistics: Statistics,
    film: &'f Film<'f>,
}

impl Progress<'_> {
    /// The picture so far, without error layers: linear RGB, with the film's crop window as data window. Pixels without
    /// samples are black.
    pub fn snapshot(&self) -> Image {
        self.film.develop(false)
    }

    /// The picture so far with error layers, if the settings ask for them. The error is infinite for pixels with fewer than
    /// two replicates.
    pub fn snapshot_with_errors(&self) -> Image {
        self.film.develop(true)
    }

    /// The sums of the samples so far. With [`Stop::Adaptive`] samples are weighed by the counts of this rendering, and with
    /// [`Stop::TargetError`] pixels keep the samples they were judged by, so that only sums with other settings add up to a larger
    /// rendering. With [`Settings::keep_sums`] these sums hold what [`Prepared::resume`] needs.
    pub fn sums(&self) -> FilmSums {
        self.film.sums()
    }

    /// The result of [`render`] if it ended now. `with_errors` adds the error layers; there are no other layers.
    pub fn rendered(&self, with_errors: bool) -> Rendered {
        let (image, statistics) = (self.film.develop(with_errors), self.film.count(self.statistics));
        Rendered { image, sums: None, statistics, preparation: Duration::ZERO, complete: false }
    }
}

/// The result of [`render`].
#[derive(Debug)]
pub struct Rendered {
    /// The picture: linear RGB, with the film's crop window as data window.
    pub image: Image,
    /// The sums of the film, if the settings ask for them: see [`Progress::sums`]. `None` if the rendering was broken off before there were
    /// samples.
    pub sums: Option<FilmSums>,
    /// Counts of samples and rays.
    pub statistics: Statistics,
    /// The time to build BVHs and light tables, before the first sample. Zero from [`Prepared::render`], which builds none.
    pub preparation: Duration,
    /// True if the rendering finished or used up its time. False if the callback stopped it.
    pub complete: bool,
}

/// Counts of a rendering.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Camera samples, including those beyond the edges of the picture that the filter reaches.
    pub samples: u64,
    /// Camera samples in the pixels of the picture.
    pub samples_in_picture: u64,
    /// Rays of all kinds.
    pub rays: u64,
    /// Samples that were infinite or not a number, and counted as black.
    pub rejected: u64,
    /// Samples that were too bright for the film, and counted as the brightest that it holds: about 2^31 times the root mean
    /// square of the picture, and at least four times the brightest light that a ray can hit.
    pub clamped: u64,
    /// The fewest samples that a pixel has; 0 where the time was too short for some.
    pub least: u32,
    /// The most samples that a pixel has.
    pub most: u32,
    /// Pixels with samples of which none counts: the filter is narrower than the gaps between samples, or falls to nothing within them. These pixels are black.
    pub unreached: u64,
    /// Pixels by whether they reached the target error. `None` without one.
    pub target: Option<Reached>,
}

/// Pixels, by whether they reached the target error.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Reached {
    /// Pixels that reached the target error.
    pub within: u64,
    /// Pixels that took the most samples without reaching the target. Only the error layers tell their errors.
    pub at_cap: u64,
    /// Pixels that had not reached the target when the rendering ended.
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
        let rendered = start(&prepared, &scene.view, settings, deadline, progress);
        Rendered { preparation, ..rendered }
    })
}

impl Prepared {
    /// Renders a view of the world. If the camera [is near](Prepared::is_near), the pixels equal those of [`render`]. Otherwise its
    /// coordinates have other rounding errors: to avoid them, call [`Prepared::look`] first.
    pub fn render(
        &self,
        view: &View,
        settings: &Settings,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Rendered {
        let deadline = settings.stop.deadline();
        on_threads(settings, || start(self, view, settings, deadline, progress))
    }

    /// Goes on with a rendering that has been broken off, from the [sums](Progress::sums) that it had, to the same bits. `view`, `settings` and
    /// the scene are those of that rendering, except that an [extendable](Settings::is_extendable) one may have more samples per pixel.
    ///
    /// # Errors
    ///
    /// [`FilmSumsError::OtherPicture`] if the sums cannot be of this rendering, or if noise and a limit of time decide about samples,
    /// [`FilmSumsError::TooManySamples`] if they have more samples than it takes, [`FilmSumsError::Unreadable`] if they are damaged.
    pub fn resume(
        &self,
        view: &View,
        settings: &Settings,
        so_far: FilmSums,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<Rendered, FilmSumsError> {
        let deadline = settings.stop.deadline();
        on_threads(settings, || run(self, view, settings, deadline, progress, None, Some(so_far)))
    }

    /// The layers of the settings as [`Prepared::render`] gives them, beside a black picture. `progress` is called with a
    /// picture without samples. `None` if it breaks.
    pub fn layers(
        &self,
        view: &View,
        settings: &Settings,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Option<Image> {
        on_threads(settings, || {
            let film = Film::new(view, Keeps::Sums, false);
            let control = Control::new(progress, &film);
            let context = Context::new(self, view, settings, (&film, &control));
            let mut image = film.develop(false);
            layers::add(&context, view, settings, &mut image).then_some(image)
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

/// The most samples that a pixel may have.
fn most_samples(view: &View, settings: &Settings) -> u32 {
    let sampler = settings.stop.sampler(view);
    match settings.stop {
        Stop::Samples { .. } => Fixed::new(sampler, settings).samples_per_pixel,
        Stop::Adaptive | Stop::Time { adaptive: true, .. } => adaptive::most(sampler.samples_per_pixel),
        Stop::Time { adaptive: false, .. } | Stop::TargetError { .. } => sampler.samples_per_pixel,
    }
}

/// Renders from the first sample on.
fn start(
    prepared: &Prepared,
    view: &View,
    settings: &Settings,
    deadline: Option<Instant>,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Rendered {
    let rendered = run(prepared, view, settings, deadline, progress, None, None);
    rendered.expect("an empty film is of any rendering")
}

/// Renders, from sums if there are some.
fn run(
    prepared: &Prepared,
    view: &View,
    settings: &Settings,
    deadline: Option<Instant>,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    profilers: Option<&Mutex<Vec<Profiler>>>,
    so_far: Option<FilmSums>,
) -> Result<Rendered, FilmSumsError> {
    let film = Film::new(view, settings.keeps(), settings.keeps_policy());
    let is_new = so_far.is_none();
    let mut state = None;
    if let Some(sums) = so_far {
        state = film.restore(sums, most_samples(view, settings))?;
    }
    let control = Control { deadline, profilers, ..Control::new(progress, &film) };
    let mut context = Context::new(prepared, view, settings, (&film, &control));
    if is_new {
        context.expose();
    }
    let rendered = take_samples(&context, view, settings, state)?;
    let sums = (settings.keep_sums && film.is_exposed()).then(|| film.into_sums());
    Ok(Rendered { sums, ..rendered })
}

/// Samples the film as the settings ask for, from where it is, and develops it.
fn take_samples(
    context: &Context,
    view: &View,
    settings: &Settings,
    state: Option<PolicyState>,
) -> Result<Rendered, FilmSumsError> {
    let Settings { seed, stop, is_extendable, .. } = *settings;
    let (film, sampler) = (context.film, stop.sampler(view));
    let mut reached = None;
    match stop {
        Stop::TargetError { target, .. } => {
            let mut target = Target::new(sampler, seed, &target);
            let mut rounds = Rounds::new(&mut target, film, state)?;
            rounds.render(context);
            reached = Some(target::reached(context, rounds.states()));
        }
        Stop::Adaptive | Stop::Time { adaptive: true, .. } => {
            let is_open = is_extendable || matches!(stop, Stop::Time { .. });
            Rounds::new(&mut Adaptive::new(film, sampler, seed, is_open), film, state)?.render(context);
        }
        Stop::Samples { .. } | Stop::Time { adaptive: false, .. } => {
            Rounds::new(&mut Fixed::new(sampler, settings), film, state)?.render(context);
        }
    }
    Ok(develop(context, view, settings, reached))
}

impl Film<'_> {
    /// Adds the sample counts of the pixels to the statistics.
    fn count(&self, statistics: Statistics) -> Statistics {
        let none = Statistics {
            samples: 0,
            samples_in_picture: 0,
            least: u32::MAX,
            most: 0,
            unreached: 0,
            ..statistics
        };
        self.tiles.iter().fold(none, |mut sum, tile| {
            let tile = lock(tile);
            sum.samples += tile.counts.iter().copied().map(u64::from).sum::<u64>();
            for at in 0..tile.bounds.size() {
                let count = tile.count(at);
                sum.samples_in_picture += u64::from(count);
                sum.unreached += u64::from(count > 0 && !tile.is_reached(at));
                (sum.least, sum.most) = (sum.least.min(count), sum.most.max(count));
            }
            sum
        })
    }
}

/// Develops the film, and adds the layers that the settings ask for.
fn develop(context: &Context, view: &View, settings: &Settings, target: Option<Reached>) -> Rendered {
    let Context { film, control, .. } = context;
    let mut image = film.develop(settings.stop.has_error_layers());
    let statistics = film.count(Statistics { target, ..control.state().statistics });
    let State { interrupted, is_finished, .. } = *control.state();
    let mut complete = !interrupted || is_finished;
    if complete && !settings.layers.is_empty() {
        complete = layers::add(context, view, settings, &mut image);
    }
    Rendered { image, sums: None, statistics, preparation: Duration::ZERO, complete }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::scene;

    /// A light close to a large ground, and a shape too small to see, give extreme sizes. Sums have the range of the samples, which
    /// sizes do not change.
    #[test]
    fn bright_and_dark_pictures_keep_their_light() {
        for (half, height, other) in [
            (5e3, 1.0, ""),
            (1e6, 1.0, ""),
            (5.0, 10.0, "Translate 0 -3 0 Shape \"sphere\" \"float radius\" 1e-9"),
        ] {
            let scene = scene(&format!(
                "LookAt 0 3 0 0 0 0 0 0 1 Camera \"perspective\" \"float fov\" .01
                Film \"image\" \"integer xresolution\" 1 \"integer yresolution\" 1 Sampler \"sobol\" \"integer pixelsamples\" 16
                Integrator \"directlighting\" WorldBegin LightSource \"point\" \"point from\" [0 {height} 0] \"rgb I\" [10 10 10]
                Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]
                \"point P\" [-{half} 0 -{half} -{half} 0 {half} {half} 0 {half} {half} 0 -{half}] {other} WorldEnd"
            ));
            let rendered = render(&scene, &Settings::default(), &|_| ControlFlow::Continue(()));
            let expected = 10.0 * 0.5 / std::f32::consts::PI / (height * height) as f32;
            let found = rendered.image.rgb().unwrap()[0][0];
            assert!((found / expected - 1.0).abs() < 1e-5, "{half}: {found} {expected}");
        }
    }

    /// A lamp of two pixels, between the samples that find the brightness.
    #[test]
    fn lamps_that_few_rays_hit_keep_their_light() {
        for (radiance, sky) in [(1e6_f32, "1e-4"), (1e12, "0"), (1e-20, "0")] {
            let scene = scene(&format!(
                "Film \"image\" \"integer xresolution\" 64 \"integer yresolution\" 64 Sampler \"sobol\"
                Camera \"perspective\" \"float fov\" 90 Integrator \"path\" \"integer maxdepth\" 0 WorldBegin
                LightSource \"infinite\" \"rgb L\" [{sky} {sky} {sky}] Translate 1.25 1.25 20
                AreaLightSource \"diffuse\" \"rgb L\" [{radiance} {radiance} {radiance}]
                Shape \"sphere\" \"float radius\" .55 WorldEnd"
            ));
            let rendered = render(&scene, &Settings::default(), &|_| ControlFlow::Continue(()));
            let found = rendered.image.channels[0].samples.iter().copied().fold(0.0, f32::max);
            assert!(found > 0.5 * radiance && found <= radiance, "{radiance}: {found}");
            assert_eq!(rendered.statistics.clamped, 0);
        }
    }

    /// Nothing of it can be hit, and it is in nobody's way.
    #[test]
    fn an_instance_without_area_hides_nothing() {
        let picture = |instance: &str| {
            let spheres: String = (0..40)
                .map(|at| format!("Translate {} 0 0 Shape \"sphere\" \"float radius\" .2\n", at % 3))
                .collect();
            let scene = scene(&format!(
                "Film \"image\" \"integer xresolution\" 32 \"integer yresolution\" 16 Camera \"orthographic\"
                \"float screenwindow\" [-1 40 -1 1] Sampler \"sobol\" \"integer pixelsamples\" 4 Integrator \"path\"
                WorldBegin LightSource \"infinite\" ObjectBegin \"flat\" Shape \"trianglemesh\" \"integer indices\" [0 1 2]
                \"point P\" [0 0 0 1 0 0 2 0 0] ObjectEnd Translate 0 0 3 {instance} {spheres} WorldEnd"
            ));
            render(&scene, &Settings::default(), &|_| ControlFlow::Continue(())).image.rgb()
        };
        assert_eq!(picture("ObjectInstance \"flat\""), picture(""));
    }

    /// Replicates are kept in `f32`; errors far below its precision are told all the same.
    #[test]
    fn a_very_small_target_error_is_reached() {
        let scene = scene(
            r#"LookAt 0 0 -5 0 0 0 0 1 0 Camera "orthographic" "float screenwindow" [-1 1 -1 1]
            Film "image" "integer xresolution" 8 "integer yresolution" 8 Sampler "sobol" Integrator "path" "integer maxdepth" 1
            WorldBegin LightSource "infinite"
            Texture "b" "color" "bilerp" "rgb v00" [.3 .3 .3] "rgb v01" [.31 .4 .5] "rgb v10" [.5 .6 .33] "rgb v11" [.7 .8 .9]
            Material "matte" "texture Kd" "b" Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]
            "point P" [-4 -4 0 -4 4 0 4 4 0 4 -4 0] "float uv" [0 0 0 1 1 1 1 0] WorldEnd"#,
        );
        let target = TargetError { relative: 3e-5, confidence: 0.95 };
        let stop = Stop::TargetError { target, max_samples: 1 << 16, limit: None, error_layers: true };
        let settings = Settings { stop, ..Settings::default() };
        let rendered = render(&scene, &settings, &|_| ControlFlow::Continue(()));
        assert_eq!(rendered.statistics.target.map(|target| target.within), Some(64));
        let errors = rendered.image.errors().unwrap();
        assert!(
            errors.iter().all(|error| error.standard_error.iter().all(|x| *x > 0.0 && *x < 1e-4)),
            "{errors:?}"
        );
    }

    /// A picture that the time ends is as good as one of so many samples: it has the same.
    #[test]
    fn time_takes_the_samples_of_a_number_of_samples() {
        let mut scene = scene(
            r#"Film "image" "integer xresolution" 16 "integer yresolution" 16 PixelFilter "gaussian"
            Camera "perspective" Sampler "sobol" "integer pixelsamples" 64 Integrator "path" WorldBegin
            LightSource "infinite" Translate 0 0 3 Shape "sphere" WorldEnd"#,
        );
        let whole =
            render(&scene, &Settings { threads: 1, ..Settings::default() }, &|_| ControlFlow::Continue(()));
        let max_samples = Stop::DEFAULT_MAX_SAMPLES_OF_TIME;
        let stop = Stop::Time { limit: Duration::from_secs(3600), max_samples, adaptive: false };
        // In place of the clock.
        let in_time = |progress: Progress| match progress.done < whole.statistics.samples {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        };
        // Textures are filtered for as many samples, since it is 64.
        scene.view.sampler.samples_per_pixel = 1;
        let timed = render(&scene, &Settings { threads: 1, stop, ..Settings::default() }, &in_time);
        assert_eq!(timed.statistics.samples, whole.statistics.samples);
        assert_eq!(timed.image.rgb().unwrap(), whole.image.rgb().unwrap());
    }

    /// No lock of the film is held during the callback, for every way to stop and every kind of layer.
    #[test]
    fn snapshots_are_taken_in_each_callback() {
        let target = TargetError { relative: 0.1, confidence: 0.9 };
        let limit = Duration::from_millis(10);
        let stops = [
            Stop::default(),
            Stop::Samples { error_layers: true },
            Stop::Adaptive,
            Stop::Time { limit, max_samples: 64, adaptive: false },
            Stop::Time { limit, max_samples: 64, adaptive: true },
            Stop::TargetError { target, max_samples: 128, limit: None, error_layers: false },
            Stop::TargetError { target, max_samples: 128, limit: Some(limit), error_layers: true },
        ];
        let scene = scene(
            "Film \"image\" \"integer xresolution\" 16 \"integer yresolution\" 16 Camera \"perspective\" Sampler \"sobol\"
            Integrator \"path\" WorldBegin LightSource \"infinite\" Translate 0 0 3 Shape \"sphere\" WorldEnd",
        );
        let (tell, told) = std::sync::mpsc::channel();
        std::thread::spawn(move || {
            for stop in stops {
                for layers in [Layers::default(), Layers::OF_POINTS, Layers::OF_SAMPLES] {
                    let settings = Settings { stop, layers, ..Settings::default() };
                    let progress = |progress: Progress| {
                        progress.snapshot_with_errors();
                        ControlFlow::Continue(())
                    };
                    let rendered = render(&scene, &settings, &progress);
                    assert!(rendered.complete, "{settings:?}");
                    tell.send(settings).unwrap();
                }
            }
        });
        for done in 0..3 * stops.len() {
            let settings = told.recv_timeout(Duration::from_secs(100));
            settings.unwrap_or_else(|error| panic!("{error} after {done} renderings"));
        }
    }

    /// From any thread, at any time; the last ones are close to the picture.
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
            Stop::TargetError { target, max_samples: 1024, limit: None, error_layers: false },
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
