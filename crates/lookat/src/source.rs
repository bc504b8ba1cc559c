//! Loads scenes from files or standard input, and finds and changes directives in their text.

use std::cell::Cell;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use bytes::Bytes;
use lookat_image::{Image, ImageError, MemoryBudget, PictureFile, open_file};
use lookat_render::Layer;
use lookat_scene::syntax::{
    Directive, Entity, EntityKind, Fix, Param, ParamType, Severity, Span, Values, statement_at, value_span,
};
use lookat_scene::{LoadCache, LoadOptions, Loaded, Sources, Stamped, load_again, load_opened};

use crate::args::Report;
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

pub struct DirectiveText<'s> {
    text: &'s [u8],
    pub kind: EntityKind,
    pub entity: Entity,
}

impl<'s> DirectiveText<'s> {
    /// The directive around a place. `None` if there is none, or one without parameters.
    pub fn at(sources: &'s Sources, place: Span) -> Option<DirectiveText<'s>> {
        let text = &sources.files.get(place.file.0 as usize)?.text[..];
        match statement_at(text, place)?.directive {
            Directive::Entity(kind, entity) => Some(DirectiveText { text, kind, entity }),
            _ => None,
        }
    }

    /// The parameter of this name that counts.
    pub fn param(&self, name: &str) -> Option<&Param> {
        self.entity.params.iter().rev().find(|param| param.name.value == name)
    }

    /// The changes that give a parameter these values, as words of the text. In a list of the same type, only the words that differ
    /// change.
    pub fn set(&self, ty: ParamType, name: &str, words: &[String]) -> Vec<Fix> {
        let list = if let [word] = words { word.clone() } else { format!("[{}]", words.join(" ")) };
        let replacement = format!("\"{} {name}\" {list}", ty.name());
        match self.param(name) {
            Some(param) if param.ty == ty && count(&param.values.value) == words.len() => {
                words.iter().enumerate().filter_map(|(at, word)| self.replace(param, at, word)).collect()
            }
            Some(param) => vec![Fix { span: param.span(), replacement }],
            None => {
                let last = self.entity.params.last().map_or(self.entity.name.span, Param::span);
                let span = Span { start: last.end, ..last };
                vec![Fix { span, replacement: format!(" {replacement}") }]
            }
        }
    }

    /// The change of a value, if it differs.
    fn replace(&self, param: &Param, at: usize, word: &str) -> Option<Fix> {
        let span = value_span(self.text, param.values.span, at);
        let before = std::str::from_utf8(&self.text[span.start as usize..span.end as usize]).ok()?;
        let number = |word: &str| word.parse::<f64>().ok();
        let is_same = before == word || number(before).is_some_and(|before| number(word) == Some(before));
        (!is_same).then(|| Fix { span, replacement: word.to_owned() })
    }
}

/// The words of a list of values.
fn count(values: &Values) -> usize {
    let each = match values {
        Values::Pairs(_) => 2,
        Values::Triples(_) => 3,
        _ => 1,
    };
    each * values.len()
}
