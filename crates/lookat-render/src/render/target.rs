//! Renders with a target error: samples all unfinished pixels in rounds, until each pixel reaches the target.
//!
//! Each pixel has 16 replicates. Each replicate is an Owen-scrambled Sobol' pattern of its own, whose number of samples
//! doubles in each round. Each pixel is judged after a whole round, by its own samples and by the samples of its
//! neighbors. The picture therefore does not depend on threads or on the order of tiles.
//!
//! Samples count for all pixels that the filter reaches. A source takes samples while any of these is unfinished; a finished pixel
//! takes no more of them. So all sources of an unfinished pixel have equal counts.

use std::sync::Mutex;

use glam::{Vec3, Vec4};
use lookat_scene::Sampler;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::control::Control;
use super::rounds::Policy;
use super::sample::{Context, Job, Pattern, SampleBounds};
use super::settings::Stop;
use super::stop_rule::{Brightness, Estimate, StopRule};
use super::{Reached, TargetError};
use crate::film::{Area, Film, REPLICATES, Spread, Tile, lock};
use crate::number::luminance;
use crate::sampler::{of_single_pixels, replicate_seed};

/// Samples per pixel in the first round.
const FIRST: u32 = Stop::FIRST_OF_TARGET;

/// Bytes of a pixel beside the film, about, until it is done.
pub(super) const PIXEL_BYTES: usize = 340;

/// The fastest and the slowest convergence: the error of a pixel falls with this power of its samples. Independent
/// samples have 1/2, and Sobol' patterns more. The slowest power is below 1/2, because few samples often underestimate
/// the error.
const POWERS: [f64; 2] = [0.75, 0.45];

/// The state of the pixels of a tile.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct TileState {
    /// The bounds of the samples of each source.
    sample_bounds: Vec<SampleBounds>,
    /// The sources that take samples: numbers in the tile.
    sources: Vec<u32>,
    /// The unfinished pixels.
    active: Vec<Active>,
}

/// The replicates of an unfinished pixel.
#[derive(Debug, Serialize, Deserialize)]
struct Active {
    /// The index of the pixel in its tile.
    at: u32,
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
    round: Round,
}

/// A round: each replicate takes samples, one after the other.
#[derive(Serialize, Deserialize)]
pub(super) struct Round {
    /// The replicate that takes samples, and how many it has before and after that.
    replicate: u32,
    before: u32,
    count: u32,
    /// The brightness of the picture after the first round.
    brightness: f64,
}

impl Target {
    pub fn new(sampler: Sampler, seed: u64, target: &TargetError) -> Target {
        let most = sampler.samples_per_pixel / REPLICATES;
        Target {
            seed,
            sampler: of_single_pixels(sampler),
            most,
            rule: StopRule::new(target),
            // Before the first round.
            round: Round { replicate: REPLICATES - 1, before: 0, count: 0, brightness: 0.0 },
        }
    }

    /// The sample pattern of the replicate that takes samples.
    fn pattern(&self) -> Pattern {
        let seed = replicate_seed(self.seed, self.round.replicate);
        Pattern { sampler: self.sampler, seed, is_watched: true }
    }

    /// The samples left, at the fastest and at the slowest convergence.
    fn left(&self, states: &[Mutex<TileState>]) -> [u64; 2] {
        POWERS.map(|power| {
            let of_part = |state: &Mutex<TileState>| {
                let state = lock(state);
                let excess = state.active.iter().map(|active| active.excess).fold(0.0, f64::max);
                let all = f64::from(self.round.before) * libm::pow(excess, power.recip());
                let most = f64::from(self.most);
                let all =
                    if all < most { (all as u32).next_power_of_two().min(self.most) } else { self.most };
                let more = all.max(2 * self.round.before).min(self.most) - self.round.before;
                u64::from(more) * u64::from(REPLICATES) * state.sources.len() as u64
            };
            states.iter().map(of_part).sum()
        })
    }
}

impl Policy for Target {
    type State = TileState;
    type Plan = Round;

    fn begin(&self, tile: &Tile) -> TileState {
        let active = |at| Active { at, replicates: Default::default(), excess: f64::INFINITY };
        TileState {
            sample_bounds: vec![SampleBounds::EMPTY; tile.sources.size()],
            sources: (0..tile.sources.size() as u32).collect(),
            active: (0..tile.bounds.size() as u32).map(active).collect(),
        }
    }

    fn next(&mut self, film: &Film, states: &[Mutex<TileState>]) -> bool {
        if self.round.replicate + 1 < REPLICATES {
            self.round.replicate += 1;
            return true;
        }
        if self.round.count > 0 {
            if self.round.before == 0 {
                let mut brightness = Brightness::default();
                for value in film.values() {
                    brightness.add(value);
                }
                self.round.brightness = brightness.get();
                self.rule = self.rule.with_brightness(self.round.brightness);
            }
            settle(film, states);
            judge(film, states, &self.rule, self.round.count);
            let is_done = states.iter().all(|state| lock(state).active.is_empty());
            if is_done || self.round.count >= self.most {
                return false;
            }
        }
        self.round.replicate = 0;
        self.round.before = self.round.count;
        // Sobol' patterns are best at powers of two.
        self.round.count = (2 * self.round.count).clamp(FIRST / REPLICATES, self.most);
        true
    }

    fn expect(&self, film: &Film, states: &[Mutex<TileState>], control: &Control) {
        let Round { replicate, before, count, .. } = self.round;
        if before == 0 {
            control.expect(film.sources().size() as u64 * u64::from(FIRST));
            control.state().bounds = None;
            return;
        }
        let active = states.iter().map(|state| lock(state).active.len() as u64).sum::<u64>();
        let sources = states.iter().map(|state| lock(state).sources.len() as u64).sum::<u64>();
        // Before the round.
        let done = control.state().done.saturating_sub(sources * u64::from(replicate * (count - before)));
        let totals = self.left(states).map(|left| done + left);
        control.expect(totals[0]);
        let mut state = control.state();
        (state.bounds, state.pixels_done) = (Some(totals), film.settings.crop.area() - active);
    }

    fn jobs(&self, tile: &Tile, state: &TileState) -> Vec<Job> {
        let Round { replicate, before, count, .. } = self.round;
        let so_far = REPLICATES * before + replicate * (count - before);
        let job = |source: &u32| {
            let at = *source as usize;
            // None if it has them already.
            let first = if tile.counts[at] > so_far { count } else { before };
            Job::new(self.pattern(), tile.sources.pixel(at), first..count)
        };
        state.sources.iter().map(job).collect()
    }

    fn note(&self, jobs: &[Job], state: &mut TileState) {
        for (source, job) in state.sources.iter().zip(jobs) {
            let seen = &mut state.sample_bounds[*source as usize];
            *seen = seen.union(job.samples.sample_bounds);
        }
    }

    fn end(&mut self, film: &Film, states: &[Mutex<TileState>], is_whole: bool) {
        // Before there is a picture, a part of it is better than none.
        let is_merged = is_whole || (self.round.before, self.round.replicate) == (0, 0);
        film.tiles.par_iter().zip(states).for_each(|(tile, state)| {
            let Tile { sums, pass, unfiltered, .. } = &mut *lock(tile);
            for active in lock(state).active.iter_mut().filter(|_| is_merged) {
                let at = active.at as usize;
                sums[at] += pass.filtered[at];
                if is_whole {
                    let more = pass.filtered[at].weighted(film.scale()).as_vec4();
                    active.replicates[self.round.replicate as usize] += more;
                }
            }
            let sampled = unfiltered.iter_mut().zip(&pass.unfiltered);
            sampled.for_each(|(spread, sum)| spread.add_sum(sum, film.scale()));
            pass.clear();
        });
    }

    fn plan(&self) -> &Round {
        &self.round
    }

    fn resume(&mut self, plan: Round, film: &Film, states: &[Mutex<TileState>], is_begun: bool) -> bool {
        self.round = plan;
        let Round { replicate, before, count, brightness } = self.round;
        self.rule = self.rule.with_brightness(brightness);
        let is_sound = |(state, tile): (&Mutex<TileState>, &Mutex<Tile>)| {
            let (state, tile) = (lock(state), lock(tile));
            let [sources, pixels] = [tile.sources, tile.bounds].map(|area| area.size() as u32);
            state.sample_bounds.len() == sources as usize
                && state.sources.iter().all(|source| *source < sources)
                && state.active.iter().all(|active| active.at < pixels)
        };
        replicate < REPLICATES
            && before <= count
            && count <= self.most
            && (count > 0 || !is_begun)
            && states.iter().zip(&film.tiles).all(is_sound)
    }
}

/// Counts the pixels by whether they reached the target error.
pub(super) fn reached(context: &Context, states: &[Mutex<TileState>]) -> Reached {
    let film = context.film;
    settle(film, states);
    let active = states.iter().map(|state| lock(state).active.len() as u64).sum::<u64>();
    let is_at_cap = context.control.state().is_finished;
    let (at_cap, out_of_time) = if is_at_cap { (active, 0) } else { (0, active) };
    let outliers = count_outliers(film, states);
    Reached { within: film.settings.crop.area() - active, at_cap, out_of_time, outliers }
}

/// Tells the film how far the replicates of the unfinished pixels lie apart.
fn settle(film: &Film, states: &[Mutex<TileState>]) {
    film.tiles.par_iter().zip(states).for_each(|(tile, state)| {
        let tile = &mut *lock(tile);
        for active in &lock(state).active {
            let mut spread = Spread::default();
            let sampled = active.replicates.iter().filter(|replicate| **replicate != Vec4::ZERO);
            sampled.for_each(|replicate| spread.add(replicate.as_dvec4()));
            spread.samples = tile.count(active.at as usize);
            tile.spreads[active.at as usize] = spread;
        }
    });
}

/// A sample is an outlier if it is this many times as bright as the brightest pixel around it.
const OUTLIER: f64 = 20.0;

/// Judges all unfinished pixels, which have `count` samples in each replicate, removes those that are done, and the sources that no
/// unfinished pixel asks for.
fn judge(film: &Film, states: &[Mutex<TileState>], rule: &StopRule, count: u32) {
    let (reach, sources) = (film.filter.reach(), film.sources());
    let seen = around(&all_sample_bounds(film, states), sources, reach.map(|reach| reach + 1));
    film.tiles.par_iter().zip(states).for_each(|(tile, state)| {
        let (tile, state) = (lock(tile), &mut *lock(state));
        for active in &mut state.active {
            let at = active.at as usize;
            let standard_error = tile.spreads[at].standard_error();
            let value = tile.sums[at].mean(film.scale());
            let around = seen[sources.index(tile.bounds.pixel(at))];
            active.excess = rule.excess(&Estimate { value, standard_error, count, around });
        }
        state.active.retain(|active| active.excess > 1.0 || active.excess.is_nan());
        state.active.shrink_to_fit();
    });
    let mut is_asked = vec![SampleBounds::EMPTY; sources.size()];
    for (tile, state) in film.tiles.iter().zip(states) {
        let bounds = lock(tile).bounds;
        for active in &lock(state).active {
            is_asked[sources.index(bounds.pixel(active.at as usize))] =
                SampleBounds { least: Vec3::ZERO, most: Vec3::ZERO };
        }
    }
    let is_asked = around(&is_asked, sources, reach);
    film.tiles.par_iter().zip(states).for_each(|(tile, state)| {
        let own = lock(tile).sources;
        let is_asked = |at: &u32| is_asked[sources.index(own.pixel(*at as usize))] != SampleBounds::EMPTY;
        lock(state).sources.retain(is_asked);
    });
}

/// The bounds of the samples of all sources, row by row.
fn all_sample_bounds(film: &Film, states: &[Mutex<TileState>]) -> Vec<SampleBounds> {
    let mut all = vec![SampleBounds::EMPTY; film.sources().size()];
    for (tile, state) in film.tiles.iter().zip(states) {
        let own = lock(tile).sources;
        own.pixels()
            .zip(&lock(state).sample_bounds)
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
fn count_outliers(film: &Film, states: &[Mutex<TileState>]) -> u64 {
    let (crop, sources, sample_bounds) = (film.crop(), film.sources(), all_sample_bounds(film, states));
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
