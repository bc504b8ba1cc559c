//! Ctrl-C, and SIGTERM, which `timeout` and batch systems send.

use std::io::{self, IsTerminal};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The exit status after either: that of a program that SIGINT ends.
pub const STATUS: u8 = 130;

static ASKED: AtomicBool = AtomicBool::new(false);

/// What long work is told: to stop if the program is asked to.
pub fn flow() -> ControlFlow<()> {
    if ASKED.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

/// What comes so soon after the first is no second time: `timeout` sends to a program, and then to its whole group.
const TOGETHER: Duration = Duration::from_millis(100);

/// Watches for both. The first time asks to stop, and `notice` is said; the second, or the first while it is not worth while
/// to stop in order, ends the program at once.
pub fn watch(notice: Option<&'static str>, is_worth_while: fn() -> bool) -> Result<(), String> {
    let mut first: Option<Instant> = None;
    let interrupt = move || {
        if let Some(first) = first {
            if first.elapsed() > TOGETHER {
                std::process::exit(STATUS.into());
            }
            return;
        }
        first = Some(Instant::now());
        ASKED.store(true, Ordering::Relaxed);
        // Below the bar.
        if notice.is_some() && io::stderr().is_terminal() {
            eprintln!();
        }
        if !is_worth_while() {
            crate::say("interrupted; nothing is written");
            std::process::exit(STATUS.into());
        }
        notice.into_iter().for_each(crate::say);
    };
    on_signal(interrupt).map_err(|error| format!("cannot watch for Ctrl-C: {error}"))
}

#[cfg(unix)]
fn on_signal(mut interrupt: impl FnMut() + Send + 'static) -> io::Result<()> {
    use signal_hook::consts::{SIGINT, SIGTERM};
    // Not SIGHUP, which is for `nohup` to ignore.
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM])?;
    std::thread::Builder::new().spawn(move || signals.forever().for_each(|_| interrupt()))?;
    Ok(())
}

#[cfg(not(unix))]
fn on_signal(interrupt: impl FnMut() + Send + 'static) -> io::Result<()> {
    ctrlc::set_handler(interrupt).map_err(io::Error::other)
}
