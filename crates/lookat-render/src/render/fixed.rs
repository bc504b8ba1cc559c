//! The same number of samples for every pixel.

use std::ops::Range;

use lookat_scene::Sampler;
use rayon::prelude::*;

use super::control::Control;
use super::rounds::Policy;
use super::sample::{Job, Pattern};
use crate::film::{Film, REPLICATES, Tile, lock};
use crate::sampler::replicate_seed;

/// Samples that are taken of every pixel before the next pass begins.
pub(super) struct Pass {
    pub pattern: Pattern,
    pub samples: Range<u32>,
}

/// Passes of 1, 1, 2, 4, ... samples per pixel over the whole picture, so that breaking off leaves a whole picture. With
/// error layers each pass is a replicate.
pub(super) struct Fixed {
    passes: std::vec::IntoIter<Pass>,
    pass: Option<Pass>,
    samples_per_pixel: u32,
    has_spreads: bool,
}

impl Fixed {
    pub fn new(sampler: Sampler, seed: u64, has_spreads: bool) -> Fixed {
        let passes = all(sampler, seed, has_spreads).into_iter();
        Fixed { passes, pass: None, samples_per_pixel: sampler.samples_per_pixel, has_spreads }
    }
}

/// All passes of a picture.
pub(super) fn all(sampler: Sampler, seed: u64, has_spreads: bool) -> Vec<Pass> {
    if has_spreads { replicates(sampler, seed) } else { passes(sampler, seed) }
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

fn passes(sampler: Sampler, seed: u64) -> Vec<Pass> {
    let mut from = 0;
    let pass = |to| {
        let samples = from..to;
        from = to;
        Pass { pattern: Pattern { sampler, seed, is_watched: false }, samples }
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
        }
        self.pass = self.passes.next();
        self.pass.is_some()
    }

    fn jobs(&self, tile: &Tile, _state: &()) -> Vec<Job> {
        let job = |place| self.pass.as_ref().map(|pass| Job::new(pass.pattern, place, pass.samples.clone()));
        tile.sources.places().filter_map(job).collect()
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
