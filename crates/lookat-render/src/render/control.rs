//! When to stop, and how far it is.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::Progress;

/// Shared by all threads of a rendering.
pub(super) struct Control<'p> {
    progress: &'p (dyn Fn(Progress) -> ControlFlow<()> + Sync),
    /// Of a time that no clock reaches there is none.
    deadline: Option<Instant>,
    stopped: AtomicBool,
    interrupted: AtomicBool,
    done: AtomicU64,
    total: AtomicU64,
    /// The bounds of the samples in all.
    bounds: Mutex<Option<[u64; 2]>>,
    pixels_done: AtomicU64,
    rays: AtomicU64,
    rejected: AtomicU64,
}

impl<'p> Control<'p> {
    /// The time begins now.
    pub fn new(
        progress: &'p (dyn Fn(Progress) -> ControlFlow<()> + Sync),
        time: Option<Duration>,
    ) -> Control<'p> {
        Control {
            progress,
            deadline: time.and_then(|time| Instant::now().checked_add(time)),
            stopped: AtomicBool::new(false),
            interrupted: AtomicBool::new(false),
            done: AtomicU64::new(0),
            total: AtomicU64::new(0),
            bounds: Mutex::new(None),
            pixels_done: AtomicU64::new(0),
            rays: AtomicU64::new(0),
            rejected: AtomicU64::new(0),
        }
    }

    /// How many samples there will be.
    pub fn expect(&self, total: u64) {
        self.total.store(total, Ordering::Relaxed);
        self.expect_between(Some([total; 2]));
    }

    /// How many samples there will be at least and at most, as far as that is known.
    pub fn expect_between(&self, bounds: Option<[u64; 2]>) {
        *self.bounds.lock().unwrap_or_else(PoisonError::into_inner) = bounds;
    }

    /// How many pixels have reached the target error.
    pub fn set_pixels_done(&self, pixels: u64) {
        self.pixels_done.store(pixels, Ordering::Relaxed);
    }

    fn progress(&self, done: u64) -> Progress {
        let bounds = *self.bounds.lock().unwrap_or_else(PoisonError::into_inner);
        let left = bounds.map(|bounds| bounds.map(|total| total.saturating_sub(done)));
        Progress { done, total: self.total(), left, pixels_done: self.pixels_done.load(Ordering::Relaxed) }
    }

    /// Counts samples as done, and asks the clock and the caller.
    fn advance(&self, samples: u64) {
        let done = self.done.fetch_add(samples, Ordering::Relaxed) + samples;
        if self.deadline.is_some_and(|deadline| Instant::now() >= deadline) {
            self.stopped.store(true, Ordering::Relaxed);
        }
        if (self.progress)(self.progress(done)).is_break() {
            self.interrupted.store(true, Ordering::Relaxed);
            self.stopped.store(true, Ordering::Relaxed);
        }
    }

    /// Counts what a tile took.
    pub fn add(&self, rays: u64, rejected: u64) {
        self.rays.fetch_add(rays, Ordering::Relaxed);
        self.rejected.fetch_add(rejected, Ordering::Relaxed);
    }

    pub fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }

    /// Whether the callback broke off.
    pub fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }

    pub fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed)
    }

    pub fn total(&self) -> u64 {
        self.total.load(Ordering::Relaxed)
    }

    pub fn rays(&self) -> u64 {
        self.rays.load(Ordering::Relaxed)
    }

    pub fn rejected(&self) -> u64 {
        self.rejected.load(Ordering::Relaxed)
    }
}

/// Samples that a thread takes before it asks whether to stop, at most.
const BATCH: u32 = 256;
/// Those that it takes first.
const FIRST_BATCH: u32 = 4;
/// Rays that it traces before it asks, about, or those of one sample: a hundredth of a second.
const RAYS: u64 = 1 << 14;

/// Counts the samples of one thread, to tell of them in batches.
pub(super) struct Meter<'c, 'p> {
    control: &'c Control<'p>,
    since: u64,
    /// Rays traced when samples were last counted.
    rays: u64,
    /// Samples to take at once.
    batch: u32,
}

impl<'c, 'p> Meter<'c, 'p> {
    pub fn new(control: &'c Control<'p>) -> Self {
        Meter { control, since: 0, rays: 0, batch: FIRST_BATCH }
    }

    /// How many samples to take at once, so that they are soon done.
    pub fn batch(&self) -> u32 {
        self.batch
    }

    /// Whether a sample takes so long that few are to be taken at once.
    pub fn is_slow(&self) -> bool {
        self.batch < FIRST_BATCH
    }

    /// Counts samples of a thread that has traced so many rays in all; whether to go on.
    pub fn add(&mut self, samples: u32, rays: u64) -> bool {
        let are_many = rays - self.rays > RAYS;
        self.rays = rays;
        self.batch = if are_many { (self.batch / 4).max(1) } else { (self.batch * 4).min(BATCH) };
        self.since += u64::from(samples);
        if self.since >= u64::from(BATCH) || are_many {
            self.control.advance(std::mem::take(&mut self.since));
        }
        !self.control.is_stopped()
    }
}

impl Drop for Meter<'_, '_> {
    fn drop(&mut self) {
        if self.since > 0 {
            self.control.advance(self.since);
        }
    }
}
