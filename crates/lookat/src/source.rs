//! Loads scenes from files or standard input.

use std::cell::Cell;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use bytes::Bytes;
use lookat_image::{Image, ImageError, MemoryBudget, PictureFile, open_file};
use lookat_render::{Layer, Prepared, preparation_bytes};
use lookat_scene::syntax::Severity;
use lookat_scene::{LoadCache, LoadOptions, Loaded, Scene, Stamped, load_again, load_opened};

use crate::args::{Report, way_out};
use crate::failure::Failure;

/// Loads a scene. It can be standard input or a pipe, but the files that it names cannot. With `--strict`, turns warnings into errors.
pub fn load_scene(path: &Path, options: &LoadOptions, report: Report) -> Loaded {
    let is_open = Cell::new(false);
    let open = |file: &Path| {
        // The scene file can be a pipe, as in `lookat check <(./generate)`.
        let is_scene = file == path && !is_open.replace(true);
        Ok(if is_scene && file == Path::new("-") {
            Box::new(io::stdin()) as Box<dyn Read>
        } else if is_scene && is_pipe(file) {
            Box::new(File::open(file)?)
        } else {
            Box::new(open_file(file)?)
        })
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

/// Prepares a scene for rays. Fails if there is not enough memory.
pub fn prepare(loaded: &Loaded, scene: &Scene) -> Result<Prepared, Failure> {
    match loaded.memory.reserve(preparation_bytes(&scene.world)) {
        Ok(_charge) => Ok(Prepared::new(scene)),
        Err(shortage) => {
            let message = format!("the shapes and lights are too large: {}", way_out(shortage));
            Err(Failure::TooLarge(message))
        }
    }
}

/// Replaces the samples per pixel of the scene, if given.
pub fn replace_samples(loaded: &mut Loaded, samples_per_pixel: Option<u32>) {
    if let (Some(scene), Some(samples)) = (&mut loaded.scene, samples_per_pixel) {
        scene.view.sampler = scene.view.sampler.with_samples(samples);
    }
}

/// Reads a picture and charges it for good.
pub fn read_image(file: &Path, memory: &MemoryBudget) -> Result<Image, Failure> {
    let read = PictureFile::open(file, memory).and_then(PictureFile::read);
    let (image, charge) = read?;
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

/// The message about a picture without colors, or about the chosen layer: which of its channels to choose.
pub fn several_channels(file: &Path, image: &Image, layer: Option<&str>) -> String {
    let file = file.display();
    let own = |layer: &str| {
        let prefix = Layer::named(layer).map_or(layer.into(), |layer| layer.name_in_file().to_owned()) + ".";
        image.layers.iter().filter(|name| name.starts_with(&prefix)).cloned().collect::<Vec<_>>()
    };
    let (what, names) = match layer.map(|layer| (layer, own(layer))) {
        Some((layer, names)) if !names.is_empty() => {
            (format!("{file}: layer {layer} has several channels"), names)
        }
        _ => (format!("{file} has several layers"), image.layers.clone()),
    };
    format!("{what}; choose one with --layer: {}", names.join(", "))
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
