//! The same number of samples for every pixel: passes over all tiles.

use std::ops::Range;

use glam::Vec3;
use lookat_scene::{Sampler, SamplerKind, View};
use rayon::prelude::*;

use super::Settings;
use super::control::Meter;
use super::sample::{Context, Job, Pattern, Samples};
use crate::film::{Pixel, REPLICATES, Tile, places, tiles};
use crate::integrator::{FirstHit, Tracer};
use crate::sampler::{SampleStream, replicate_seed};

/// The most samples of a pixel where nothing else limits them.
const MOST: u32 = 1 << 30;

/// Samples that are taken of every pixel before the next pass begins.
struct Pass {
    pattern: Pattern,
    samples: Range<u32>,
}

/// The pattern of a picture, with as many samples as there may be.
pub(super) fn sampler(view: &View, settings: &Settings) -> Sampler {
    if settings.time.is_none() && !settings.adaptive {
        return view.sampler;
    }
    let kind = match view.sampler.kind {
        SamplerKind::Random => SamplerKind::Random,
        SamplerKind::Stratified { .. } | SamplerKind::Halton { .. } | SamplerKind::Sobol => {
            SamplerKind::Sobol
        }
    };
    let samples_per_pixel = match settings.time {
        Some(_) => settings.max_samples.unwrap_or(MOST).clamp(1, MOST),
        None => view.sampler.samples_per_pixel,
    };
    Sampler { kind, samples_per_pixel }
}

/// Passes of 1, 1, 2, 4, ... samples per pixel over the whole picture, so that breaking off leaves a whole picture. The
/// samples of a pixel are added up in their order, so the passes do not change it. With error layers each pass is a
/// replicate.
fn passes(sampler: Sampler, settings: &Settings) -> Vec<Pass> {
    let samples = sampler.samples_per_pixel;
    if has_spreads(settings) {
        let count = samples.min(REPLICATES);
        let replicate = |i: u32| {
            // Patterns without jitter are all the same, and show no error.
            let sampler = sampler.jittered().with_samples(samples / count + u32::from(i < samples % count));
            let pattern = Pattern { sampler, seed: replicate_seed(settings.seed, i), is_watched: false };
            Pass { pattern, samples: 0..sampler.samples_per_pixel }
        };
        return (0..count).map(replicate).collect();
    }
    let mut from = 0;
    let pass = |to| {
        let samples = from..to;
        from = to;
        Pass { pattern: Pattern { sampler, seed: settings.seed, is_watched: false }, samples }
    };
    doubled(1, samples).map(pass).collect()
}

/// `from`, twice as many, and so on, to `to`; nothing if that is less.
pub(super) fn doubled(from: u32, to: u32) -> impl Iterator<Item = u32> {
    let ends = std::iter::successors(Some(from), |end| end.checked_mul(2));
    ends.take_while(move |end| *end < to).chain((from <= to).then_some(to))
}

/// Error layers need replicates, and these need a number of samples.
fn has_spreads(settings: &Settings) -> bool {
    settings.error_layers && settings.time.is_none()
}

/// Renders pass after pass.
pub(super) fn render<F>(context: &Context<F>, settings: &Settings) -> Vec<Tile>
where
    F: Fn(&mut Tracer, &FirstHit, &mut SampleStream) -> Vec3 + Sync,
{
    let crop = context.view.film.crop;
    let sampler = sampler(context.view, settings);
    let mut tiles = tiles(crop, has_spreads(settings));
    context.control.expect(crop.area() * u64::from(sampler.samples_per_pixel));
    for pass in passes(sampler, settings) {
        tiles.par_iter_mut().for_each(|tile| render_tile(context, tile, &pass));
        if context.control.is_stopped() {
            break;
        }
    }
    tiles.iter_mut().for_each(|tile| tile.settle(context.filter.weight()));
    tiles
}

fn render_tile<F>(context: &Context<F>, tile: &mut Tile, pass: &Pass)
where
    F: Fn(&mut Tracer, &FirstHit, &mut SampleStream) -> Vec3,
{
    if context.control.is_stopped() {
        return;
    }
    let (mut tracer, mut meter) = (context.tracer(), Meter::new(context.control));
    let has_spreads = !tile.spreads.is_empty();
    let job = |(place, pixel): ([u32; 2], &Pixel)| {
        let before = if has_spreads { Pixel::default() } else { *pixel };
        Job { pattern: pass.pattern, place, indices: pass.samples.clone(), samples: Samples::after(before) }
    };
    let mut jobs: Vec<Job> = places(tile.bounds).zip(&tile.pixels).map(job).collect();
    context.sample_all(&mut tracer, &mut meter, &mut jobs);
    let mut spreads = tile.spreads.iter_mut();
    for (pixel, Job { samples, .. }) in tile.pixels.iter_mut().zip(&jobs) {
        match spreads.next() {
            // Half a replicate is none.
            Some(_) if samples.sum.count() < pass.samples.end => {}
            Some(spread) => {
                spread.add(&samples.sum);
                *pixel += samples.sum;
            }
            None => *pixel = samples.sum,
        }
    }
    context.control.add(tracer.rays, jobs.iter().map(|job| job.samples.rejected).sum());
}
