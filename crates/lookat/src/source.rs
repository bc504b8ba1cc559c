//! Loads scenes for the program: from files, or from standard input.

use std::io::Read;
use std::path::{Path, PathBuf};

use lookat_scene::syntax::Severity;
use lookat_scene::{Loaded, Overrides, load};

use crate::args::Report;

/// Loads a scene, and turns warnings into errors where that is asked for.
pub fn load_scene(path: &Path, overrides: &Overrides, report: Report) -> Loaded {
    let read = |path: &Path| if path == Path::new("-") { standard_input() } else { file(path) };
    let mut loaded = load(path, &read, overrides);
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

fn file(path: &Path) -> std::io::Result<Vec<u8>> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = std::fs::metadata(path)?.file_type();
        // Some of them never end.
        if kind.is_char_device() || kind.is_block_device() {
            return Err(std::io::Error::other("it is a device, not a file"));
        }
    }
    std::fs::read(path)
}

fn standard_input() -> std::io::Result<Vec<u8>> {
    let mut text = Vec::new();
    std::io::stdin().read_to_end(&mut text)?;
    Ok(text)
}
