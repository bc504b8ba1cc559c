//! The program `lookat-lab`: measures lookat.

use std::process::ExitCode;

use clap::Parser;
use lookat_lab::against::Against;
use lookat_lab::bench::Bench;

#[derive(Parser)]
#[command(
    version,
    about = "Measures lookat",
    after_help = "Exit status: 0 success; 1 failure; 2 wrong usage"
)]
enum Command {
    /// Measure the speed of lookat on this machine
    Bench(Bench),
    /// Compare lookat with pbrt-v3 over scenes that resemble public files: squared error at equal samples, and time to equal error.
    /// Both programs run as whole processes on one thread, in turn. Prints a table in Markdown and writes FOLDER/against.csv
    Against(Against),
}

fn main() -> ExitCode {
    lookat_render::start_threads(std::thread::available_parallelism().map_or(1, usize::from));
    let result = match Command::parse() {
        Command::Bench(bench) => bench.run(),
        Command::Against(against) => against.run(),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}
