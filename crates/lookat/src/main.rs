//! The program `lookat`. See its `--help`, and README.md.

mod args;
mod check;
mod render;
mod report;
mod source;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    match args::Arguments::parse().command {
        args::Command::Render(arguments) => render::render(&arguments),
        args::Command::Check(arguments) => check::check(&arguments),
    }
}

/// One line of JSON on standard output.
fn print_json(value: &impl serde::Serialize) {
    if let Ok(line) = serde_json::to_string(value) {
        // The reader may have gone; there is nobody to tell.
        let _ = writeln!(std::io::stdout(), "{line}");
    }
}

/// Trouble that is not in a scene file.
fn complain(message: &str) {
    anstream::eprintln!("error: {message}");
}
