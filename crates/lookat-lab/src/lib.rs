//! Measures lookat: numerical stability, error against time, speed. The results are in `docs/`.

pub mod against;
pub mod bench;
pub mod chart;
mod coverage;
pub mod estimate;
pub mod stability;
pub mod table;
mod text_scene;

use std::error::Error;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Prints text to standard output.
fn print(text: &str) -> Result<(), String> {
    let mut out = io::stdout();
    let printed = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    printed.map_err(|error| format!("standard output: {error}"))
}

/// The given program, or the lookat beside this program.
fn lookat_program(given: Option<&Path>) -> Result<PathBuf, Box<dyn Error>> {
    if let Some(given) = given {
        return Ok(given.into());
    }
    let path = std::env::current_exe()?.with_file_name(format!("lookat{}", std::env::consts::EXE_SUFFIX));
    let build = "build it with cargo build --release -p lookat, or name it with --lookat";
    if path.exists() { Ok(path) } else { Err(format!("{}: no lookat here: {build}", path.display()).into()) }
}

/// The seconds that a function takes, and its result.
fn timed<T>(run: impl FnOnce() -> T) -> (f64, T) {
    let started = Instant::now();
    let result = std::hint::black_box(run());
    (started.elapsed().as_secs_f64(), result)
}
