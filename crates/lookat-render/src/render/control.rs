//! The progress of a rendering, and when it stops.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard};
use std::time::Instant;

use super::{Progress, Statistics};
use crate::film::{Film, lock};
use crate::integrator::path_record::PATHS;
use crate::integrator::{Profiler, Stage, Supervisor, Tracer};
use crate::number::LANES;

/// The state that all threads of a rendering share.
pub(super) struct Control<'p> {
    pub progress: &'p (dyn Fn(Progress) -> ControlFlow<()> + Sync),
    pub film: &'p Film<'p>,
    /// `None` without a time limit, and for a time limit beyond the range of the clock.
    pub deadline: Option<Instant>,
    /// The profilers of finished tiles, if stages are measured.
    pub profilers: Option<&'p Mutex<Vec<Profiler>>>,
    pub stopped: AtomicBool,
    /// The rays of a sample where the threads are: the most of the last batches. 0 while unknown.
    pub rays_per_sample: AtomicU64,
    pub state: Mutex<State>,
}

/// The state of a rendering.
#[derive(Default)]
pub(super) struct State {
    /// True if the progress callback interrupted the rendering.
    pub interrupted: bool,
    /// True if no sample is left to take.
    pub is_finished: bool,
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

impl<'p> Control<'p> {
    /// The state of a rendering that has not started, without a deadline.
    pub fn new(
        progress: &'p (dyn Fn(Progress) -> ControlFlow<()> + Sync),
        film: &'p Film<'p>,
    ) -> Control<'p> {
        Control {
            progress,
            film,
            deadline: None,
            profilers: None,
            stopped: AtomicBool::new(false),
            rays_per_sample: AtomicU64::new(0),
            state: Mutex::default(),
        }
    }

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
            let State { done, total, bounds, pixels_done, statistics, .. } = *state;
            let left = bounds.map(|bounds| bounds.map(|total| total.saturating_sub(done)));
            Progress { done, total, left, pixels_done, statistics, film: self.film }
        };
        let is_interrupted = (self.progress)(progress).is_break();
        if is_interrupted {
            self.state().interrupted = true;
        }
        if is_interrupted || self.deadline.is_some_and(|deadline| Instant::now() >= deadline) {
            self.stopped.store(true, Ordering::Relaxed);
        }
    }

    /// Calls the progress callback after all samples are done. True if the rendering is interrupted.
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

impl Supervisor for Control<'_> {
    fn should_continue(&self) -> bool {
        self.advance(0);
        !self.is_stopped()
    }
}

/// The samples that a thread takes before it reports them.
const BATCH: u64 = 256;
/// The approximate number of rays of a batch of samples: about 10 ms.
const RAYS: u64 = 1 << 14;

/// Counts the samples of one thread and reports them in batches.
pub(super) struct Meter<'c, 'p> {
    control: &'c Control<'p>,
    counts: bool,
    unreported: u64,
    /// The rays that the thread had traced at the last call of `add`.
    rays: u64,
}

impl<'c, 'p> Meter<'c, 'p> {
    pub fn new(control: &'c Control<'p>) -> Self {
        Meter { control, counts: true, unreported: 0, rays: 0 }
    }

    /// One for samples that do not count.
    pub fn silent(control: &'c Control<'p>) -> Self {
        Meter { counts: false, ..Meter::new(control) }
    }

    /// The samples to take together: fewer where each takes many rays, and eight until that is known.
    pub fn batch(&self) -> usize {
        let rays = self.control.rays_per_sample.load(Ordering::Relaxed);
        let most = RAYS.checked_div(rays).unwrap_or(0).min(PATHS as u64) as usize;
        (most / LANES * LANES).max(LANES)
    }

    /// Counts `samples` more samples. `rays` is the total number of rays of the thread. False if the rendering stops.
    pub fn add(&mut self, samples: u32, rays: u64) -> bool {
        let of_batch = rays - self.rays;
        self.rays = rays;
        // Slow parts of the picture are remembered for some batches, and fast parts are learned from little by little.
        let before = self.control.rays_per_sample.load(Ordering::Relaxed);
        let now = of_batch.div_ceil(u64::from(samples.max(1))).max(1).max(before - before.div_ceil(4));
        if now != before {
            self.control.rays_per_sample.store(now, Ordering::Relaxed);
        }
        self.unreported += u64::from(if self.counts { samples } else { 0 });
        if self.unreported >= BATCH || of_batch > RAYS {
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
