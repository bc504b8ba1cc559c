//! Loads scenes from files or standard input.

use std::cell::Cell;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use bytes::Bytes;
use lookat_image::{Image, ImageError, MemoryBudget, PictureFile, open_file};
use lookat_render::Layer;
use lookat_scene::syntax::Severity;
use lookat_scene::{LoadCache, LoadOptions, Loaded, Stamped, load_again, load_opened};

use crate::args::Report;

/// Loads a scene. It can be standard input or a pipe, but the files that it names cannot. With `--strict`, turns warnings into errors.
pub fn load_scene(path: &Path, options: &LoadOptions, report: Report) -> Loaded {
    let is_open = Cell::new(false);
    let open = |file: &Path| match file == path && !is_open.replace(true) {
        true if file == Path::new("-") => Ok(Box::new(io::stdin()) as Box<dyn Read>),
        true => open_scene(file),
        false => Ok(Box::new(open_file(file)?) as Box<dyn Read>),
    };
    let mut loaded = load_opened(path, &open, options);
    // Show `-` under a readable name.
    if let Some(first) = loaded.sources.files.first_mut()
        && first.path == Path::new("-")
    {
        first.path = PathBuf::from("standard input");
    }
    with_strictness(loaded, options, report)
}

/// The text to read in place of a file.
pub type Instead<'a> = dyn Fn(&Path) -> Option<Bytes> + 'a;

/// Loads a scene that is read again when its files change: it cannot be a pipe. Calls `instead` with each file before reading it, also
/// with one that is missing. Takes over what the cache has.
pub fn load_watched(
    path: &Path,
    options: &LoadOptions,
    report: Report,
    instead: &Instead,
    cache: Option<(&mut LoadCache, &Stamped)>,
) -> Loaded {
    let open = |file: &Path| match instead(file) {
        Some(text) => Ok(Box::new(io::Cursor::new(text)) as Box<dyn Read>),
        None => Ok(Box::new(open_file(file)?) as Box<dyn Read>),
    };
    let loaded = match cache {
        Some((cache, stamp)) => load_again(path, &open, cache, stamp, options),
        None => load_opened(path, &open, options),
    };
    with_strictness(loaded, options, report)
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

/// Opens a layer of an EXR file by its name in the file, or by its name in `render --layers`.
pub fn open_layer<'a>(file: &Path, name: &str, memory: &MemoryBudget) -> Result<PictureFile<'a>, ImageError> {
    PictureFile::open_layer(file, name, memory).or_else(|error| {
        let rendered = Layer::named(name).map(Layer::name_in_file);
        let opened = rendered.map(|name| PictureFile::open_layer(file, name, memory));
        opened.and_then(Result::ok).ok_or(error)
    })
}

/// Turns warnings into errors with `--strict`.
fn with_strictness(mut loaded: Loaded, options: &LoadOptions, report: Report) -> Loaded {
    let mut warnings = 0;
    let is_counted = |severity: Severity| report.strict && severity == Severity::Warning;
    for warning in loaded.diagnostics.iter_mut().filter(|told| is_counted(told.severity)) {
        warning.severity = Severity::Error;
        warnings += 1;
    }
    if warnings > 0 && !options.keep_going {
        // If all errors are warnings, --keep-going would skip nothing.
        loaded.can_keep_going &= loaded.scene.take().is_none();
    }
    loaded
}

/// Opens a scene file. It can be a pipe, as in `lookat check <(./generate)`.
fn open_scene(path: &Path) -> io::Result<Box<dyn Read>> {
    match is_pipe(path) {
        true => Ok(Box::new(File::open(path)?)),
        false => Ok(Box::new(open_file(path)?)),
    }
}

/// True for standard input and a pipe: what has been read is gone.
pub fn is_read_once(scene: &Path) -> bool {
    scene == Path::new("-") || is_pipe(scene)
}

#[cfg(unix)]
fn is_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;

    std::fs::metadata(path).is_ok_and(|found| found.file_type().is_fifo())
}

#[cfg(not(unix))]
fn is_pipe(_: &Path) -> bool {
    false
}
