//! Starts as many threads as the system gives.

use std::hint::black_box;
use std::io;
use std::sync::mpsc::{Sender, channel};

use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuilder};

/// Starts the threads for all work of this process that asks for none of its own: `wanted` or, if that is 0, one for each
/// processor. Returns their number, which is smaller where the system gives no more (`ulimit -u`, `ulimit -v`), but at least
/// 1. Call it before any other work; later calls change nothing.
pub fn start_threads(wanted: usize) -> usize {
    let mut waiting = waiting(wanted);
    let mut builder = ThreadPoolBuilder::new().num_threads(waiting.len().max(1));
    if waiting.is_empty() {
        builder = builder.use_current_thread();
    }
    // An error means that there are threads already.
    let _ = builder.spawn_handler(|thread| hand_over(&mut waiting, thread)).build_global();
    threads()
}

/// How many threads [`start_threads`] has started.
pub fn threads() -> usize {
    rayon::current_num_threads()
}

/// Up to `wanted` threads of their own; `None` if the system gives none.
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

/// What must be free for another thread: its stack, and the 128 MB of addresses in which glibc looks for 64 MB for it. A
/// thread that does not find them at first takes them later from the memory that is kept.
const THREAD_BYTES: usize = 136 << 20;
/// Half of the free memory is kept for other uses than threads, up to so much.
const KEPT_BYTES: usize = 1 << 30;

/// Starts threads, until there are enough or no more can be started, which rayon does not bear. They wait for their work.
fn waiting(wanted: usize) -> Vec<Sender<ThreadBuilder>> {
    let wanted =
        if wanted == 0 { std::thread::available_parallelism().map_or(1, usize::from) } else { wanted };
    let kept = reserved(free_bytes(2 * KEPT_BYTES) / 2);
    let (tell, is_ready) = channel();
    let start = |_| {
        drop(reserved(THREAD_BYTES)?);
        let (sender, receiver) = channel::<ThreadBuilder>();
        let tell = tell.clone();
        let thread = move || {
            // The allocator sets memory aside when a thread first allocates: now, while some is kept.
            drop(black_box(Vec::<u8>::with_capacity(1)));
            let _ = tell.send(());
            receiver.into_iter().take(1).for_each(ThreadBuilder::run);
        };
        std::thread::Builder::new().spawn(thread).ok()?;
        // Until it has the memory that it starts with.
        is_ready.recv().ok()?;
        Some(sender)
    };
    let threads = (0..wanted).map_while(start).collect();
    drop(kept);
    threads
}

/// Memory of this size that nothing uses. `None` if the system does not give it.
fn reserved(bytes: usize) -> Option<Vec<u8>> {
    let mut memory = Vec::new();
    memory.try_reserve_exact(bytes).ok()?;
    // Otherwise it is optimized away.
    Some(black_box(memory))
}

/// The largest size up to `most` that the system gives at once, within a thousandth of `most`.
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
