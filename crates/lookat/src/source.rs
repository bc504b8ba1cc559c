//! Loads scenes from files or standard input.

use std::cell::Cell;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use bytes::Bytes;
use lookat_image::{Image, MemoryBudget, PictureFile, open_file};
use lookat_scene::syntax::Severity;
use lookat_scene::{LoadCache, LoadOptions, Loaded, Stamped, load_again, load_opened};

use crate::args::Report;

/// Loads a scene. With `--strict`, turns warnings into errors.
pub fn load_scene(path: &Path, options: &LoadOptions, report: Report) -> Loaded {
    load_instead(path, options, report, &|_| None, None)
}

/// The text to read in place of a file.
pub type Instead<'a> = dyn Fn(&Path) -> Option<Bytes> + 'a;

/// The same. Calls `instead` with each file before reading it, also with one that is missing. Takes over what the cache has.
pub fn load_instead(
    path: &Path,
    options: &LoadOptions,
    report: Report,
    instead: &Instead,
    cache: Option<(&mut LoadCache, &Stamped)>,
) -> Loaded {
    let is_open = Cell::new(false);
    // Only the scene itself can be standard input or a pipe, not a file that it names.
    let open = |file: &Path| {
        if let Some(text) = instead(file) {
            return Ok(Box::new(io::Cursor::new(text)) as Box<dyn Read>);
        }
        match file == path && !is_open.replace(true) {
            true if file == Path::new("-") => Ok(Box::new(io::stdin()) as Box<dyn Read>),
            true => open_scene(file),
            false => Ok(Box::new(open_file(file)?) as Box<dyn Read>),
        }
    };
    let mut loaded = match cache {
        Some(cache) => load_again(path, &open, cache, options),
        None => load_opened(path, &open, options),
    };
    // Show `-` under a readable name.
    if let Some(first) = loaded.sources.files.first_mut()
        && first.path == Path::new("-")
    {
        first.path = PathBuf::from("standard input");
    }
    if report.strict {
        fail_warnings(&mut loaded, options.keep_going);
    }
    loaded
}

/// Replaces the samples per pixel of the scene, if given.
pub fn replace_samples(loaded: &mut Loaded, samples_per_pixel: Option<u32>) {
    if let (Some(scene), Some(samples)) = (&mut loaded.scene, samples_per_pixel) {
        scene.view.sampler = scene.view.sampler.with_samples(samples);
    }
}

/// Reads a picture and charges it for good.
pub fn read_image(file: &Path, memory: &MemoryBudget) -> Result<Image, String> {
    let read = PictureFile::open(file, memory).and_then(PictureFile::read);
    let (image, charge) = read.map_err(|error| error.to_string())?;
    charge.keep();
    Ok(image)
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

/// Opens a scene file. It can be a pipe, as in `lookat check <(./generate)`.
fn open_scene(path: &Path) -> io::Result<Box<dyn Read>> {
    #[cfg(unix)]
    if std::os::unix::fs::FileTypeExt::is_fifo(&std::fs::metadata(path)?.file_type()) {
        return Ok(Box::new(File::open(path)?));
    }
    Ok(Box::new(open_file(path)?))
}
