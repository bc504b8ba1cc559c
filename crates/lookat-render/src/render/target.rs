//! Renders with a target error: samples all unfinished pixels in rounds, until each pixel reaches the target.
//!
//! Each pixel has 16 replicates. Each replicate is an Owen-scrambled Sobol' pattern of its own, whose number of samples
//! doubles in each round. Each pixel is judged after a whole round, by its own samples and by the samples of its
//! neighbors. The picture therefore does not depend on threads or on the order of tiles.
//!
//! Samples count for all pixels that the filter reaches. A source takes samples while any of these is unfinished; a finished pixel
//! takes no more of them. So all sources of an unfinished pixel have equal counts.

use glam::{Vec3, Vec4};
use lookat_scene::Sampler;
use rayon::prelude::*;

use super::control::Control;
use super::rounds::Policy;
use super::sample::{Job, Pattern, SampleBounds};
use super::stop_rule::{Brightness, Estimate, StopRule};
use super::{Reached, TargetError};
use crate::film::{Area, Film, REPLICATES, Spread, Tile, lock};
use crate::number::luminance;
use crate::sampler::{of_single_pixels, replicate_seed};

/// Samples per pixel in the first round: 4 in each replicate.
pub(super) const FIRST: u32 = 4 * REPLICATES;

/// Bytes of a pixel beside the film, about, until it is done.
pub(super) const PIXEL_BYTES: usize = 340;

/// The fastest and the slowest convergence: the error of a pixel falls with this power of its samples. Independent
/// samples have 1/2, and Sobol' patterns more. The slowest power is below 1/2, because few samples often underestimate
/// the error.
const POWERS: [f64; 2] = [0.75, 0.45];

/// The state of the pixels of a tile.
pub(super) struct TileState {
    /// The bounds of the samples of each source.
    sample_bounds: Vec<SampleBounds>,
    /// The sources that take samples: numbers in the tile.
    sources: Vec<u32>,
    /// The unfinished pixels.
    active: Vec<Active>,
}

/// The replicates of an unfinished pixel.
struct Active {
    /// The index of the pixel in its tile.
    at: usize,
    /// The weighted sums, and in `w` the weights, as [`crate::film::Sum`]. Single precision serves, as there may be many.
    replicates: [Vec4; REPLICATES as usize],
    /// The error over the target error, after the last round.
    excess: f64,
}

/// Samples until pixels reach the target error, or a limit of samples.
pub(super) struct Target {
    seed: u64,
    /// The sampler of each replicate.
    sampler: Sampler,
    /// The most samples of a replicate.
    most: u32,
    rule: StopRule,
    /// The replicate that takes samples, and how many it has before and after that.
    replicate: u32,
    before: u32,
    count: u32,
}

impl Target {
    pub fn new(sampler: Sampler, seed: u64, target: &TargetError) -> Target {
        let most = sampler.samples_per_pixel / REPLICATES;
        Target {
            seed,
            sampler: of_single_pixels(sampler),
            most,
            rule: StopRule::new(target),
            replicate: 0,
            before: 0,
            count: 0,
        }
    }

    /// The sample pattern of the replicate that takes samples.
    fn pattern(&self) -> Pattern {
        Pattern { sampler: self.sampler, seed: replicate_seed(self.seed, self.replicate), is_watched: true }
    }

    /// Counts the pixels by whether they reached the target error.
    pub fn reached(&self, film: &Film, parts: &[TileState]) -> Reached {
        settle(film, parts);
        let active = parts.iter().map(|part| part.active.len() as u64).sum::<u64>();
        let is_at_cap = self.before >= self.most;
        let (at_cap, out_of_time) = if is_at_cap { (active, 0) } else { (0, active) };
        let outliers = count_outliers(film, parts);
        Reached { within: film.settings.crop.area() - active, at_cap, out_of_time, outliers }
    }

    /// The samples left, at the fastest and at the slowest convergence.
    fn left(&self, parts: &[TileState]) -> [u64; 2] {
        POWERS.map(|power| {
            let of_part = |part: &TileState| {
                let excess = part.active.iter().map(|active| active.excess).fold(0.0, f64::max);
                let all = f64::from(self.before) * libm::pow(excess, power.recip());
                let most = f64::from(self.most);
                let all =
                    if all < most { (all as u32).next_power_of_two().min(self.most) } else { self.most };
                let more = all.max(2 * self.before).min(self.most) - self.before;
                u64::from(more) * u64::from(REPLICATES) * part.sources.len() as u64
            };
            parts.iter().map(of_part).sum()
        })
    }
}

impl Policy for Target {
    type State = TileState;

    fn begin(&self, tile: &Tile) -> TileState {
        let active = |at| Active { at, replicates: Default::default(), excess: f64::INFINITY };
        TileState {
            sample_bounds: vec![SampleBounds::EMPTY; tile.sources.size()],
            sources: (0..tile.sources.size() as u32).collect(),
            active: (0..tile.bounds.size()).map(active).collect(),
        }
    }

    fn next(&mut self, film: &Film, parts: &mut [TileState], control: &Control) -> bool {
        if self.count == 0 {
            control.expect(film.sources().size() as u64 * u64::from(FIRST));
            control.state().bounds = None;
            self.count = FIRST / REPLICATES;
            return true;
        }
        if control.is_stopped() {
            return false;
        }
        self.replicate = (self.replicate + 1) % REPLICATES;
        if self.replicate > 0 {
            return true;
        }
        if self.before == 0 {
            let mut brightness = Brightness::default();
            for value in film.values() {
                brightness.add(value);
            }
            self.rule = self.rule.with_brightness(brightness.get());
        }
        self.before = self.count;
        settle(film, parts);
        judge(film, parts, &self.rule, self.count);
        let active = parts.iter().map(|part| part.active.len() as u64).sum::<u64>();
        control.state().pixels_done = film.settings.crop.area() - active;
        if active == 0 || self.before >= self.most {
            return false;
        }
        let done = control.state().done;
        let totals = self.left(parts).map(|left| done + left);
        control.expect(totals[0]);
        control.state().bounds = Some(totals);
        // Sobol' patterns are best at powers of two.
        self.count = (2 * self.count).min(self.most);
        true
    }

    fn jobs(&self, tile: &Tile, part: &TileState) -> Vec<Job> {
        let pixel = |source: &u32| tile.sources.pixel(*source as usize);
        let job = |source| Job::new(self.pattern(), pixel(source), self.before..self.count);
        part.sources.iter().map(job).collect()
    }

    fn note(&self, jobs: &[Job], _tile: &Tile, part: &mut TileState) {
        for (source, job) in part.sources.iter().zip(jobs) {
            let seen = &mut part.sample_bounds[*source as usize];
            *seen = seen.union(job.samples.sample_bounds);
        }
    }

    fn end(&mut self, film: &Film, parts: &mut [TileState], is_whole: bool) {
        // Before there is a picture, a part of it is better than none.
        let is_merged = is_whole || (self.before, self.replicate) == (0, 0);
        film.tiles.par_iter().zip(parts).for_each(|(tile, part)| {
            let Tile { sums, pass, .. } = &mut *lock(tile);
            for active in part.active.iter_mut().filter(|_| is_merged) {
                sums[active.at] += pass[active.at];
                if is_whole {
                    let more = pass[active.at].weighted(film.scale()).as_vec4();
                    active.replicates[self.replicate as usize] += more;
                }
            }
            pass.fill(Default::default());
        });
    }
}

/// Tells the film how far the replicates of the unfinished pixels lie apart.
fn settle(film: &Film, parts: &[TileState]) {
    film.tiles.par_iter().zip(parts).for_each(|(tile, part)| {
        let tile = &mut *lock(tile);
        for active in &part.active {
            let mut spread = Spread::default();
            let sampled = active.replicates.iter().filter(|replicate| **replicate != Vec4::ZERO);
            for replicate in sampled {
                spread.add(replicate.as_dvec4(), 0);
            }
            spread.samples = tile.count(active.at);
            tile.spreads[active.at] = spread;
        }
    });
}

/// A sample is an outlier if it is this many times as bright as the brightest pixel around it.
const OUTLIER: f64 = 20.0;

/// Judges all unfinished pixels, which have `count` samples in each replicate, removes those that are done, and the sources that no
/// unfinished pixel asks for.
fn judge(film: &Film, parts: &mut [TileState], rule: &StopRule, count: u32) {
    let (reach, sources) = (film.filter.reach(), film.sources());
    let seen = around(&all_sample_bounds(film, parts), sources, reach.map(|reach| reach + 1));
    film.tiles.par_iter().zip(&mut *parts).for_each(|(tile, part)| {
        let tile = lock(tile);
        for active in &mut part.active {
            let standard_error = film.error(&tile, active.at).standard_error.into();
            let value = tile.sums[active.at].mean(film.scale());
            let around = seen[sources.index(tile.bounds.pixel(active.at))];
            active.excess = rule.excess(&Estimate { value, standard_error, count, around });
        }
        part.active.retain(|active| active.excess > 1.0 || active.excess.is_nan());
        part.active.shrink_to_fit();
    });
    let mut is_asked = vec![SampleBounds::EMPTY; sources.size()];
    for (tile, part) in film.tiles.iter().zip(&*parts) {
        let bounds = lock(tile).bounds;
        for active in &part.active {
            is_asked[sources.index(bounds.pixel(active.at))] =
                SampleBounds { least: Vec3::ZERO, most: Vec3::ZERO };
        }
    }
    let is_asked = around(&is_asked, sources, reach);
    film.tiles.par_iter().zip(parts).for_each(|(tile, part)| {
        let own = lock(tile).sources;
        let is_asked = |at: &u32| is_asked[sources.index(own.pixel(*at as usize))] != SampleBounds::EMPTY;
        part.sources.retain(is_asked);
    });
}

/// The bounds of the samples of all sources, row by row.
fn all_sample_bounds(film: &Film, parts: &[TileState]) -> Vec<SampleBounds> {
    let mut all = vec![SampleBounds::EMPTY; film.sources().size()];
    for (tile, part) in film.tiles.iter().zip(parts) {
        let own = lock(tile).sources;
        own.pixels()
            .zip(&part.sample_bounds)
            .for_each(|(pixel, sample_bounds)| all[film.sources().index(pixel)] = *sample_bounds);
    }
    all
}

/// For each pixel of an area the bounds of those up to so many pixels away, across and down.
fn around(sample_bounds: &[SampleBounds], area: Area, [across, down]: [u32; 2]) -> Vec<SampleBounds> {
    let union = |from: &[SampleBounds], at: usize, (own, end, step): (usize, usize, usize), reach: u32| {
        let reach = reach as usize;
        let near = own.saturating_sub(reach)..=(own + reach).min(end - 1);
        near.map(|other| from[at + other * step - own * step]).fold(SampleBounds::EMPTY, SampleBounds::union)
    };
    let (width, height) = (area.width(), area.height());
    let all = 0..sample_bounds.len();
    let rows: Vec<SampleBounds> = all
        .clone()
        .into_par_iter()
        .map(|at| union(sample_bounds, at, (at % width, width, 1), across))
        .collect();
    all.into_par_iter().map(|at| union(&rows, at, (at / width, height, width), down)).collect()
}

/// Counts the pixels that had a sample much brighter than the pixels around.
fn count_outliers(film: &Film, parts: &[TileState]) -> u64 {
    let (crop, sources, sample_bounds) = (film.crop(), film.sources(), all_sample_bounds(film, parts));
    let bright = |rgb: Vec3| if rgb.is_finite() { luminance(rgb) } else { 0.0 };
    let mut pixels = vec![SampleBounds::EMPTY; crop.size()];
    for tile in &film.tiles {
        let tile = lock(tile);
        for (pixel, sum) in tile.bounds.pixels().zip(&tile.sums) {
            let value = Vec3::splat(bright(sum.mean(film.scale()).as_vec3()) as f32);
            pixels[crop.index(pixel)] = SampleBounds { least: value, most: value };
        }
    }
    let around = around(&pixels, crop, [1, 1]);
    let is_outlier = |(pixel, around): &([i32; 2], &SampleBounds)| {
        bright(sample_bounds[sources.index(*pixel)].most) > OUTLIER * f64::from(around.most.x.max(0.0))
    };
    crop.pixels().zip(&around).filter(is_outlier).count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbors_are_found() {
        for (width, height, reach) in [(35, 18, [1, 1]), (3, 9, [2, 5]), (2, 2, [0, 3])] {
            let area = Area { x0: -5, y0: 7, x1: width - 5, y1: 7 + height };
            let number = |[x, y]: [i32; 2]| Vec3::new(x as f32, y as f32, 0.0);
            let sample_bounds: Vec<SampleBounds> =
                area.pixels().map(|at| SampleBounds { least: number(at), most: number(at) }).collect();
            for (found, [x, y]) in around(&sample_bounds, area, reach).iter().zip(area.pixels()) {
                let is_near = |[a, b]: &[i32; 2]| a.abs_diff(x) <= reach[0] && b.abs_diff(y) <= reach[1];
                let all = area.pixels().filter(is_near).map(|at| sample_bounds[area.index(at)]);
                assert_eq!(*found, all.fold(SampleBounds::EMPTY, SampleBounds::union));
            }
        }
    }
}
