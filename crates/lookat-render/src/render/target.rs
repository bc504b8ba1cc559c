//! Renders with a target error: samples all unfinished pixels in rounds, until each pixel reaches the target.
//!
//! Each pixel has 16 replicates. Each replicate is an Owen-scrambled Sobol' pattern of its own, whose number of samples
//! doubles in each round. Each pixel is judged after a whole round, by its own samples and by the samples of its
//! neighbors. The picture therefore does not depend on threads or on the order of tiles.
//!
//! Samples count for all pixels that the filter reaches. A source takes samples while any of these is unfinished; a finished pixel
//! takes no more of them. So all sources of an unfinished pixel have equal counts.

mod judge;

use glam::Vec4;
use lookat_scene::Sampler;
use rayon::prelude::*;

use super::control::Control;
use super::rounds::Policy;
use super::sample::{Job, Pattern, Seen};
use super::stop::{Brightness, StopRule};
use super::{Reached, TargetError};
use crate::film::{Film, REPLICATES, Spread, Tile, lock};
use crate::sampler::{of_single_pixels, replicate_seed};
use judge::{count_outliers, judge};

/// Samples per pixel in the first round: 4 in each replicate.
pub(super) const FIRST: u32 = 4 * REPLICATES;

/// Bytes of a pixel beside the film, about, until it is done.
pub(super) const PIXEL_BYTES: usize = 340;

/// The fastest and the slowest convergence: the error of a pixel falls with this power of its samples. Independent
/// samples have 1/2, and Sobol' patterns more. The slowest power is below 1/2, because few samples often underestimate
/// the error.
const POWERS: [f64; 2] = [0.75, 0.45];

/// What is known of a tile.
pub(super) struct Part {
    /// The bounds of the samples of each source.
    seen: Vec<Seen>,
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
    /// That of each replicate.
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
    pub fn reached(&self, film: &Film, parts: &[Part]) -> Reached {
        settle(film, parts);
        let active = parts.iter().map(|part| part.active.len() as u64).sum::<u64>();
        let is_at_cap = self.before >= self.most;
        let (at_cap, out_of_time) = if is_at_cap { (active, 0) } else { (0, active) };
        let outliers = count_outliers(film, parts);
        Reached { within: film.of.crop.area() - active, at_cap, out_of_time, outliers }
    }

    /// The samples left, at the fastest and at the slowest convergence.
    fn left(&self, parts: &[Part]) -> [u64; 2] {
        POWERS.map(|power| {
            let of_part = |part: &Part| {
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
    type State = Part;

    fn begin(&self, tile: &Tile) -> Part {
        let active = |at| Active { at, replicates: Default::default(), excess: f64::INFINITY };
        Part {
            seen: vec![Seen::NOTHING; tile.sources.size()],
            sources: (0..tile.sources.size() as u32).collect(),
            active: (0..tile.bounds.size()).map(active).collect(),
        }
    }

    fn next(&mut self, film: &Film, parts: &mut [Part], control: &Control) -> bool {
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
            film.values().for_each(|value| brightness.add(value));
            self.rule = self.rule.with_brightness(brightness.get());
        }
        self.before = self.count;
        settle(film, parts);
        judge(film, parts, &self.rule, self.count);
        let active = parts.iter().map(|part| part.active.len() as u64).sum::<u64>();
        control.state().pixels_done = film.of.crop.area() - active;
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

    fn jobs(&self, tile: &Tile, part: &Part) -> Vec<Job> {
        let place = |source: &u32| tile.sources.place(*source as usize);
        let job = |source| Job::new(self.pattern(), place(source), self.before..self.count);
        part.sources.iter().map(job).collect()
    }

    fn note(&self, jobs: &[Job], _tile: &Tile, part: &mut Part) {
        for (source, job) in part.sources.iter().zip(jobs) {
            let seen = &mut part.seen[*source as usize];
            *seen = seen.union(job.samples.seen);
        }
    }

    fn end(&mut self, film: &Film, parts: &mut [Part], is_whole: bool) {
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
fn settle(film: &Film, parts: &[Part]) {
    film.tiles.par_iter().zip(parts).for_each(|(tile, part)| {
        let tile = &mut *lock(tile);
        for active in &part.active {
            let mut spread = Spread::default();
            let sampled = active.replicates.iter().filter(|replicate| **replicate != Vec4::ZERO);
            sampled.for_each(|replicate| spread.add(replicate.as_dvec4(), 0));
            spread.samples = tile.count(active.at);
            tile.spreads[active.at] = spread;
        }
    });
}
