//! The loop over samples: rounds over all tiles, each of as many samples as a policy asks for; the policy that gives each pixel the
//! same number; and an estimate of the remaining time.

#[cfg(test)]
mod tests;

use std::fmt::Debug;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use lookat_scene::Sampler;
use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_bytes::ByteBuf;

use super::control::{Control, Meter};
use super::sample::{Context, Job, Pattern, Worker};
use super::{Progress, Settings};
use crate::film::{Film, FilmSumsError, Keeps, PolicyState, PolicyStates, REPLICATES, Tile, lock};
use crate::sampler::{of_single_pixels, replicate_seed};

/// Decides where the next samples go, and when there are enough.
pub(super) trait Policy: Sync {
    /// The state of a tile that is kept beside the film.
    type State: Debug + Send + Serialize + DeserializeOwned + 'static;
    /// What is planned, beside the states of tiles.
    type Plan: Serialize + DeserializeOwned;

    /// The state of a tile without samples.
    fn begin(&self, tile: &Tile) -> Self::State;

    /// Plans the next round from the film so far. False if the rendering is finished.
    fn next(&mut self, film: &Film, states: &[Mutex<Self::State>]) -> bool;

    /// Tells how many samples there are to be in all, in this round or after it.
    fn expect(&self, film: &Film, states: &[Mutex<Self::State>], control: &Control);

    /// The samples of a tile in this round that it does not have yet.
    fn jobs(&self, tile: &Tile, state: &Self::State) -> Vec<Job>;

    /// Looks at the samples of a tile. Jobs may lack some if the rendering has been stopped.
    fn note(&self, _jobs: &[Job], _state: &mut Self::State) {}

    /// Merges the pass of the film after a round. `is_whole`: no samples are missing.
    fn end(&mut self, _film: &Film, _states: &[Mutex<Self::State>], _is_whole: bool) {}

    /// The plan, to go on with after a break.
    fn plan(&self) -> &Self::Plan;

    /// Goes on with a plan, in the middle of a round if that is begun. False if no plan of this rendering can be like that, or if one of
    /// the states cannot.
    fn resume(
        &mut self,
        plan: Self::Plan,
        film: &Film,
        states: &[Mutex<Self::State>],
        is_begun: bool,
    ) -> bool;
}

/// What a policy knows, as it is kept beside the film.
#[derive(Debug)]
struct States<S> {
    /// The plan, and whether its round has begun, in the form of [`PolicyState`].
    plan: Mutex<Vec<u8>>,
    tiles: Vec<Mutex<S>>,
}

impl<S: Debug + Send + Serialize> PolicyStates for States<S> {
    fn encoded(&self) -> PolicyState {
        let plan = ByteBuf::from(lock(&self.plan).clone());
        let tiles = self.tiles.iter().fold(Vec::new(), |all, state| encoded(&*lock(state), all));
        PolicyState { plan, tiles }
    }
}

/// Appends the encoded value to bytes.
fn encoded(value: &impl Serialize, before: Vec<u8>) -> Vec<u8> {
    postcard::to_extend(value, before).expect("plain data in memory can be written")
}

/// A rendering by a policy, round after round.
pub(super) struct Rounds<'p, P: Policy> {
    policy: &'p mut P,
    states: Arc<States<P::State>>,
    /// True in the middle of a round.
    is_begun: bool,
}

impl<'p, P: Policy> Rounds<'p, P> {
    /// Begins, or goes on where the film has stopped. Fails if nothing of this policy can be like that.
    pub fn new(policy: &'p mut P, film: &Film, so_far: Option<PolicyState>) -> Result<Self, FilmSumsError> {
        let mut is_begun = false;
        let tiles: Vec<_> = match so_far.filter(|state| !state.plan.is_empty()) {
            None => film.tiles.iter().map(|tile| Mutex::new(policy.begin(&lock(tile)))).collect(),
            Some(PolicyState { plan, tiles }) => {
                let mut left = &tiles[..];
                let mut state = |_: &Mutex<Tile>| {
                    let (state, rest) = postcard::take_from_bytes(left).ok()?;
                    left = rest;
                    Some(Mutex::new(state))
                };
                let states: Option<Vec<_>> = film.tiles.iter().map(&mut state).collect();
                let read = states.zip(postcard::from_bytes::<(bool, P::Plan)>(&plan).ok());
                let (states, (begun, plan)) = read.ok_or(FilmSumsError::Unreadable)?;
                if !left.is_empty() || !policy.resume(plan, film, &states, begun) {
                    return Err(FilmSumsError::Unreadable);
                }
                is_begun = begun;
                states
            }
        };
        let states = Arc::new(States { plan: Mutex::default(), tiles });
        let rounds = Rounds { policy, states, is_begun };
        if film.keeps_policy {
            rounds.keep_plan();
            let _ = film.policy_states.set(rounds.states.clone());
        }
        Ok(rounds)
    }

    /// Keeps the plan, for going on after a break.
    fn keep_plan(&self) {
        *lock(&self.states.plan) = encoded(&(self.is_begun, self.policy.plan()), Vec::new());
    }

    /// Renders to the end, or until the rendering stops.
    pub fn render(&mut self, context: &Context) {
        let Context { film, control, .. } = context;
        let states = &*self.states.clone().tiles;
        let counts =
            |tile: &Mutex<Tile>| lock(tile).counts.iter().map(|count| u64::from(*count)).sum::<u64>();
        control.state().done = film.tiles.iter().map(counts).sum();
        self.policy.expect(film, states, control);
        loop {
            if !self.is_begun {
                self.is_begun = self.policy.next(film, states);
                if film.keeps_policy {
                    self.keep_plan();
                }
            }
            control.state().is_finished = !self.is_begun;
            if !self.is_begun || control.is_stopped() {
                break;
            }
            self.policy.expect(film, states, control);
            let is_whole = self.sample(context);
            // Where it is to go on, a round that is broken off stays as it is.
            if is_whole || !film.keeps_policy {
                self.policy.end(film, states, is_whole);
            }
            if !is_whole {
                break;
            }
            self.is_begun = false;
        }
    }

    /// What the policy knows about each tile.
    pub fn states(&self) -> &[Mutex<P::State>] {
        &self.states.tiles
    }

    /// Takes the samples of a round. True if none is missing.
    fn sample(&self, context: &Context) -> bool {
        let Context { film, control, .. } = context;
        let whole_tiles = AtomicUsize::new(0);
        let policy = &*self.policy;
        film.tiles.par_iter().zip(&self.states.tiles).for_each_init(
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
                    (tile.sources, policy.jobs(&tile, &lock(state)))
                };
                worker.block.get_or_insert_default().restart(film, sources);
                // Not locked meanwhile: another thread may take a snapshot.
                context.sample_all(worker, &mut meter, &mut jobs);
                // The meter may call back.
                drop(meter);
                let is_whole = jobs.iter().all(Job::is_whole);
                // What the policy knows about a tile is of whole rounds.
                if let Some(block) = worker.block.as_mut().filter(|_| is_whole || !film.keeps_policy) {
                    let adding = film.adding();
                    film.add(block, &adding);
                    policy.note(&jobs, &mut lock(state));
                }
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
        whole_tiles.into_inner() == film.tiles.len()
    }
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
#[derive(Debug, Clone)]
pub(super) struct Pass {
    pub pattern: Pattern,
    /// The indices of the samples in the pattern.
    pub samples: Range<u32>,
    /// The place of the first of them among all samples of the pixel, in the order of passes.
    place: u32,
    /// The replicate that they belong to; 0 without error layers.
    replicate: u32,
}

impl Pass {
    /// Its samples whose places are in a range.
    fn within(mut self, range: &Range<u32>) -> Option<Pass> {
        let Range { start, end } = self.samples;
        let at = |place: u32| start + place.clamp(self.place, self.place + (end - start)) - self.place;
        self.samples = at(range.start)..at(range.end);
        self.place += self.samples.start - start;
        (!self.samples.is_empty()).then_some(self)
    }
}

/// Passes of 1, 1, 2, 4, ... samples per pixel over the whole picture, so that breaking off leaves a whole picture. With
/// error layers each pass is a replicate.
pub(super) struct Fixed {
    passes: Vec<Pass>,
    /// The number of passes that have begun.
    begun: u32,
    pub samples_per_pixel: u32,
}

impl Fixed {
    pub fn new(sampler: Sampler, settings: &Settings) -> Fixed {
        let passes = own(sampler, settings);
        let samples_per_pixel = passes.iter().map(|pass| pass.samples.len() as u32).sum();
        Fixed { passes, begun: 0, samples_per_pixel }
    }
}

/// The passes of the part that the settings ask for.
fn own(sampler: Sampler, settings: &Settings) -> Vec<Pass> {
    let samples = sampler.samples_per_pixel;
    let range = settings.part.map_or(0..samples, |part| part.range(samples));
    all(sampler, settings).into_iter().filter_map(|pass| pass.within(&range)).collect()
}

/// The number of replicates that the passes of a rendering belong to.
pub(super) fn replicates_of(sampler: Sampler, settings: &Settings) -> u32 {
    REPLICATES.min(own(sampler, settings).len() as u32)
}

/// All passes of a picture.
pub(super) fn all(sampler: Sampler, settings: &Settings) -> Vec<Pass> {
    let Settings { seed, stop, is_extendable, .. } = *settings;
    match (stop.has_error_layers(), is_extendable) {
        (true, false) => replicates(sampler, seed),
        (true, true) => extendable_replicates(sampler, seed),
        (false, _) => passes(sampler, seed, is_extendable),
    }
}

fn replicates(sampler: Sampler, seed: u64) -> Vec<Pass> {
    let samples = sampler.samples_per_pixel;
    let count = samples.min(REPLICATES);
    let mut place = 0;
    let replicate = |replicate: u32| {
        // Patterns without jitter are all the same, and show no error.
        let own = samples / count + u32::from(replicate < samples % count);
        let sampler = sampler.jittered().with_samples(own);
        let pattern = Pattern { sampler, seed: replicate_seed(seed, replicate), is_watched: false };
        let samples = 0..sampler.samples_per_pixel;
        let pass = Pass { pattern, place, replicate, samples: samples.clone() };
        place += samples.end;
        pass
    };
    (0..count).map(replicate).collect()
}

/// Each round doubles the samples of every replicate, so that a longer rendering begins with the samples of a shorter one.
fn extendable_replicates(sampler: Sampler, seed: u64) -> Vec<Pass> {
    let of_pattern = of_single_pixels(sampler.jittered());
    let (mut from, mut passes) = (0, Vec::new());
    for to in doubled(1, (sampler.samples_per_pixel / REPLICATES).max(1)) {
        for replicate in 0..REPLICATES {
            let seed = replicate_seed(seed, replicate);
            let pattern = Pattern { sampler: of_pattern, seed, is_watched: false };
            let place = REPLICATES * from + replicate * (to - from);
            passes.push(Pass { pattern, place, replicate, samples: from..to });
        }
        from = to;
    }
    passes
}

fn passes(sampler: Sampler, seed: u64, is_extendable: bool) -> Vec<Pass> {
    let mut from = 0;
    // Pixels that share a sequence need to know how many samples each takes of it.
    let of_pattern = if is_extendable { of_single_pixels(sampler) } else { sampler };
    let pass = |to| {
        let (place, samples) = (from, from..to);
        from = to;
        let pattern = Pattern { sampler: of_pattern, seed, is_watched: false };
        Pass { pattern, samples, place, replicate: 0 }
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
    type Plan = u32;

    fn begin(&self, _tile: &Tile) {}

    fn next(&mut self, film: &Film, _states: &[Mutex<()>]) -> bool {
        let Some(pass) = self.passes.get(self.begun as usize) else { return false };
        film.begin_replicate(pass.replicate as usize);
        self.begun += 1;
        true
    }

    fn expect(&self, film: &Film, _states: &[Mutex<()>], control: &Control) {
        control.expect(film.sources().size() as u64 * u64::from(self.samples_per_pixel));
    }

    fn jobs(&self, tile: &Tile, _state: &()) -> Vec<Job> {
        let (first, pass) = (&self.passes[0], &self.passes[self.begun as usize - 1]);
        let mut jobs = Vec::with_capacity(tile.sources.size());
        jobs.extend(tile.sources.pixels().zip(&tile.counts).filter_map(|(pixel, count)| {
            let pass = pass.clone().within(&(first.place + count..u32::MAX))?;
            Some(Job::new(pass.pattern, pixel, pass.samples))
        }));
        jobs
    }

    fn end(&mut self, film: &Film, _states: &[Mutex<()>], is_whole: bool) {
        if film.keeps != Keeps::Spreads {
            return;
        }
        let samples = self.passes[self.begun as usize - 1].samples.len() as u32;
        // Half a replicate is none.
        let samples = is_whole.then_some(samples);
        film.tiles.par_iter().for_each(|tile| lock(tile).merge_replicate(samples, film.scale()));
    }

    fn plan(&self) -> &u32 {
        &self.begun
    }

    fn resume(&mut self, plan: u32, _film: &Film, _states: &[Mutex<()>], is_begun: bool) -> bool {
        self.begun = plan;
        plan as usize <= self.passes.len() && (plan > 0 || !is_begun)
    }
}
