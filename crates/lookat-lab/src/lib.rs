//! Measures lookat: numerical stability, error against time, speed. The results are in `docs/`.

pub mod against;
pub mod bench;
pub mod chart;
mod coverage;
pub mod estimate;
pub mod stability;
mod text_scene;

use std::io::Write;
use std::path::{Path, PathBuf};

/// Prints text to standard output.
fn print(text: &str) -> Result<(), String> {
    let mut out = std::io::stdout();
    out.write_all(text.as_bytes())
        .and_then(|()| out.flush())
        .map_err(|error| format!("standard output: {error}"))
}

/// The given program, or the lookat beside this program.
fn lookat_program(given: Option<&Path>) -> Result<PathBuf, String> {
    if let Some(given) = given {
        return Ok(given.into());
    }
    let own = std::env::current_exe().map_err(|error| error.to_string())?;
    let path = own.with_file_name(format!("lookat{}", std::env::consts::EXE_SUFFIX));
    let build = "build it with cargo build --release -p lookat, or name it with --lookat";
    path.exists().then_some(path.clone()).ok_or(format!("{}: no lookat here: {build}", path.display()))
}
