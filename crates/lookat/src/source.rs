//! Loads scenes from files or standard input.

use std::cell::Cell;
use std::fs::File;
use std::io::{ErrorKind, Read, Result};
use std::path::{Path, PathBuf};

use lookat_scene::syntax::Severity;
use lookat_scene::{Loaded, Overrides, load_opened};

use crate::args::Report;

/// Loads a scene. With `--strict`, turns warnings into errors.
pub fn load_scene(path: &Path, overrides: &Overrides, report: Report) -> Loaded {
    let begun = Cell::new(false);
    // Only the scene itself can be standard input, not a file that it names.
    let open = |file: &Path| match file == Path::new("-") && file == path && !begun.replace(true) {
        true => Ok(Box::new(std::io::stdin()) as Box<dyn Read>),
        false => open(file),
    };
    let mut loaded = load_opened(path, &open, overrides);
    // Show `-` under a readable name.
    if let Some(first) = loaded.sources.files.first_mut()
        && first.path == Path::new("-")
    {
        first.path = PathBuf::from("standard input");
    }
    if report.strict {
        fail_warnings(&mut loaded, overrides.keep_going);
    }
    loaded
}

/// Turns warnings into errors.
fn fail_warnings(loaded: &mut Loaded, keep_going: bool) {
    let mut warnings = 0;
    for warning in loaded.diagnostics.iter_mut().filter(|told| told.severity == Severity::Warning) {
        warning.severity = Severity::Error;
        warnings += 1;
    }
    if warnings > 0 && !keep_going {
        // If all errors are warnings, --keep-going would skip nothing.
        loaded.can_keep_going &= loaded.scene.take().is_none();
    }
}

/// Opens a file.
fn open(path: &Path) -> Result<Box<dyn Read>> {
    let kind = std::fs::metadata(path)?.file_type();
    if kind.is_dir() {
        return Err(ErrorKind::IsADirectory.into());
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        // Some devices never end.
        if kind.is_char_device() || kind.is_block_device() {
            return Err(std::io::Error::other("it is a device, not a file"));
        }
    }
    Ok(Box::new(File::open(path)?))
}
