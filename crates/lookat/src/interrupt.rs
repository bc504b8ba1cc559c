//! Signals that end a command: Ctrl-C (SIGINT), SIGTERM, SIGQUIT, SIGHUP and SIGXCPU. SIGUSR1 asks for the picture so far.

use std::io;
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use lookat_image::exit;

use crate::writer::lock;

/// The exit status after all of them, as for a program ended by SIGINT.
pub const STATUS: u8 = 130;

static ASKED: AtomicBool = AtomicBool::new(false);

/// True after SIGUSR1, until the picture so far is taken.
static ASKED_FOR_PICTURE: AtomicBool = AtomicBool::new(false);

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

/// Asks for the picture so far.
pub fn ask_for_picture() {
    ASKED_FOR_PICTURE.store(true, Ordering::Relaxed);
}

/// True once after each SIGUSR1: the picture so far is to be written.
pub fn takes_picture() -> bool {
    ASKED_FOR_PICTURE.swap(false, Ordering::Relaxed)
}

/// From now on the first time asks to stop, and `notice` is said; the second, or the first while it is not worth while to
/// stop in order, ends the program at once.
pub fn stop_in_order(notice: Option<&'static str>, is_worth_while: fn() -> bool) {
    *lock(&ORDERLY) = Some(Orderly { notice, is_worth_while });
}

/// Signals within this time count as one: `timeout` signals a program and then its process group.
const TOGETHER: Duration = Duration::from_millis(100);

/// What a signal asks for.
#[derive(Clone, Copy, PartialEq)]
enum Request {
    /// To stop. The second time, to end at once.
    Stop,
    /// To stop, however often: the system repeats SIGXCPU, and both the terminal and the shell send SIGHUP.
    #[cfg_attr(not(unix), expect(dead_code, reason = "only Unix has these signals"))]
    OnlyStop,
    /// To write the picture so far.
    #[cfg_attr(not(unix), expect(dead_code, reason = "only Unix has these signals"))]
    Picture,
}

/// Watches for signals, from a thread of its own. Ending the program at once leaves no temporary files.
pub fn watch() {
    let mut first: Option<Instant> = None;
    let interrupt = move |request: Request| {
        if request == Request::Picture {
            ask_for_picture();
            return;
        }
        if let Some(first) = first {
            if request == Request::Stop && first.elapsed() > TOGETHER {
                exit(STATUS.into());
            }
            return;
        }
        first = Some(Instant::now());
        let orderly = *lock(&ORDERLY);
        let Some(Orderly { notice, is_worth_while }) = orderly else { exit(STATUS.into()) };
        ASKED.store(true, Ordering::Relaxed);
        if !is_worth_while() {
            say!("interrupted before the first sample; nothing was written");
            crate::wait_for_messages();
            exit(STATUS.into());
        }
        if let Some(notice) = notice {
            crate::say(notice);
        }
    };
    if let Err(error) = on_signal(interrupt) {
        let error = lookat_image::io_reason(&error);
        say!("warning: cannot handle Ctrl-C ({error}): it will end lookat without a picture");
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
fn on_signal(mut interrupt: impl FnMut(Request) + Send + 'static) -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGUSR1, SIGXCPU};
    use signal_hook::iterator::Signals;

    // `nohup` ignores SIGHUP, which stays ignored. SIGINT and SIGQUIT do not: a shell without job control ignores them for each program
    // in the background, where only `kill` can mean them.
    let optional = [SIGHUP, SIGXCPU, SIGUSR1].into_iter().filter(|signal| !is_ignored(*signal));
    let signals: Vec<i32> = [SIGINT, SIGTERM, SIGQUIT].into_iter().chain(optional).collect();
    let (tell, told) = std::sync::mpsc::channel();
    // Watches only once there is a thread: without one, signals keep their usual effect.
    let watch = move || {
        let signals = Signals::new(signals);
        let _ = tell.send(signals.as_ref().map(drop).map_err(|error| io::Error::other(error.to_string())));
        let request = |signal: i32| match signal {
            SIGUSR1 => Request::Picture,
            SIGHUP | SIGXCPU => Request::OnlyStop,
            _ => Request::Stop,
        };
        let Ok(mut signals) = signals else { return };
        for signal in signals.forever() {
            interrupt(request(signal));
        }
    };
    std::thread::Builder::new().spawn(watch)?;
    told.recv().map_err(io::Error::other)?
}

/// True if the program was started with this signal ignored. Where the system does not say so, SIGHUP counts as ignored.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let ignored = std::fs::read_to_string("/proc/self/status").ok().and_then(|status| {
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
        u64::from_str_radix(mask.trim(), 16).ok()
    });
    ignored.map_or(signal == signal_hook::consts::SIGHUP, |mask| mask >> (signal - 1) & 1 == 1)
}

#[cfg(not(unix))]
fn on_signal(mut interrupt: impl FnMut(Request) + Send + 'static) -> io::Result<()> {
    let asked = std::sync::Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(signal_hook::consts::SIGINT, asked.clone())?;
    let watch = move || {
        loop {
            std::thread::sleep(TOGETHER / 2);
            if asked.swap(false, Ordering::Relaxed) {
                interrupt(Request::Stop);
            }
        }
    };
    std::thread::Builder::new().spawn(watch).map(drop)
}
