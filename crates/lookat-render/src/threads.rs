//! Starts as many threads as the system allows.

use std::hint::black_box;
use std::io;
use std::sync::mpsc::{Sender, channel};

use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuilder};

/// Starts the global thread pool, which does all work that has no pool of its own. `wanted` is the number of threads; 0
/// means one per processor. Returns the number of threads, at least 1. It is below `wanted` if the system allows no
/// more (`ulimit -u`, `ulimit -v`). Call this function before any other work: later calls change nothing.
pub fn start_threads(wanted: usize) -> usize {
    let mut waiting = waiting(wanted);
    let mut builder = ThreadPoolBuilder::new().num_threads(waiting.len().max(1));
    if waiting.is_empty() {
        builder = builder.use_current_thread();
    }
    // An error means that the pool exists already.
    let _ = builder.spawn_handler(|thread| hand_over(&mut waiting, thread)).build_global();
    threads()
}

/// The number of threads that [`start_threads`] started.
pub fn threads() -> usize {
    rayon::current_num_threads()
}

/// A separate pool of up to `wanted` threads (0: one per processor). `None` if the system allows no thread.
pub(crate) fn pool(wanted: usize) -> Option<ThreadPool> {
    let mut waiting = waiting(wanted);
    if waiting.is_empty() {
        return None;
    }
    let builder = ThreadPoolBuilder::new().num_threads(waiting.len());
    builder.spawn_handler(|thread| hand_over(&mut waiting, thread)).build().ok()
}

fn hand_over(waiting: &mut Vec<Sender<ThreadBuilder>>, thread: ThreadBuilder) -> io::Result<()> {
    let next = waiting.pop().ok_or_else(|| io::Error::other("there is no thread"))?;
    next.send(thread).map_err(|_| io::Error::other("the thread has ended"))
}

/// The bytes that must be free to start another thread: its stack, and the 128 MB of addresses in which glibc looks for
/// 64 MB. A thread that does not find them at its start takes them later from the kept memory.
const THREAD_BYTES: usize = 136 << 20;
/// The most memory, in bytes, to keep free for uses other than threads. If less than twice as much is free, half of the
/// free memory is kept.
const KEPT_BYTES: usize = 1 << 30;

/// Starts threads that wait for their work, up to `wanted` (0: one per processor) or until the system refuses one.
/// rayon cannot continue after a refused thread, so the threads start before the pool.
fn waiting(wanted: usize) -> Vec<Sender<ThreadBuilder>> {
    let wanted =
        if wanted == 0 { std::thread::available_parallelism().map_or(1, usize::from) } else { wanted };
    let kept = reserved(free_bytes(2 * KEPT_BYTES) / 2);
    let (ready, is_ready) = channel();
    let start = |_| {
        drop(reserved(THREAD_BYTES)?);
        let (sender, receiver) = channel::<ThreadBuilder>();
        let ready = ready.clone();
        let thread = move || {
            // The first allocation of a thread reserves memory for it. Force it now, while memory is kept free.
            drop(black_box(Vec::<u8>::with_capacity(1)));
            let _ = ready.send(());
            receiver.into_iter().take(1).for_each(ThreadBuilder::run);
        };
        std::thread::Builder::new().spawn(thread).ok()?;
        // Wait until the thread has reserved its memory.
        is_ready.recv().ok()?;
        Some(sender)
    };
    let threads = (0..wanted).map_while(start).collect();
    drop(kept);
    threads
}

/// Allocates unused memory of this size. `None` if the system refuses.
fn reserved(bytes: usize) -> Option<Vec<u8>> {
    let mut memory = Vec::new();
    memory.try_reserve_exact(bytes).ok()?;
    // `black_box` keeps the compiler from removing the allocation.
    Some(black_box(memory))
}

/// The largest allocation up to `most` bytes that the system allows, to within a thousandth of `most`.
fn free_bytes(most: usize) -> usize {
    let (mut free, mut step) = (0, most);
    while step >= most / 1024 {
        if free + step <= most && reserved(free + step).is_some() {
            free += step;
        }
        step /= 2;
    }
    free
}
