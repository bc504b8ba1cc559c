//! Ctrl-C, and SIGTERM, which `timeout` and batch systems send.

use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

/// The exit status after it, as the shell has it for a program that SIGINT ends.
pub const STATUS: u8 = 130;

static ASKED: AtomicBool = AtomicBool::new(false);

/// What long work is told: to stop if the program is asked to.
pub fn flow() -> ControlFlow<()> {
    if ASKED.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

/// Watches for both. The first asks to stop, and `notice` is said; a second, or one while it is not worth while to stop
/// in order, ends the program at once.
pub fn watch(notice: &'static str, is_worth_while: fn() -> bool) -> Result<(), String> {
    let interrupt = move || {
        if ASKED.swap(true, Ordering::Relaxed) || !is_worth_while() {
            std::process::exit(i32::from(STATUS));
        }
        // Below the bar.
        if std::io::stderr().is_terminal() {
            eprintln!();
        }
        crate::say(notice);
    };
    ctrlc::set_handler(interrupt).map_err(|error| format!("cannot watch for Ctrl-C: {error}"))?;
    #[cfg(unix)]
    watch_termination(interrupt).map_err(|error| format!("cannot watch for SIGTERM: {error}"))?;
    Ok(())
}

/// Apart from Ctrl-C, whose crate takes SIGTERM only together with SIGHUP: that is for `nohup` to ignore.
#[cfg(unix)]
fn watch_termination(interrupt: impl Fn() + Send + 'static) -> std::io::Result<()> {
    let mut signals = signal_hook::iterator::Signals::new([signal_hook::consts::SIGTERM])?;
    std::thread::Builder::new().spawn(move || signals.forever().for_each(|_| interrupt()))?;
    Ok(())
}
