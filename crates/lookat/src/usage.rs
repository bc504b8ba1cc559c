//! Prints help, and what is wrong with a command line.

mod tips;

use std::io::ErrorKind;
use std::process::ExitCode;

use clap::Error;

use crate::visible::visible;
use tips::one_dash_of_render;

/// Prints help, or the error of the command line.
pub fn explain(error: Error) -> ExitCode {
    let typed = typed();
    let error = if error.use_stderr() { tips::with_tips(error, &typed) } else { error };
    ExitCode::from(match error.print() {
        // The help could not be written. A closed pipe is fine, because nobody reads it.
        Err(trouble) if trouble.kind() != ErrorKind::BrokenPipe => crate::lost(),
        _ if error.use_stderr() => crate::TROUBLE,
        _ => 0,
    })
}

/// A tip about an option of `render` that is typed with one dash, to end a message.
pub fn tip_for_render() -> String {
    one_dash_of_render(&typed()[1..]).map_or(String::new(), |tip| format!("; tip: {tip}"))
}

fn typed() -> Vec<String> {
    std::env::args_os().map(|typed| visible(&typed.to_string_lossy())).collect()
}
