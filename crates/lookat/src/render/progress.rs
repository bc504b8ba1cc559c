//! The progress of a rendering: a bar on a terminal, otherwise single lines.

use std::fmt::Write;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressState, ProgressStyle};
use lookat_render::{Progress, TimeLeft};

use crate::args::Render;
use crate::standard_error::Bar;

/// The time before the first estimate of the time left. Without a bar, a line is printed then, and again each time the
/// elapsed time doubles.
const FIRST: Duration = Duration::from_secs(1);
/// The shortest time between two updates.
const STEP: Duration = Duration::from_millis(100);

/// The progress display of a rendering.
pub struct Shown {
    is_silent: bool,
    bar: Bar,
    /// The number of pixels of the picture.
    pixels: u64,
    has_target: bool,
    time: Option<Duration>,
    state: Mutex<State>,
}

struct State {
    started: Instant,
    left: TimeLeft,
    /// The times of the next update and of the next printed line, since the start.
    next: [Duration; 2],
}

impl Shown {
    /// A display for a picture of `pixels` pixels whose rendering begins now.
    pub fn new(arguments: &Render, pixels: u64) -> Shown {
        let is_silent = arguments.quiet || arguments.report.json;
        let bar = Bar::new(is_silent, || ProgressStyle::with_template("{wide_bar} {msg}"));
        let state =
            State { started: Instant::now(), left: TimeLeft::default(), next: [Duration::ZERO, FIRST] };
        let has_target = arguments.target_error.is_some();
        Shown { is_silent, bar, pixels, has_target, time: arguments.time, state: Mutex::new(state) }
    }

    /// Updates the display, at most once per `STEP`.
    pub fn update(&self, progress: &Progress) {
        // Another thread is updating the display.
        let Ok(mut state) = self.state.try_lock() else { return };
        let elapsed = state.started.elapsed();
        if self.is_silent || elapsed < state.next[0] {
            return;
        }
        state.next[0] = elapsed + STEP;
        let mut left = state.left.update(progress);
        let mut share = progress.done as f64 / progress.total.max(1) as f64;
        if let Some(time) = self.time {
            let until = time.saturating_sub(elapsed).as_secs_f64();
            // The rendering ends early if it reaches the target error.
            let sooner = if self.has_target { left.unwrap_or([0.0, until]) } else { [until; 2] };
            left = Some(sooner.map(|seconds| seconds.min(until)));
            share = share.max(elapsed.as_secs_f64() / time.as_secs_f64()).min(1.0);
        }
        let mut text = if self.has_target {
            format!("{} of pixels done", percent(progress.pixels_done as f64 / self.pixels as f64))
        } else {
            format!("{} done", percent(share))
        };
        if elapsed >= FIRST
            && let Some(left) = left
        {
            let _ = write!(text, ", {} left", between(left));
        }
        if self.bar.is_hidden() && elapsed >= state.next[1] && left.is_some() {
            state.next[1] = 2 * elapsed;
            crate::say(&text);
        }
        self.bar.set((1000.0 * share) as u64, text);
    }

    /// Removes the bar.
    pub fn clear(&self) {
        self.bar.clear();
    }
}

fn percent(share: f64) -> String {
    // An unfinished rendering never shows 100 %.
    format!("{:.0} %", (100.0 * share).floor().min(99.0))
}

/// Units of time, and their lengths in seconds.
const UNITS: [(&str, f64); 4] = [("s", 1.0), ("min", 60.0), ("h", 3600.0), ("days", 86_400.0)];

/// An interval in seconds, rounded outwards, as in "3 to 6 min".
fn between([least, most]: [f64; 2]) -> String {
    let unit = |seconds: f64| UNITS.into_iter().rfind(|(_, size)| seconds >= 2.0 * size).unwrap_or(UNITS[0]);
    let ((small, small_size), (large, large_size)) = (unit(least), unit(most));
    let [least, most] = [(least / small_size).floor(), (most / large_size).ceil()];
    match (least, small == large) {
        (least, _) if most <= 1.0 && least < 1.0 => "less than 1 s".into(),
        (0.0, _) => format!("up to {most} {large}"),
        (least, true) if least == most => format!("{most} {large}"),
        (_, true) => format!("{least} to {most} {large}"),
        (_, false) => format!("{least} {small} to {most} {large}"),
    }
}

/// A progress bar that shows the time left.
pub fn progress_bar() -> Bar {
    Bar::new(false, || {
        let style = ProgressStyle::with_template("{wide_bar} {percent:>3} %  {left}");
        style.map(|style| style.with_key("left", time_left))
    })
}

fn time_left(state: &ProgressState, out: &mut dyn Write) {
    // Without progress, there is no estimate.
    if state.eta().as_secs() > 0 || state.pos() >= 990 {
        let _ = write!(out, "{:#} left", HumanDuration(state.eta()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_rounded_outwards() {
        for (left, expected) in [
            ([0.1, 0.6], "less than 1 s"),
            ([0.1, 1.6], "up to 2 s"),
            ([12.7, 31.2], "12 to 32 s"),
            ([4.0, 4.0], "4 s"),
            ([200.0, 359.0], "3 to 6 min"),
            ([50.0, 170.0], "50 s to 3 min"),
            ([0.5, 170.0], "up to 3 min"),
            ([3600.0, 90_000.0], "60 min to 25 h"),
            ([1e6, 1e7], "11 to 116 days"),
        ] {
            assert_eq!(between(left), expected);
        }
    }

    #[test]
    fn an_unfinished_rendering_shows_less_than_100_percent() {
        assert_eq!([0.0, 0.129, 0.9999, 1.0].map(percent), ["0 %", "12 %", "99 %", "99 %"]);
    }
}
