//! From a scene to a picture: passes over tiles, on all threads.

use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use glam::{DVec2, Vec3};
use lookat_image::Image;
use lookat_scene::{Integrator, Sampler, Scene};
use rayon::prelude::*;

use crate::arithmetic::Precision;
use crate::camera::{CameraRay, CameraRays};
use crate::film::{Pixel, Tile, develop, limited, tiles};
use crate::filter::FilterSampler;
use crate::integrator::{Tracer, ambient, direct, path};
use crate::light::LightTable;
use crate::prepare::Traceable;

use crate::sampler::{SampleStream, replicate_seed};

/// How to render, apart from what the scene says.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Settings {
    /// Chooses the random numbers. The same scene, seed and version give the same picture. Default 0.
    pub seed: u64,
    /// Threads; 0, the default, is one for each processor. They do not change the picture.
    pub threads: usize,
    /// Whether to estimate the error of each pixel, and to give it as the layers of [`lookat_image::PixelError`].
    /// The samples of a pixel are then split into independent replicates, each a pattern of its own, because samples of
    /// one pattern do not tell how large its error is. Smaller patterns are noisier, so the picture is another one, and
    /// up to a few times noisier in smooth scenes. Default false.
    pub error_layers: bool,
    /// What intersections are computed with.
    pub precision: Precision,
}

/// Replicates of each pixel when its error is asked for: with 16 of them intervals by Student's t hold what they promise,
/// with 4 and 8 they do not.
const REPLICATES: u32 = 16;

/// How far a rendering is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Camera samples done.
    pub done: u64,
    /// Camera samples in all.
    pub total: u64,
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
    /// Whether all samples were taken; not so after the callback broke off.
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
}

/// Renders a scene. `progress` is called from any thread every now and then; when it breaks, the rendering ends soon and
/// gives what there is: every pixel with the samples that it has so far.
pub fn render(
    scene: &Scene,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Rendered {
    let run = || run(scene, settings, progress);
    match rayon::ThreadPoolBuilder::new().num_threads(settings.threads).build() {
        Ok(pool) => pool.install(run),
        // No threads of our own: those of the caller.
        Err(_) => run(),
    }
}

fn run(
    scene: &Scene,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Rendered {
    let started = Instant::now();
    let traceable = Traceable::new(scene, settings.precision);
    let lights = LightTable::new(scene, &traceable);
    let prepared = Prepared { scene, lights, traceable, preparation: started.elapsed() };
    // The integrator is chosen here, once, so that the loop over samples is compiled for it.
    match scene.integrator {
        Integrator::DirectLighting { all_lights, max_depth } => {
            render_passes(&prepared, settings, progress, |tracer, camera_ray, stream| {
                direct::li(tracer, camera_ray, stream, all_lights, max_depth)
            })
        }
        Integrator::Path { max_depth, roulette_threshold, light_choice } => {
            let path = path::Settings { max_depth, roulette_threshold, light_choice };
            render_passes(&prepared, settings, progress, |tracer, camera_ray, stream| {
                path::li(tracer, camera_ray, stream, &path)
            })
        }
        Integrator::AmbientOcclusion { cosine, samples } => {
            render_passes(&prepared, settings, progress, |tracer, camera_ray, stream| {
                ambient::li(tracer, camera_ray, stream, cosine, samples)
            })
        }
    }
}

/// The scene, and what is made of it once.
struct Prepared<'s> {
    scene: &'s Scene,
    traceable: Traceable<'s>,
    lights: LightTable<'s>,
    preparation: Duration,
}

/// What every sample needs.
struct Context<'a> {
    prepared: &'a Prepared<'a>,
    camera: CameraRays,
    filter: FilterSampler,
}

/// Samples that are taken of every pixel before the next pass begins.
struct Pass {
    sampler: Sampler,
    seed: u64,
    samples: Range<u32>,
}

/// Passes of 1, 1, 2, 4, ... samples per pixel over the whole picture, so that breaking off leaves a whole picture. The
/// samples of a pixel are added up in their order, so the passes do not change it. With error layers each pass is a
/// replicate.
fn passes(sampler: &Sampler, settings: &Settings) -> Vec<Pass> {
    let samples = sampler.samples_per_pixel;
    if settings.error_layers {
        let count = samples.min(REPLICATES);
        let replicate = |i: u32| {
            // Patterns without jitter are all the same, and show no error.
            let sampler = sampler.jittered().with_samples(samples / count + u32::from(i < samples % count));
            let seed = replicate_seed(settings.seed, i);
            Pass { samples: 0..sampler.samples_per_pixel, sampler, seed }
        };
        return (0..count).map(replicate).collect();
    }
    let ends = std::iter::successors(Some(1), |end: &u32| Some(end.saturating_mul(2).min(samples)));
    let mut from = 0;
    let pass = |to| {
        let samples = from..to;
        from = to;
        Pass { sampler: *sampler, seed: settings.seed, samples }
    };
    ends.take_while(|end| *end < samples).chain([samples]).map(pass).collect()
}

/// Renders pass after pass.
fn render_passes<F>(
    prepared: &Prepared,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    li: F,
) -> Rendered
where
    F: Fn(&mut Tracer, &CameraRay, &mut SampleStream) -> Vec3 + Sync,
{
    let scene = prepared.scene;
    let (camera, filter) = (CameraRays::new(&scene.camera, &scene.film), FilterSampler::new(&scene.filter));
    let context = Context { prepared, camera, filter };
    let mut tiles = tiles(scene.film.crop, settings.error_layers);
    let total = scene.film.crop.area() * u64::from(scene.sampler.samples_per_pixel);
    let stopped = AtomicBool::new(false);
    let (done, rays, rejected) = (AtomicU64::new(0), AtomicU64::new(0), AtomicU64::new(0));
    for pass in passes(&scene.sampler, settings) {
        tiles.par_iter_mut().for_each(|tile| {
            if stopped.load(Ordering::Relaxed) {
                return;
            }
            let counts = render_tile(&context, tile, &pass, &li);
            rays.fetch_add(counts.rays, Ordering::Relaxed);
            rejected.fetch_add(counts.rejected, Ordering::Relaxed);
            let done = done.fetch_add(counts.samples, Ordering::Relaxed) + counts.samples;
            if progress(Progress { done, total }).is_break() {
                stopped.store(true, Ordering::Relaxed);
            }
        });
    }
    let statistics =
        Statistics { samples: done.into_inner(), rays: rays.into_inner(), rejected: rejected.into_inner() };
    Rendered {
        image: develop(&tiles, &scene.film, context.filter.weight()),
        statistics,
        preparation: prepared.preparation,
        complete: statistics.samples == total,
    }
}

fn render_tile<F>(context: &Context, tile: &mut Tile, pass: &Pass, li: &F) -> Statistics
where
    F: Fn(&mut Tracer, &CameraRay, &mut SampleStream) -> Vec3,
{
    let scene = context.prepared.scene;
    let mut tracer = Tracer::new(&context.prepared.traceable, &context.prepared.lights);
    let mut counts = Statistics::default();
    let spacing = f64::from(scene.sampler.samples_per_pixel).sqrt().recip();
    let bounds = tile.bounds;
    let places = (bounds.y0..bounds.y1).flat_map(|y| (bounds.x0..bounds.x1).map(move |x| [x, y]));
    let mut spreads = tile.spreads.iter_mut();
    for (pixel, place) in tile.pixels.iter_mut().zip(places) {
        let center = DVec2::new(f64::from(place[0]) + 0.5, f64::from(place[1]) + 0.5);
        let spread = spreads.next();
        let mut sum = if spread.is_some() { Pixel::default() } else { *pixel };
        for index in pass.samples.clone() {
            let mut stream = SampleStream::new(&pass.sampler, pass.seed, place, index);
            let (offset, negative) = context.filter.sample(stream.next_2d());
            let on_lens = if context.camera.has_lens() { stream.next_2d() } else { DVec2::ZERO };
            let film = center + offset;
            let camera_ray = CameraRay { camera: &context.camera, film, on_lens, spacing };
            let mut radiance = li(&mut tracer, &camera_ray, &mut stream);
            if !radiance.is_finite() {
                debug_assert!(false, "radiance {radiance} in pixel {place:?}, sample {index}");
                counts.rejected += 1;
                radiance = Vec3::ZERO;
            }
            sum.add(limited(radiance, &scene.film), negative);
            counts.samples += 1;
        }
        match spread {
            Some(spread) => {
                spread.add(&sum);
                *pixel += sum;
            }
            None => *pixel = sum,
        }
    }
    Statistics { rays: tracer.rays, ..counts }
}
