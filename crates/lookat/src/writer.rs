//! Output from a thread of its own: a terminal or a viewer that does not read blocks neither the rendering nor signals.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::ops::ControlFlow;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::{Duration, Instant};

/// The longest wait for a reader that takes nothing.
const PATIENCE: Duration = Duration::from_secs(2);

/// Writes bytes in parts, and calls `progress` after each part.
///
/// # Errors
///
/// As [`Write::write_all`].
pub fn write_parts(out: &mut dyn Write, bytes: &[u8], progress: &dyn Fn()) -> io::Result<()> {
    bytes.chunks(1 << 12).try_for_each(|part| {
        out.write_all(part)?;
        progress();
        Ok(())
    })
}

/// A queue, and the thread that writes what is in it.
pub struct Writer<T>(Arc<Shared<T>>);

struct Shared<T> {
    state: Mutex<State<T>>,
    changed: Condvar,
}

struct State<T> {
    queue: VecDeque<T>,
    is_writing: bool,
    /// True once the thread has ended: because the reader is gone, or by a panic.
    is_lost: bool,
    /// When the reader last took something, or was given something while it waited.
    progress: Instant,
}

impl<T: Send + 'static> Writer<T> {
    /// Starts the thread. It calls `write` for each item, with a function to call whenever a part of the item is written. When `write`
    /// breaks, nothing more is written.
    ///
    /// # Errors
    ///
    /// The system allows no further thread.
    pub fn new(
        mut write: impl FnMut(T, &dyn Fn()) -> ControlFlow<()> + Send + 'static,
    ) -> io::Result<Writer<T>> {
        let state =
            State { queue: VecDeque::new(), is_writing: false, is_lost: false, progress: Instant::now() };
        let shared = Arc::new(Shared { state: Mutex::new(state), changed: Condvar::new() });
        let own = shared.clone();
        Builder::new().spawn(move || {
            let end = End(&own);
            let progress = || end.0.set(|state| state.progress = Instant::now());
            while write(end.0.next(), &progress).is_continue() {}
        })?;
        Ok(Writer(shared))
    }

    /// Changes the queue: adds to it, and removes what is out of date.
    pub fn put(&self, change: impl FnOnce(&mut VecDeque<T>)) {
        self.0.set(|state| {
            if state.is_idle() {
                state.progress = Instant::now();
            }
            change(&mut state.queue);
        });
    }

    /// True if everything is written.
    pub fn is_idle(&self) -> bool {
        lock(&self.0.state).is_idle()
    }

    /// Waits until everything is written. Gives up, and returns false, if the reader takes nothing for [`PATIENCE`] while
    /// `is_impatient` holds.
    pub fn wait(&self, is_impatient: impl Fn() -> bool) -> bool {
        /// The time between two looks.
        const STEP: Duration = Duration::from_millis(50);
        let mut state = lock(&self.0.state);
        while !state.is_idle() {
            if state.progress.elapsed() >= PATIENCE && is_impatient() {
                return false;
            }
            let waited = self.0.changed.wait_timeout(state, STEP);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        true
    }
}

impl<T> Shared<T> {
    fn set(&self, change: impl FnOnce(&mut State<T>)) {
        change(&mut lock(&self.state));
        self.changed.notify_all();
    }

    /// Waits for the next item.
    fn next(&self) -> T {
        self.set(|state| state.is_writing = false);
        let mut state = lock(&self.state);
        loop {
            if let Some(item) = state.queue.pop_front() {
                (state.is_writing, state.progress) = (true, Instant::now());
                return item;
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// Tells that the thread has ended, when it is dropped.
struct End<'s, T>(&'s Shared<T>);

impl<T> Drop for End<'_, T> {
    fn drop(&mut self) {
        self.0.set(|state| state.is_lost = true);
    }
}

impl<T> State<T> {
    fn is_idle(&self) -> bool {
        self.is_lost || !self.is_writing && self.queue.is_empty()
    }
}

/// Locks a mutex, also after a thread has panicked with it.
pub fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whoever waits does not wait for a thread that has ended.
    #[test]
    fn nobody_waits_for_a_thread_that_has_ended() {
        for panics in [true, false] {
            let writer = Writer::new(move |(), _| {
                assert!(!panics, "a test of a panic");
                ControlFlow::Break(())
            });
            let writer = writer.unwrap();
            writer.put(|queue| queue.extend([(), ()]));
            // Without an end, this would wait forever.
            assert!(writer.wait(|| false), "{panics}");
        }
    }
}
