//! The loop over samples: rounds over all tiles, each of as many samples as a policy asks for.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::control::{Control, Meter};
use super::sample::{Context, Job};
use super::waves::Worker;
use crate::film::{Film, Tile, lock};

/// Where the next samples go, and when there are enough of them.
pub(super) trait Policy: Sync {
    /// What it keeps of a tile beside the film.
    type State: Send;

    /// That of a tile without samples.
    fn begin(&self, tile: &Tile) -> Self::State;

    /// Decides about the next round, by the film so far. False if there is none.
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
                worker.frame.get_or_insert_default().restart(film, sources);
                // Not locked meanwhile: another thread may take a snapshot.
                context.sample_all(worker, &mut meter, &mut jobs);
                // The meter may call back.
                drop(meter);
                worker.frame.iter().for_each(|frame| film.add(frame));
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
