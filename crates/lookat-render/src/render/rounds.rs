//! The loop over samples: rounds over all tiles, each of as many samples as a policy asks for.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;
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

    /// True if the tiles of this round come in random order.
    fn is_shuffled(&self) -> bool {
        false
    }

    /// The samples of a tile in this round.
    fn jobs(&self, tile: &Tile, state: &mut Self::State) -> Vec<Job>;

    /// Adds what has become of them to the film. Jobs may lack samples if the rendering has been stopped.
    fn add(&self, jobs: &[Job], film: &Film, tile: &mut Tile, state: &mut Self::State);

    /// Looks at a tile after its round.
    fn finish(&self, _film: &Film, _tile: &Tile, _state: &Self::State, _control: &Control) {}
}

/// Renders round after round, and returns what the policy has kept of each tile.
pub(super) fn render<P: Policy>(context: &Context, seed: u64, policy: &mut P) -> Vec<P::State> {
    let Context { film, control, .. } = context;
    let mut states: Vec<P::State> = film.tiles.iter().map(|tile| policy.begin(&lock(tile))).collect();
    while policy.next(film, &mut states, control) && !control.is_stopped() {
        let mut tiles: Vec<_> = film.tiles.iter().zip(&mut states).collect();
        if policy.is_shuffled() {
            tiles.shuffle(&mut Pcg64Mcg::seed_from_u64(seed));
        }
        let policy = &*policy;
        tiles.into_par_iter().for_each_init(
            || Worker::new(context),
            |worker, (tile, state)| {
                if control.is_stopped() {
                    return;
                }
                let mut meter = Meter::new(control);
                worker.tracer.rays = 0;
                worker.tracer.profiler = control.profiler();
                let mut jobs = policy.jobs(&lock(tile), state);
                // Not locked meanwhile: another thread may take a snapshot.
                context.sample_all(worker, &mut meter, &mut jobs);
                // The meter may call back.
                drop(meter);
                let mut tile = lock(tile);
                policy.add(&jobs, film, &mut tile, state);
                policy.finish(film, &tile, state, control);
                drop(tile);
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
    }
    states
}
