//! The loop over samples: rounds over all tiles, each of as many samples as a policy asks for; the policy that gives each pixel the
//! same number; and an estimate of the remaining time.

use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use lookat_scene::Sampler;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::control::{Control, Meter};
use super::sample::{Context, Job, Pattern, Worker};
use super::{Progress, Settings};
use crate::film::{Film, REPLICATES, Tile, lock};
use crate::sampler::{of_single_pixels, replicate_seed};

/// Decides where the next samples go, and when there are enough.
pub(super) trait Policy: Sync {
    /// The state of a tile that is kept beside the film.
    type State: Send;

    /// The state of a tile without samples.
    fn begin(&self, tile: &Tile) -> Self::State;

    /// Plans the next round from the film so far. False if the rendering is finished.
    fn next(&mut self, film: &Film, states: &mut [Self::State], control: &Control) -> bool;

    /// The samples of a tile in this round.
    fn jobs(&self, tile: &Tile, state: &Self::State) -> Vec<Job>;

    /// Looks at the samples of a tile. Jobs may lack some if the rendering has been stopped.
    fn note(&self, _jobs: &[Job], _tile: &Tile, _state: &mut Self::State) {}

    /// Merges the pass of the film after a round. `is_whole`: no samples are missing.
    fn end(&mut self, _film: &Film, _states: &mut [Self::State], _is_whole: bool) {}
}

/// Renders round after round, and returns what the policy has kept of each tile.
pub(super) fn render<P: Policy>(context: &Context, policy: &mut P) -> Vec<P::State> {
    let Context { film, control, .. } = context;
    let mut states: Vec<P::State> = film.tiles.iter().map(|tile| policy.begin(&lock(tile))).collect();
    while policy.next(film, &mut states, control) && !control.is_stopped() {
        let whole_tiles = AtomicUsize::new(0);
        let of_round = &*policy;
        film.tiles.par_iter().zip(&mut states).for_each_init(
            || Worker::new(context),
            |worker, (tile, state)| {
                if control.is_stopped() {
                    return;
                }
                let mut meter = Meter::new(control);
                worker.tracer.rays = 0;
                worker.tracer.profiler = control.profiler();
                let (sources, mut jobs) = {
                    let tile = lock(tile);
                    (tile.sources, of_round.jobs(&tile, state))
                };
                worker.block.get_or_insert_default().restart(film, sources);
                // Not locked meanwhile: another thread may take a snapshot.
                context.sample_all(worker, &mut meter, &mut jobs);
                // The meter may call back.
                drop(meter);
                if let Some(block) = &mut worker.block {
                    film.add(block);
                }
                of_round.note(&jobs, &lock(tile), state);
                let is_whole = jobs.iter().all(Job::is_whole);
                whole_tiles.fetch_add(usize::from(is_whole), Ordering::Relaxed);
                let mut state = control.state();
                state.statistics.rays += worker.tracer.rays;
                for Job { samples, .. } in &jobs {
                    state.statistics.rejected += samples.rejected;
                    state.statistics.clamped += samples.clamped;
                }
                drop(state);
                control.keep(&mut worker.tracer);
            },
        );
        policy.end(film, &mut states, whole_tiles.into_inner() == film.tiles.len());
    }
    states
}

/// Estimates the remaining time of a rendering.
#[derive(Debug, Clone, Default)]
pub struct TimeLeft {
    /// Seconds since the first call, and the samples done by then. Each time is at least 2 % more than the previous
    /// one.
    history: Vec<(f64, u64)>,
    started: Option<(Instant, u64)>,
}

/// The factor by which the time per sample may rise or fall, because other pixels are sampled and the machine has other
/// work.
const SLACK: f64 = 1.4;

/// Seconds until the rate of samples is reliable.
const SETTLED: f64 = 0.5;

impl TimeLeft {
    /// The least and the most remaining time, in seconds. `None` while it is unknown. Call this function regularly.
    ///
    /// The bounds cover two rates of samples: the rate since the start, and the rate in the second half of the elapsed
    /// time.
    pub fn update(&mut self, progress: &Progress) -> Option<[f64; 2]> {
        let (started, before) = *self.started.get_or_insert((Instant::now(), progress.done));
        let (time, done) = (started.elapsed().as_secs_f64(), progress.done.saturating_sub(before));
        self.at(time, done, progress.left?)
    }

    fn at(&mut self, time: f64, done: u64, [least, most]: [u64; 2]) -> Option<[f64; 2]> {
        if self.history.last().is_none_or(|(last, _)| time > 1.02 * last) {
            self.history.push((time, done));
        }
        if time < SETTLED {
            return None;
        }
        let half = self.history.iter().rev().find(|(then, _)| *then <= 0.5 * time);
        let rate = |(from, before): (f64, u64)| (time - from) / done.saturating_sub(before) as f64;
        let all = rate((0.0, 0));
        let recent = half.map_or(all, |then| rate(*then));
        let [fast, slow] = [all.min(recent) / SLACK, all.max(recent) * SLACK];
        let left = [least as f64 * fast, most as f64 * slow];
        left.iter().all(|seconds| seconds.is_finite()).then_some(left)
    }
}

/// Samples that are taken of every pixel before the next pass begins.
pub(super) struct Pass {
    pub pattern: Pattern,
    pub samples: Range<u32>,
}

/// One of several equal parts of the samples of each pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// From 0 to one less than `of`.
    pub index: u32,
    /// The number of parts: at least 1.
    pub of: u32,
}

impl Part {
    /// The indices of its samples, of so many. Parts differ by one sample at most; with more parts than samples, some are empty.
    pub fn range(self, samples: u32) -> Range<u32> {
        let start = |index: u32| {
            (u64::from(index.min(self.of)) * u64::from(samples) / u64::from(self.of.max(1))) as u32
        };
        start(self.index)..start(self.index.saturating_add(1))
    }
}

/// Passes of 1, 1, 2, 4, ... samples per pixel over the whole picture, so that breaking off leaves a whole picture. With
/// error layers each pass is a replicate.
pub(super) struct Fixed {
    passes: std::vec::IntoIter<Pass>,
    pass: Option<Pass>,
    /// The index of the first sample.
    first: u32,
    pub samples_per_pixel: u32,
    has_spreads: bool,
}

impl Fixed {
    pub fn new(sampler: Sampler, settings: &Settings) -> Fixed {
        let has_spreads = settings.stop.has_error_layers();
        let (mut passes, mut first) = (all(sampler, settings), 0);
        if let Some(part) = settings.part.filter(|_| !has_spreads) {
            let own = part.range(sampler.samples_per_pixel);
            first = own.start;
            for Pass { samples, .. } in &mut passes {
                *samples = samples.start.max(own.start)..samples.end.min(own.end);
            }
            passes.retain(|pass| !pass.samples.is_empty());
        }
        let samples_per_pixel = passes.iter().map(|pass| pass.samples.len() as u32).sum();
        Fixed { passes: passes.into_iter(), pass: None, first, samples_per_pixel, has_spreads }
    }
}

/// All passes of a picture.
pub(super) fn all(sampler: Sampler, settings: &Settings) -> Vec<Pass> {
    let Settings { seed, stop, is_extendable, .. } = *settings;
    if stop.has_error_layers() { replicates(sampler, seed) } else { passes(sampler, seed, is_extendable) }
}

fn replicates(sampler: Sampler, seed: u64) -> Vec<Pass> {
    let samples = sampler.samples_per_pixel;
    let count = samples.min(REPLICATES);
    let replicate = |i: u32| {
        // Patterns without jitter are all the same, and show no error.
        let sampler = sampler.jittered().with_samples(samples / count + u32::from(i < samples % count));
        let pattern = Pattern { sampler, seed: replicate_seed(seed, i), is_watched: false };
        Pass { pattern, samples: 0..sampler.samples_per_pixel }
    };
    (0..count).map(replicate).collect()
}

fn passes(sampler: Sampler, seed: u64, is_extendable: bool) -> Vec<Pass> {
    let mut from = 0;
    // Pixels that share a sequence need to know how many samples each takes of it.
    let of_pattern = if is_extendable { of_single_pixels(sampler) } else { sampler };
    let pass = |to| {
        let samples = from..to;
        from = to;
        Pass { pattern: Pattern { sampler: of_pattern, seed, is_watched: false }, samples }
    };
    doubled(1, sampler.samples_per_pixel).map(pass).collect()
}

/// `from`, twice as many, and so on, to `to`; nothing if that is less.
pub(super) fn doubled(from: u32, to: u32) -> impl Iterator<Item = u32> {
    let ends = std::iter::successors(Some(from), |end| end.checked_mul(2));
    ends.take_while(move |end| *end < to).chain((from <= to).then_some(to))
}

impl Policy for Fixed {
    type State = ();

    fn begin(&self, _tile: &Tile) {}

    fn next(&mut self, film: &Film, _states: &mut [()], control: &Control) -> bool {
        if self.pass.is_none() {
            control.expect(film.sources().size() as u64 * u64::from(self.samples_per_pixel));
            // What an earlier rendering has left.
            let counts =
                |tile: &Mutex<Tile>| lock(tile).counts.iter().map(|count| u64::from(*count)).sum::<u64>();
            control.state().done = film.tiles.iter().map(counts).sum();
        }
        self.pass = self.passes.next();
        self.pass.is_some()
    }

    fn jobs(&self, tile: &Tile, _state: &()) -> Vec<Job> {
        let Some(pass) = &self.pass else { return Vec::new() };
        let Range { start, end } = pass.samples;
        let mut jobs = Vec::with_capacity(tile.sources.size());
        jobs.extend(tile.sources.pixels().zip(&tile.counts).filter_map(|(pixel, count)| {
            // Replicates count from 0, and none is taken up.
            let done = if self.has_spreads { 0 } else { self.first + count };
            (done < end).then(|| Job::new(pass.pattern, pixel, start.max(done)..end))
        }));
        jobs
    }

    fn end(&mut self, film: &Film, _states: &mut [()], is_whole: bool) {
        let Some(pass) = self.pass.as_ref().filter(|_| self.has_spreads) else { return };
        let samples = pass.samples.len() as u32;
        film.tiles.par_iter().for_each(|tile| {
            let Tile { sums, pass, spreads, .. } = &mut *lock(tile);
            for ((sum, pass), spread) in sums.iter_mut().zip(pass).zip(spreads) {
                // Half a replicate is none.
                if is_whole {
                    spread.add(pass.weighted(film.scale()), samples);
                }
                *sum += std::mem::take(pass);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_work_is_estimated_within_the_slack() {
        let mut left = TimeLeft::default();
        for step in 1..=100 {
            let [least, most] =
                left.at(f64::from(step), 1000 * step as u64, [1000 * (100 - step as u64); 2]).unwrap();
            let truth = f64::from(100 - step);
            assert!((least - truth / SLACK).abs() < 1e-9 && (most - truth * SLACK).abs() < 1e-9);
        }
    }

    /// Slower samples raise the upper bound, and later also the lower bound.
    #[test]
    fn slower_samples_are_noticed() {
        let mut left = TimeLeft::default();
        (1..=10_u64).for_each(|second| {
            left.at(second as f64, 1000 * second, [9000; 2]);
        });
        let [mut least, mut most] = [0.0; 2];
        for second in 11..=40_u64 {
            [least, most] = left.at(second as f64, 10_000 + 100 * (second - 10), [1000; 2]).unwrap();
        }
        assert!(most >= 10.0 && least > 1.0, "{least} {most}");
        assert_eq!(TimeLeft::default().at(1.0, 0, [10; 2]), None);
    }
}
