//! The progress of a rendering, and when it stops.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use super::Progress;
use crate::film::Film;
use crate::integrator::{Profiler, Stage, Tracer};

/// The state that all threads of a rendering share.
pub(super) struct Control<'p> {
    progress: &'p (dyn Fn(Progress) -> ControlFlow<()> + Sync),
    film: &'p Film<'p>,
    /// `None` without a time limit, and for a time limit beyond the range of the clock.
    deadline: Option<Instant>,
    stopped: AtomicBool,
    interrupted: AtomicBool,
    done: AtomicU64,
    total: AtomicU64,
    /// The least and the most samples in all. `None` while unknown.
    bounds: Mutex<Option<[u64; 2]>>,
    pixels_done: AtomicU64,
    rays: AtomicU64,
    rejected: AtomicU64,
    clamped: AtomicU64,
    /// The profilers of finished tiles, if stages are measured.
    pub profilers: Option<&'p Mutex<Vec<Profiler>>>,
}

impl<'p> Control<'p> {
    /// A rendering of a film that stops at the deadline, if there is one.
    pub fn new(
        progress: &'p (dyn Fn(Progress) -> ControlFlow<()> + Sync),
        deadline: Option<Instant>,
        film: &'p Film<'p>,
    ) -> Control<'p> {
        Control {
            progress,
            film,
            deadline,
            stopped: AtomicBool::new(false),
            interrupted: AtomicBool::new(false),
            done: AtomicU64::new(0),
            total: AtomicU64::new(0),
            bounds: Mutex::new(None),
            pixels_done: AtomicU64::new(0),
            rays: AtomicU64::new(0),
            rejected: AtomicU64::new(0),
            clamped: AtomicU64::new(0),
            profilers: None,
        }
    }

    /// Sets the total number of samples.
    pub fn expect(&self, total: u64) {
        self.total.store(total, Ordering::Relaxed);
        self.expect_between(Some([total; 2]));
    }

    /// Sets the least and the most samples in all. `None` if they are unknown.
    pub fn expect_between(&self, bounds: Option<[u64; 2]>) {
        *self.bounds.lock().unwrap_or_else(PoisonError::into_inner) = bounds;
    }

    /// Sets the number of pixels that have reached the target error.
    pub fn set_pixels_done(&self, pixels: u64) {
        self.pixels_done.store(pixels, Ordering::Relaxed);
    }

    fn progress(&self, done: u64) -> Progress<'_> {
        let bounds = *self.bounds.lock().unwrap_or_else(PoisonError::into_inner);
        let left = bounds.map(|bounds| bounds.map(|total| total.saturating_sub(done)));
        let pixels_done = self.pixels_done.load(Ordering::Relaxed);
        Progress { done, total: self.total(), left, pixels_done, film: self.film }
    }

    /// Counts finished samples, then checks the deadline and calls the progress callback.
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

    /// Counts the rays of a tile, and its rejected and clamped samples.
    pub fn add(&self, rays: u64, rejected: u64, clamped: u64) {
        self.rays.fetch_add(rays, Ordering::Relaxed);
        self.rejected.fetch_add(rejected, Ordering::Relaxed);
        self.clamped.fetch_add(clamped, Ordering::Relaxed);
    }

    /// A profiler for a tile, if stages are measured.
    pub fn profiler(&self) -> Option<Box<Profiler>> {
        self.profilers.map(|_| Box::new(Profiler::new()))
    }

    /// Adds the profiler of a finished tile.
    pub fn keep(&self, tracer: &mut Tracer) {
        tracer.profile(|profiler| profiler.enter(Stage::Film));
        if let (Some(all), Some(profiler)) = (self.profilers, tracer.profiler.take()) {
            all.lock().unwrap_or_else(PoisonError::into_inner).push(*profiler);
        }
    }

    pub fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }

    /// True if the progress callback interrupted the rendering.
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

    pub fn clamped(&self) -> u64 {
        self.clamped.load(Ordering::Relaxed)
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
