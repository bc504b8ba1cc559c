//! Renders with a target error: samples all unfinished pixels in rounds, until each pixel reaches the target.
//!
//! Each pixel has 16 replicates. Each replicate is an Owen-scrambled Sobol' pattern of its own, whose number of samples
//! doubles in each round. Each pixel is judged after a whole round, by its own samples and by the samples of its
//! neighbors. The picture therefore does not depend on threads or on the order of tiles.

use std::array::from_fn;
use std::sync::{Mutex, PoisonError};

use glam::Vec3;
use lookat_image::PixelError;
use lookat_scene::{PixelBounds, Sampler, SamplerKind};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::control::{Control, Meter};
use super::forecast::Sampled;
use super::sample::{Context, Job, Pattern, Samples, Seen};
use super::stop::{Brightness, Estimate, StopRule};
use super::{Reached, Settings, TargetError};
use crate::color::luminance;
use crate::film::{Pixel, REPLICATES, SignedSum, Spread, Sum, Tile, places, tile_side, tiles};
use crate::integrator::{FirstHit, Tracer};
use crate::sampler::{SampleStream, replicate_seed};

/// Samples per pixel in the first round: 4 in each replicate.
pub(super) const FIRST: u32 = 4 * REPLICATES;

/// The default for the most samples of a pixel.
const MOST: u32 = 1 << 16;

/// A sample is an outlier if it is this many times as bright as the brightest pixel around it.
const OUTLIER: f64 = 20.0;

/// A tile and the state of its pixels.
struct Part {
    tile: Tile,
    /// The bounds of the samples of each pixel.
    seen: Vec<Seen>,
    /// The unfinished pixels. `None` before the first round, because they take much memory.
    active: Option<Vec<Active>>,
    has_lobes: bool,
}

/// The replicates of an unfinished pixel.
struct Active {
    /// The index of the pixel in its tile.
    at: usize,
    /// Samples in each replicate.
    count: u32,
    sums: [Sum; REPLICATES as usize],
    /// `Some` only if the filter has negative lobes.
    signed: Option<Box<[SignedSum; REPLICATES as usize]>>,
    /// The error over the target error, after the last round.
    excess: f64,
}

/// Renders all pixels until they reach the target error, or a limit of samples or time.
pub(super) fn render<F>(
    context: &Context<F>,
    settings: &Settings,
    target: &TargetError,
) -> (Vec<Tile>, Reached)
where
    F: Fn(&mut Tracer, &FirstHit, &mut SampleStream) -> Vec3 + Sync,
{
    let crop = context.view.film.crop;
    let has_lobes = context.filter.weight() != 1.0;
    let mut parts: Vec<Part> =
        tiles(crop, false).into_iter().map(|tile| Part::new(tile, has_lobes)).collect();
    let most = settings.max_samples.unwrap_or(MOST).max(FIRST) / REPLICATES;
    context.control.expect(crop.area() * u64::from(FIRST));
    if settings.time.is_some() {
        // The time may end before the first round does.
        parts.par_iter_mut().for_each(|part| part.preview(context, settings.seed));
    }
    let mut count = FIRST / REPLICATES;
    let weight = context.filter.weight();
    let rule = StopRule::new(target);
    let first =
        FirstRound { rule, most, weight, parts: parts.len(), pixels: crop.area(), known: Mutex::default() };
    let mut shuffled: Vec<&mut Part> = parts.iter_mut().collect();
    shuffled.shuffle(&mut Pcg64Mcg::seed_from_u64(settings.seed));
    context.control.expect_between(None);
    shuffled.into_par_iter().for_each(|part| {
        part.sample(context, settings.seed, count);
        first.forecast(part, context.control);
    });
    let rule = rule.with_brightness(brightness(&parts, weight));
    loop {
        judge(&mut parts, weight, &rule);
        let active = || parts.iter().flat_map(Part::active);
        context.control.set_pixels_done(crop.area() - active().count() as u64);
        if active().next().is_none() || count >= most || context.control.is_stopped() {
            break;
        }
        let left = |power| active().map(|active| left(active.count, active.excess, power, most)).sum::<u64>();
        let totals = POWERS.map(|power| context.control.done() + left(power));
        context.control.expect(totals[0]);
        context.control.expect_between(Some(totals));
        // Sobol' patterns are best at powers of two.
        count = (2 * count).min(most);
        parts.par_iter_mut().for_each(|part| part.sample(context, settings.seed, count));
    }
    let reached = reached(&parts, most, context.filter.weight());
    let mut tiles: Vec<Tile> = parts.into_iter().map(|part| part.tile).collect();
    if !settings.error_layers {
        tiles.iter_mut().for_each(|tile| tile.errors.clear());
    }
    (tiles, reached)
}

impl Part {
    fn new(mut tile: Tile, has_lobes: bool) -> Part {
        let area = tile.pixels.len();
        tile.errors =
            vec![PixelError { standard_error: [f32::INFINITY; 3], samples: 0, replicates: 0 }; area];
        Part { tile, seen: vec![Seen::NOTHING; area], active: None, has_lobes }
    }

    fn all_active(&self) -> Vec<Active> {
        let active = |at| Active {
            at,
            count: 0,
            sums: Default::default(),
            signed: self.has_lobes.then(Default::default),
            excess: f64::INFINITY,
        };
        (0..self.seen.len()).map(active).collect()
    }

    /// The unfinished pixels. Empty before the first round.
    fn active(&self) -> &[Active] {
        self.active.as_deref().unwrap_or_default()
    }

    /// Takes one sample of each pixel, to have a whole picture soon. The first round replaces these samples.
    fn preview<F>(&mut self, context: &Context<F>, seed: u64)
    where
        F: Fn(&mut Tracer, &FirstHit, &mut SampleStream) -> Vec3,
    {
        let (mut tracer, mut meter) = (context.tracer(), Meter::new(context.control));
        let job = |(place, pixel): ([u32; 2], &Pixel)| Job {
            pattern: pattern(seed, 0, 1),
            place,
            indices: 0..1,
            samples: Samples::after(*pixel),
        };
        let mut jobs: Vec<Job> = places(self.tile.bounds).zip(&self.tile.pixels).map(job).collect();
        if !context.control.is_stopped() {
            context.sample_all(&mut tracer, &mut meter, &mut jobs);
        }
        for (pixel, Job { samples, .. }) in self.tile.pixels.iter_mut().zip(&jobs) {
            *pixel = samples.sum;
        }
        context.control.add(tracer.rays, jobs.iter().map(|job| job.samples.rejected).sum());
    }

    /// Samples all unfinished pixels until each replicate has `count` samples. Stops early if the rendering stops.
    fn sample<F>(&mut self, context: &Context<F>, seed: u64, count: u32)
    where
        F: Fn(&mut Tracer, &FirstHit, &mut SampleStream) -> Vec3,
    {
        let (mut tracer, mut meter) = (context.tracer(), Meter::new(context.control));
        let mut rejected = 0;
        let bounds = self.tile.bounds;
        if context.control.is_stopped() {
            return;
        }
        let mut all_active = self.active.take().unwrap_or_else(|| self.all_active());
        for active in &mut all_active {
            if context.control.is_stopped() {
                break;
            }
            let at = active.at as u32;
            let place = [bounds.x0 + at % bounds.width(), bounds.y0 + at / bounds.width()];
            let Some(replicates) =
                replicates(context, &mut tracer, &mut meter, (place, seed), active.count..count)
            else {
                break;
            };
            let pixel = &mut self.tile.pixels[active.at];
            if active.count == 0 {
                *pixel = Pixel::default();
            }
            for (r, Job { samples, .. }) in replicates.iter().enumerate() {
                active.sums[r].add(&samples.sum);
                if let Some(signed) = &mut active.signed {
                    signed[r].add(&samples.sum);
                }
                *pixel += samples.sum;
                self.seen[active.at] = self.seen[active.at].union(samples.seen);
                rejected += samples.rejected;
            }
            active.count = count;
        }
        self.active = Some(all_active);
        context.control.add(tracer.rays, rejected);
    }
}

/// The sample pattern of replicate `r` of a pixel.
fn pattern(seed: u64, r: u32, count: u32) -> Pattern {
    let sampler = Sampler { kind: SamplerKind::Sobol, samples_per_pixel: count };
    Pattern { sampler, seed: replicate_seed(seed, r), is_watched: true }
}

/// Takes the samples `indices` of all replicates of a pixel. `None` if the rendering stops.
fn replicates<F>(
    context: &Context<F>,
    tracer: &mut Tracer,
    meter: &mut Meter,
    (place, seed): ([u32; 2], u64),
    indices: std::ops::Range<u32>,
) -> Option<[Job; REPLICATES as usize]>
where
    F: Fn(&mut Tracer, &FirstHit, &mut SampleStream) -> Vec3,
{
    let mut jobs = from_fn(|r| Job {
        pattern: pattern(seed, r as u32, indices.end),
        place,
        indices: indices.clone(),
        samples: Samples::after(Pixel::default()),
    });
    context.sample_all(tracer, meter, &mut jobs);
    (!context.control.is_stopped()).then_some(jobs)
}

impl Active {
    /// The spread of the replicates, which gives the error of their mean.
    fn spread(&self) -> Spread {
        let mut spread = Spread::default();
        for (r, sum) in self.sums.iter().enumerate() {
            spread.add(&sum.pixel(self.count, self.signed.as_ref().map(|signed| &signed[r])));
        }
        spread
    }

    /// The error of the pixel over the target error, and the error itself. `around` bounds the samples of the pixel and
    /// its neighbors.
    fn judge(&self, pixel: &Pixel, around: Seen, rule: &StopRule, weight: f64) -> (f64, PixelError) {
        let error = self.spread().error(pixel, weight);
        let standard_error = error.standard_error.into();
        let estimate = Estimate { value: pixel.value(weight), standard_error, count: self.count, around };
        (if self.count == 0 { f64::INFINITY } else { rule.excess(&estimate) }, error)
    }
}

/// The brightness of the picture so far.
fn brightness(parts: &[Part], weight: f64) -> f64 {
    let mut brightness = Brightness::default();
    parts.iter().flat_map(|part| &part.tile.pixels).for_each(|pixel| brightness.add(pixel.value(weight)));
    brightness.get()
}

/// Computes the errors of all unfinished pixels, and removes the finished pixels from the list.
fn judge(parts: &mut [Part], weight: f64, rule: &StopRule) {
    let judge = |index: usize| -> Vec<(f64, PixelError)> {
        let part = &parts[index];
        let pixels = part.active().iter().map(|active| {
            let seen = around(parts, index, active.at).fold(Seen::NOTHING, |all, (seen, _)| all.union(*seen));
            active.judge(&part.tile.pixels[active.at], seen, rule, weight)
        });
        pixels.collect()
    };
    let judged: Vec<_> = (0..parts.len()).into_par_iter().map(judge).collect();
    parts.par_iter_mut().zip(judged).for_each(|(part, judged)| {
        let Some(all_active) = &mut part.active else { return };
        for (active, (excess, error)) in all_active.iter_mut().zip(judged) {
            active.excess = excess;
            if active.count > 0 {
                part.tile.errors[active.at] = error;
            }
        }
        all_active.retain(|active| active.excess > 1.0 || active.excess.is_nan());
        all_active.shrink_to_fit();
    });
}

/// A pixel of a tile, and its up to eight neighbors.
fn around(parts: &[Part], index: usize, at: usize) -> impl Iterator<Item = (&Seen, &Pixel)> {
    let bounds = parts[index].tile.bounds;
    let (first, last) = (parts[0].tile.bounds, parts[parts.len() - 1].tile.bounds);
    let (x, y) = (bounds.x0 + at as u32 % bounds.width(), bounds.y0 + at as u32 / bounds.width());
    let side = tile_side(PixelBounds { x1: last.x1, y1: last.y1, ..first });
    let across = (last.x0 - first.x0) / side + 1;
    let columns = x.saturating_sub(1).max(first.x0)..=(x + 1).min(last.x1 - 1);
    let rows = y.saturating_sub(1).max(first.y0)..=(y + 1).min(last.y1 - 1);
    rows.flat_map(move |y| columns.clone().map(move |x| (x, y))).map(move |(x, y)| {
        let (column, row) = (x - first.x0, y - first.y0);
        let part = &parts[(row / side * across + column / side) as usize];
        let at = (row % side * part.tile.bounds.width() + column % side) as usize;
        (&part.seen[at], &part.tile.pixels[at])
    })
}

/// The fastest and the slowest convergence: the error of a pixel falls with this power of its samples. Independent
/// samples have 1/2, and Sobol' patterns more. The slowest power is below 1/2, because few samples often underestimate
/// the error.
const POWERS: [f64; 2] = [0.75, 0.45];

/// The remaining samples of a pixel with `count` samples per replicate, whose error is `excess` times the target error
/// and falls with `power`. A replicate takes at most `most` samples.
fn left(count: u32, excess: f64, power: f64, most: u32) -> u64 {
    let all = f64::from(count) * excess.powf(power.recip());
    let all = if all < f64::from(most) { (all as u32).next_power_of_two().min(most) } else { most };
    u64::from(all.max(2 * count).min(most) - count) * u64::from(REPLICATES)
}

/// Estimates the total number of samples during the first round. The round renders the parts in random order.
struct FirstRound {
    rule: StopRule,
    most: u32,
    weight: f64,
    parts: usize,
    pixels: u64,
    /// The brightness of the pixels so far, and the remaining samples of each part at the fastest and at the slowest
    /// convergence.
    known: Mutex<(Brightness, [Sampled; 2])>,
}

impl FirstRound {
    /// Adds a part that has finished the first round, and updates the bounds of the total number of samples.
    fn forecast(&self, part: &Part, control: &Control) {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let (brightness, lefts) = &mut *known;
        part.tile.pixels.iter().for_each(|pixel| brightness.add(pixel.value(self.weight)));
        let rule = self.rule.with_brightness(brightness.get());
        let (mut fastest, mut slowest) = (0, 0);
        for active in part.active().iter().filter(|active| active.count > 0) {
            let seen = part.seen[active.at];
            let (excess, _) = active.judge(&part.tile.pixels[active.at], seen, &rule, self.weight);
            if excess > 1.0 {
                fastest += left(active.count, excess, POWERS[0], self.most);
                slowest += left(active.count, excess, POWERS[1], self.most);
            }
        }
        lefts[0].add(fastest as f64);
        lefts[1].add(slowest as f64);
        let first = self.pixels * u64::from(FIRST);
        let [least, most] = [lefts[0].sum(self.parts, -1.0), lefts[1].sum(self.parts, 1.0)];
        // Keep the lock, so that an older forecast never replaces a newer one.
        control
            .expect_between(least.zip(most).map(|(least, most)| [first + least as u64, first + most as u64]));
    }
}

/// Counts the pixels by whether they reached the target error.
fn reached(parts: &[Part], most: u32, weight: f64) -> Reached {
    let active = || parts.iter().flat_map(Part::active);
    let at_cap = active().filter(|active| active.count >= most).count() as u64;
    let not_begun = parts.iter().filter(|part| part.active.is_none()).map(|part| part.seen.len() as u64);
    let out_of_time = active().count() as u64 - at_cap + not_begun.sum::<u64>();
    let pixels = parts.iter().map(|part| part.seen.len() as u64).sum::<u64>();
    let bright = |rgb: Vec3| if rgb.is_finite() { luminance(rgb) } else { 0.0 };
    let is_outlier = |(index, at): (usize, usize)| {
        let brightest = around(parts, index, at).map(|(_, pixel)| bright(pixel.value(weight).as_vec3()));
        bright(parts[index].seen[at].most) > OUTLIER * brightest.fold(0.0, f64::max)
    };
    let outliers =
        |index: usize| (0..parts[index].seen.len()).filter(|at| is_outlier((index, *at))).count() as u64;
    let outliers = (0..parts.len()).into_par_iter().map(outliers).sum();
    Reached { within: pixels - at_cap - out_of_time, at_cap, out_of_time, outliers }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `around` finds all neighbors of each pixel, also in other tiles.
    #[test]
    fn neighbors_are_found_across_tiles() {
        for (width, height) in [(35, 18), (3, 90), (2, 2)] {
            let crop = PixelBounds { x0: 5, y0: 7, x1: 5 + width, y1: 7 + height };
            let mut parts: Vec<Part> =
                tiles(crop, false).into_iter().map(|tile| Part::new(tile, false)).collect();
            let number = |[x, y]: [u32; 2]| Vec3::new(x as f32, y as f32, 0.0);
            for part in &mut parts {
                part.seen =
                    places(part.tile.bounds).map(|at| Seen { least: number(at), most: number(at) }).collect();
            }
            for (index, part) in parts.iter().enumerate() {
                for (at, [x, y]) in places(part.tile.bounds).enumerate() {
                    let found: Vec<Vec3> = around(&parts, index, at).map(|(seen, _)| seen.least).collect();
                    let all = places(crop).filter(|[a, b]| a.abs_diff(x) <= 1 && b.abs_diff(y) <= 1);
                    assert_eq!(found, all.map(number).collect::<Vec<Vec3>>());
                }
            }
        }
    }
}
