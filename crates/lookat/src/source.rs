//! Loads scenes for the program: from files, or from standard input.

use std::cell::Cell;
use std::fs::File;
use std::io::{ErrorKind, Read, Result};
use std::path::{Path, PathBuf};

use lookat_scene::syntax::Severity;
use lookat_scene::{Loaded, Overrides, load_opened};

use crate::args::Report;

/// Loads a scene, and turns warnings into errors where that is asked for.
pub fn load_scene(path: &Path, overrides: &Overrides, report: Report) -> Loaded {
    let begun = Cell::new(false);
    // Standard input is the scene alone, not what a file in it names.
    let open = |file: &Path| match file == Path::new("-") && file == path && !begun.replace(true) {
        true => Ok(Box::new(std::io::stdin()) as Box<dyn Read>),
        false => open(file),
    };
    let mut loaded = load_opened(path, &open, overrides);
    // People know standard input by another name.
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
        // Where all were warnings, nothing has to be left out.
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
        // Some of them never end.
        if kind.is_char_device() || kind.is_block_device() {
            return Err(std::io::Error::other("it is a device, not a file"));
        }
    }
    Ok(Box::new(File::open(path)?))
}
