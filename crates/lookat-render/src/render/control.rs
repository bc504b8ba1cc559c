//! The progress of a rendering, and when it stops.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard};
use std::time::Instant;

use super::{Progress, Statistics};
use crate::film::{Film, lock};
use crate::integrator::{Profiler, Stage, Tracer};

/// What all threads of a rendering share.
pub(super) struct Control<'p> {
    pub progress: &'p (dyn Fn(Progress) -> ControlFlow<()> + Sync),
    pub film: &'p Film<'p>,
    /// `None` without a time limit, and for a time limit beyond the range of the clock.
    pub deadline: Option<Instant>,
    /// The profilers of finished tiles, if stages are measured.
    pub profilers: Option<&'p Mutex<Vec<Profiler>>>,
    pub stopped: AtomicBool,
    pub state: Mutex<State>,
}

/// How far a rendering is.
#[derive(Default)]
pub(super) struct State {
    /// True if the progress callback interrupted the rendering.
    pub interrupted: bool,
    /// Finished samples, and the number in all.
    pub done: u64,
    pub total: u64,
    /// The least and the most samples in all. `None` while unknown.
    pub bounds: Option<[u64; 2]>,
    /// The number of pixels that have reached the target error.
    pub pixels_done: u64,
    /// The rays of finished tiles, and their rejected and clamped samples.
    pub statistics: Statistics,
}

impl Control<'_> {
    pub fn state(&self) -> MutexGuard<'_, State> {
        lock(&self.state)
    }

    /// Sets the total number of samples.
    pub fn expect(&self, total: u64) {
        let mut state = self.state();
        (state.total, state.bounds) = (total, Some([total; 2]));
    }

    /// Counts finished samples, then checks the deadline and calls the progress callback.
    fn advance(&self, samples: u64) {
        let progress = {
            let mut state = self.state();
            state.done += samples;
            let State { done, total, bounds, pixels_done, .. } = *state;
            let left = bounds.map(|bounds| bounds.map(|total| total.saturating_sub(done)));
            Progress { done, total, left, pixels_done, film: self.film }
        };
        let is_interrupted = (self.progress)(progress).is_break();
        if is_interrupted {
            self.state().interrupted = true;
        }
        if is_interrupted || self.deadline.is_some_and(|deadline| Instant::now() >= deadline) {
            self.stopped.store(true, Ordering::Relaxed);
        }
    }

    /// Asks the progress callback, when all samples are done, whether to go on. True if the rendering is interrupted.
    pub fn is_interrupted(&self) -> bool {
        self.advance(0);
        self.state().interrupted
    }

    /// A profiler for a tile, if stages are measured.
    pub fn profiler(&self) -> Option<Box<Profiler>> {
        self.profilers.map(|_| Box::new(Profiler::new()))
    }

    /// Adds the profiler of a finished tile.
    pub fn keep(&self, tracer: &mut Tracer) {
        tracer.profile(|profiler| profiler.enter(Stage::Film));
        if let (Some(all), Some(profiler)) = (self.profilers, tracer.profiler.take()) {
            lock(all).push(*profiler);
        }
    }

    pub fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }
}

/// The most samples that a thread takes before it checks whether to stop.
const BATCH: u32 = 256;
/// The samples in the first batch of a thread.
const FIRST_BATCH: u32 = 4;
/// The approximate number of rays that a thread traces before it checks whether to stop: about 10 ms. A single sample
/// is never divided.
const RAYS: u64 = 1 << 14;

/// Counts the samples of one thread and reports them in batches.
pub(super) struct Meter<'c, 'p> {
    control: &'c Control<'p>,
    counts: bool,
    unreported: u64,
    /// The rays that the thread had traced at the last call of `add`.
    rays: u64,
    /// The samples in the next batch.
    batch: u32,
}

impl<'c, 'p> Meter<'c, 'p> {
    pub fn new(control: &'c Control<'p>) -> Self {
        Meter::counting(control, true)
    }

    /// One for samples that do not count.
    pub fn silent(control: &'c Control<'p>) -> Self {
        Meter::counting(control, false)
    }

    fn counting(control: &'c Control<'p>, counts: bool) -> Self {
        Meter { control, counts, unreported: 0, rays: 0, batch: FIRST_BATCH }
    }

    /// True if samples are so slow that the batch is smaller than the first one.
    pub fn is_slow(&self) -> bool {
        self.batch < FIRST_BATCH
    }

    /// Counts `samples` more samples. `rays` is the total number of rays of the thread. False if the rendering stops.
    pub fn add(&mut self, samples: u32, rays: u64) -> bool {
        let are_many = rays - self.rays > RAYS;
        self.rays = rays;
        self.batch = if are_many { (self.batch / 4).max(1) } else { (self.batch * 4).min(BATCH) };
        self.unreported += u64::from(if self.counts { samples } else { 0 });
        if self.unreported >= u64::from(BATCH) || are_many {
            self.control.advance(std::mem::take(&mut self.unreported));
        }
        !self.control.is_stopped()
    }
}

impl Drop for Meter<'_, '_> {
    fn drop(&mut self) {
        if self.unreported > 0 {
            self.control.advance(self.unreported);
        }
    }
}
