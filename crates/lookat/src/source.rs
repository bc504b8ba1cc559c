//! Loads scenes for the program: from files, or from standard input.

use std::fs::File;
use std::io::{ErrorKind, Read, Result};
use std::path::{Path, PathBuf};

use lookat_scene::syntax::Severity;
use lookat_scene::{Loaded, Overrides, load_opened};

use crate::args::Report;

/// Loads a scene, and turns warnings into errors where that is asked for.
pub fn load_scene(path: &Path, overrides: &Overrides, report: Report) -> Loaded {
    let mut loaded = load_opened(path, &open, overrides);
    // People know standard input by another name.
    if let Some(first) = loaded.sources.files.first_mut()
        && first.path == Path::new("-")
    {
        first.path = PathBuf::from("standard input");
    }
    if report.strict && !loaded.diagnostics.is_empty() {
        loaded.diagnostics.iter_mut().for_each(|diagnostic| diagnostic.severity = Severity::Error);
        if !report.keep_going {
            loaded.scene = None;
        }
    }
    loaded
}

/// Opens a file; `-` is standard input.
fn open(path: &Path) -> Result<Box<dyn Read>> {
    if path == Path::new("-") {
        return Ok(Box::new(std::io::stdin()));
    }
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
