//! Ctrl-C (SIGINT), and SIGTERM, which `timeout` and batch systems send.

use std::io::{self, IsTerminal};
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use lookat_image::exit;

use crate::lock::lock;

/// The exit status after both signals, as for a program ended by SIGINT.
pub const STATUS: u8 = 130;

static ASKED: AtomicBool = AtomicBool::new(false);

/// How to stop in order; `None` ends the program at once.
static ORDERLY: Mutex<Option<Orderly>> = Mutex::new(None);

/// How a command stops in order.
#[derive(Clone, Copy)]
struct Orderly {
    notice: Option<&'static str>,
    is_worth_while: fn() -> bool,
}

/// Tells long computations to stop after a signal.
pub fn flow() -> ControlFlow<()> {
    if ASKED.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

/// From now on the first time asks to stop, and `notice` is said; the second, or the first while it is not worth while to
/// stop in order, ends the program at once.
pub fn stop_in_order(notice: Option<&'static str>, is_worth_while: fn() -> bool) {
    *lock(&ORDERLY) = Some(Orderly { notice, is_worth_while });
}

/// Signals within this time count as one: `timeout` signals a program and then its process group.
const TOGETHER: Duration = Duration::from_millis(100);

/// Watches for both, from a thread of its own. Ending the program at once leaves no temporary files.
pub fn watch() {
    let mut first: Option<Instant> = None;
    let interrupt = move || {
        if let Some(first) = first {
            if first.elapsed() > TOGETHER {
                exit(STATUS.into());
            }
            return;
        }
        first = Some(Instant::now());
        let orderly = *lock(&ORDERLY);
        let Some(Orderly { notice, is_worth_while }) = orderly else { exit(STATUS.into()) };
        ASKED.store(true, Ordering::Relaxed);
        // Start below the progress bar.
        if notice.is_some() && io::stderr().is_terminal() {
            eprintln!();
        }
        if !is_worth_while() {
            crate::say("interrupted; nothing was written");
            exit(STATUS.into());
        }
        notice.into_iter().for_each(crate::say);
    };
    if let Err(error) = on_signal(interrupt) {
        let error = lookat_image::io_reason(&error);
        crate::say(&format!("warning: cannot watch for Ctrl-C ({error}): it ends lookat without a picture"));
    }
    // Writing beyond the largest size of files (`ulimit -f`) is then an error, not the end of the program.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
}

/// The exit status where memory cannot be had in spite of the budget. No other failure has it.
#[cfg(unix)]
const ABORTED: i32 = 70;

/// Ends the program by a status, not by a signal, where Rust aborts: without the memory that the budget allows.
pub fn survive_abort() {
    #[cfg(unix)]
    {
        let always = std::sync::Arc::new(AtomicBool::new(true));
        let abort = signal_hook::consts::SIGABRT;
        let _ = signal_hook::flag::register_conditional_shutdown(abort, ABORTED, always);
    }
}

#[cfg(unix)]
fn on_signal(mut interrupt: impl FnMut() + Send + 'static) -> io::Result<()> {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let (tell, told) = std::sync::mpsc::channel();
    // Watches only once there is a thread: without one, signals keep their usual effect.
    let watch = move || {
        // Not SIGHUP, so that `nohup` can ignore it.
        let signals = Signals::new([SIGINT, SIGTERM]);
        let _ = tell.send(signals.as_ref().map(drop).map_err(|error| io::Error::other(error.to_string())));
        signals.into_iter().for_each(|mut signals| signals.forever().for_each(|_| interrupt()));
    };
    std::thread::Builder::new().spawn(watch)?;
    told.recv().map_err(io::Error::other)?
}

#[cfg(not(unix))]
fn on_signal(mut interrupt: impl FnMut() + Send + 'static) -> io::Result<()> {
    let asked = std::sync::Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(signal_hook::consts::SIGINT, asked.clone())?;
    let watch = move || {
        loop {
            std::thread::sleep(TOGETHER / 2);
            if asked.swap(false, Ordering::Relaxed) {
                interrupt();
            }
        }
    };
    std::thread::Builder::new().spawn(watch).map(drop)
}
