//! Renders with a target error: samples all unfinished pixels in rounds, until each pixel reaches the target.
//!
//! Each pixel has 16 replicates. Each replicate is an Owen-scrambled Sobol' pattern of its own, whose number of samples
//! doubles in each round. Each pixel is judged after a whole round, by its own samples and by the samples of its
//! neighbors. The picture therefore does not depend on threads or on the order of tiles.

mod forecast;

use std::ops::Deref;
use std::sync::Mutex;

use glam::Vec3;
use lookat_scene::{PixelBounds, Sampler, SamplerKind};
use rayon::prelude::*;

use super::control::Control;
use super::rounds::Policy;
use super::sample::{Job, Pattern, Seen};
use super::stop::{Brightness, Estimate, StopRule};
use super::{Reached, TargetError};
use crate::color::luminance;
use crate::film::{Film, Pixel, REPLICATES, Spread, Tile, tile_side};
use crate::sampler::replicate_seed;
use forecast::{FirstRound, POWERS, left};

/// Samples per pixel in the first round: 4 in each replicate.
pub(super) const FIRST: u32 = 4 * REPLICATES;

/// Bytes of a pixel beside the film, about, until it is done.
pub(super) const PIXEL_BYTES: usize = 370;

/// A sample is an outlier if it is this many times as bright as the brightest pixel around it.
const OUTLIER: f64 = 20.0;

/// What is known of the pixels of a tile.
pub(super) struct Part {
    /// The bounds of the samples of each pixel.
    seen: Vec<Seen>,
    /// The unfinished pixels. `None` before the first round, because they take much memory.
    active: Option<Vec<Active>>,
}

/// The replicates of an unfinished pixel.
struct Active {
    /// The index of the pixel in its tile.
    at: usize,
    /// Samples in each replicate.
    count: u32,
    replicates: [Replicate; REPLICATES as usize],
    /// The error over the target error, after the last round.
    excess: f64,
}

/// The signed sum and the signed count of the samples of a replicate, see [`Pixel`]. Single precision serves, as there may be
/// many.
#[derive(Clone, Copy, Default)]
struct Replicate {
    signed: Vec3,
    signs: i32,
}

/// Which samples are taken next.
#[derive(Clone, Copy, PartialEq)]
enum Round {
    /// None so far.
    Start,
    /// One of each pixel, to have a whole picture soon. The first round replaces these samples.
    Preview,
    /// As many of all unfinished pixels as their replicates lack of this number.
    Replicates(u32),
}

/// Samples until pixels reach the target error, or a limit of samples.
pub(super) struct Target {
    seed: u64,
    /// The most samples of a replicate.
    most: u32,
    /// Whether the time may end before the first round does.
    has_preview: bool,
    first: FirstRound,
    rule: StopRule,
    round: Round,
}

impl Target {
    pub fn new(sampler: Sampler, seed: u64, target: &TargetError, has_limit: bool) -> Target {
        let most = sampler.samples_per_pixel / REPLICATES;
        let rule = StopRule::new(target);
        Target {
            seed,
            most,
            has_preview: has_limit,
            first: FirstRound { rule, most, known: Mutex::default() },
            rule,
            round: Round::Start,
        }
    }

    fn is_first(&self) -> bool {
        self.round == Round::Replicates(FIRST / REPLICATES)
    }

    /// The sample pattern of a replicate of a pixel.
    fn pattern(&self, replicate: u32, count: u32) -> Pattern {
        let sampler = Sampler { kind: SamplerKind::Sobol, samples_per_pixel: count };
        Pattern { sampler, seed: replicate_seed(self.seed, replicate), is_watched: true }
    }

    /// Counts the pixels by whether they reached the target error.
    pub fn reached(&self, film: &Film, parts: &[Part]) -> Reached {
        let active = || parts.iter().flat_map(Part::active);
        let at_cap = active().filter(|active| active.count >= self.most).count() as u64;
        let not_begun = parts.iter().filter(|part| part.active.is_none()).map(|part| part.seen.len() as u64);
        let out_of_time = active().count() as u64 - at_cap + not_begun.sum::<u64>();
        let tiles = film.lock();
        let outliers = |index: usize| {
            let is_outlier = |at: &usize| is_outlier(film, &tiles, parts, (index, *at));
            (0..parts[index].seen.len()).filter(is_outlier).count() as u64
        };
        let outliers = (0..parts.len()).into_par_iter().map(outliers).sum();
        Reached { within: film.crop().area() - at_cap - out_of_time, at_cap, out_of_time, outliers }
    }
}

impl Policy for Target {
    type State = Part;

    fn begin(&self, tile: &Tile) -> Part {
        Part { seen: vec![Seen::NOTHING; tile.bounds.area() as usize], active: None }
    }

    fn next(&mut self, film: &Film, parts: &mut [Part], control: &Control) -> bool {
        let first = Round::Replicates(FIRST / REPLICATES);
        self.round = match self.round {
            Round::Start => {
                control.expect(film.crop().area() * u64::from(FIRST));
                if self.has_preview { Round::Preview } else { first }
            }
            Round::Preview => first,
            Round::Replicates(count) => {
                if self.is_first() {
                    let mut brightness = Brightness::default();
                    let tiles = film.lock();
                    let pixels = tiles.iter().flat_map(|tile| tile.pixels());
                    pixels.for_each(|pixel| brightness.add(film.value(&pixel)));
                    self.rule = self.rule.with_brightness(brightness.get());
                }
                judge(film, parts, &self.rule);
                let active = || parts.iter().flat_map(Part::active);
                control.set_pixels_done(film.crop().area() - active().count() as u64);
                if active().next().is_none() || count >= self.most || control.is_stopped() {
                    return false;
                }
                let left =
                    |power| active().map(|active| left(active, active.excess, power, self.most)).sum::<u64>();
                let totals = POWERS.map(|power| control.done() + left(power));
                control.expect(totals[0]);
                control.expect_between(Some(totals));
                // Sobol' patterns are best at powers of two.
                Round::Replicates((2 * count).min(self.most))
            }
        };
        if self.round == first {
            control.expect_between(None);
        }
        true
    }

    fn is_shuffled(&self) -> bool {
        self.is_first()
    }

    fn jobs(&self, tile: &Tile, part: &mut Part) -> Vec<Job> {
        let bounds = tile.bounds;
        let place =
            |at: usize| [bounds.x0 + at as u32 % bounds.width(), bounds.y0 + at as u32 / bounds.width()];
        let Round::Replicates(count) = self.round else {
            let job = |at| Job::new(self.pattern(0, 1), place(at), 0..1);
            return (0..part.seen.len()).map(job).collect();
        };
        let area = part.seen.len();
        let active = part.active.get_or_insert_with(|| (0..area).map(Active::new).collect());
        let of_pixel = |active: &Active| {
            let (from, place) = (active.count, place(active.at));
            (0..REPLICATES).map(move |r| Job::new(self.pattern(r, count), place, from..count))
        };
        active.iter().flat_map(of_pixel).collect()
    }

    fn add(&self, jobs: &[Job], film: &Film, tile: &mut Tile, part: &mut Part) {
        let Part { seen, active: Some(all_active) } = part else {
            return jobs.iter().enumerate().for_each(|(at, job)| tile.add(at, &job.samples.pixel));
        };
        let is_whole = |job: &Job| job.samples.pixel.all.count == job.indices.len() as u32;
        for (active, jobs) in all_active.iter_mut().zip(jobs.chunks(REPLICATES as usize)) {
            // The rendering has been stopped.
            if !jobs.iter().all(is_whole) {
                break;
            }
            if active.count == 0 {
                tile.clear(active.at);
            }
            for (replicate, Job { samples, indices, .. }) in active.replicates.iter_mut().zip(jobs) {
                replicate.signed += samples.pixel.signed(film.scale).as_vec3();
                replicate.signs += samples.pixel.signs() as i32;
                tile.add(active.at, &samples.pixel);
                seen[active.at] = seen[active.at].union(samples.seen);
                active.count = indices.end;
            }
        }
    }

    fn finish(&self, film: &Film, tile: &Tile, part: &Part, control: &Control) {
        if self.is_first() {
            self.first.forecast(film, tile, part, control);
        }
    }
}

impl Part {
    /// The unfinished pixels. Empty before the first round.
    fn active(&self) -> &[Active] {
        self.active.as_deref().unwrap_or_default()
    }
}

impl Active {
    fn new(at: usize) -> Active {
        Active { at, count: 0, replicates: Default::default(), excess: f64::INFINITY }
    }

    /// The spread of the replicates, which gives the error of their mean.
    fn spread(&self, film: &Film) -> Spread {
        let mut spread = Spread::default();
        for Replicate { signed, signs } in self.replicates {
            spread.add(signed.as_dvec3(), f64::from(signs), self.count, film.scale);
        }
        spread
    }

    /// The error of the pixel over the target error, and the spread that tells it. `around` bounds the samples of the pixel
    /// and its neighbors.
    fn judge(&self, film: &Film, pixel: &Pixel, around: Seen, rule: &StopRule) -> (f64, Spread) {
        if self.count == 0 {
            return (f64::INFINITY, Spread::default());
        }
        let spread = self.spread(film);
        let standard_error = film.error(pixel, &spread).standard_error.into();
        let estimate = Estimate { value: film.value(pixel), standard_error, count: self.count, around };
        (rule.excess(&estimate), spread)
    }
}

/// Computes the errors of all unfinished pixels, and removes the finished pixels from the list.
fn judge(film: &Film, parts: &mut [Part], rule: &StopRule) {
    let mut tiles = film.lock();
    let judge = |index: usize| -> Vec<(f64, Spread)> {
        let pixels = parts[index].active().iter().map(|active| {
            let around = around(&tiles, parts, (index, active.at));
            let seen = around.fold(Seen::NOTHING, |all, (seen, _)| all.union(seen));
            active.judge(film, &tiles[index].pixel(active.at), seen, rule)
        });
        pixels.collect()
    };
    let judged: Vec<_> = (0..parts.len()).into_par_iter().map(judge).collect();
    for ((part, tile), judged) in parts.iter_mut().zip(&mut tiles).zip(judged) {
        let Some(all_active) = &mut part.active else { continue };
        for (active, (excess, spread)) in all_active.iter_mut().zip(judged) {
            active.excess = excess;
            tile.spread_mut(active.at).into_iter().for_each(|known| *known = spread);
        }
        all_active.retain(|active| active.excess > 1.0 || active.excess.is_nan());
        all_active.shrink_to_fit();
    }
}

/// True if a sample of a pixel was much brighter than the pixels around.
fn is_outlier(
    film: &Film,
    tiles: &[impl Deref<Target = Tile>],
    parts: &[Part],
    (index, at): (usize, usize),
) -> bool {
    let bright = |rgb: Vec3| if rgb.is_finite() { luminance(rgb) } else { 0.0 };
    let brightest = around(tiles, parts, (index, at)).map(|(_, pixel)| bright(film.value(&pixel).as_vec3()));
    bright(parts[index].seen[at].most) > OUTLIER * brightest.fold(0.0, f64::max)
}

/// A pixel of a tile, and its up to eight neighbors.
fn around(
    tiles: &[impl Deref<Target = Tile>],
    parts: &[Part],
    (index, at): (usize, usize),
) -> impl Iterator<Item = (Seen, Pixel)> {
    let bounds = tiles[index].bounds;
    let (first, last) = (tiles[0].bounds, tiles[tiles.len() - 1].bounds);
    let (x, y) = (bounds.x0 + at as u32 % bounds.width(), bounds.y0 + at as u32 / bounds.width());
    let side = tile_side(PixelBounds { x1: last.x1, y1: last.y1, ..first });
    let across = (last.x0 - first.x0) / side + 1;
    let columns = x.saturating_sub(1).max(first.x0)..=(x + 1).min(last.x1 - 1);
    let rows = y.saturating_sub(1).max(first.y0)..=(y + 1).min(last.y1 - 1);
    rows.flat_map(move |y| columns.clone().map(move |x| (x, y))).map(move |(x, y)| {
        let (column, row) = (x - first.x0, y - first.y0);
        let index = (row / side * across + column / side) as usize;
        let at = (row % side * tiles[index].bounds.width() + column % side) as usize;
        (parts[index].seen[at], tiles[index].pixel(at))
    })
}

#[cfg(test)]
mod tests {
    use lookat_scene::Filter;

    use super::*;
    use crate::film::{Scale, places};
    use crate::filter::FilterSampler;
    use crate::testing::scene;

    /// `around` finds all neighbors of each pixel, also in other tiles.
    #[test]
    fn neighbors_are_found_across_tiles() {
        let mut of =
            scene("Film \"image\" Camera \"perspective\" WorldBegin Shape \"sphere\" WorldEnd").view.film;
        for (width, height) in [(35, 18), (3, 90), (2, 2)] {
            of.crop = PixelBounds { x0: 5, y0: 7, x1: 5 + width, y1: 7 + height };
            let film = Film::new(&of, &FilterSampler::new(&Filter::BOX), Scale::new(1.0), false);
            let tiles = film.lock();
            let number = |[x, y]: [u32; 2]| Vec3::new(x as f32, y as f32, 0.0);
            let part = |tile: &Tile| {
                let seen = places(tile.bounds).map(|at| Seen { least: number(at), most: number(at) });
                Part { seen: seen.collect(), active: None }
            };
            let parts: Vec<Part> = tiles.iter().map(|tile| part(tile)).collect();
            for (index, tile) in tiles.iter().enumerate() {
                for (at, [x, y]) in places(tile.bounds).enumerate() {
                    let found = around(&tiles, &parts, (index, at)).map(|(seen, _)| seen.least);
                    let all = places(of.crop).filter(|[a, b]| a.abs_diff(x) <= 1 && b.abs_diff(y) <= 1);
                    assert_eq!(found.collect::<Vec<_>>(), all.map(number).collect::<Vec<Vec3>>());
                }
            }
        }
    }
}
