//! Loads a scene: reads files, follows `Include`, and passes every directive to the resolver.

use std::cell::RefCell;
use std::collections::{BTreeSet, HashMap};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bytes::Bytes;
use lookat_image::{Charge, MemoryBudget, byte_words, io_reason};
use lookat_syntax::{
    Diagnostic, Directive, EntityKind, FileId, Param, Parsed, Parser, Span, Statement, Text, Values,
    number_bytes,
};

use crate::advice::{Summary, advise};
use crate::cache::{LoadCache, Reuse, Stamped};
use crate::facts::Block;
use crate::files::content::other_format;
use crate::files::{Access, Files, Open, Read};
use crate::film::DEFAULT_OUTPUT;
use crate::options::LoadOptions;
use crate::resolve::{Resolver, home_block};
use crate::symbols::SymbolKind;
use crate::{CameraPlacement, Places, Scene, Sources, Symbol};

/// The most included files. A scene with more includes files in a loop.
const MAX_INCLUDES: usize = 10_000;
/// The greatest depth of nested includes.
const MAX_DEPTH: usize = 100;
/// The most bytes of repeated includes, counting every inclusion after the first.
const MAX_REPEATED: u64 = 4 << 30;
/// The most directives in memory at a time, per file.
const BLOCK: usize = 16;
/// The bytes that a directive adds to this count, because a short directive can create a shape.
const DIRECTIVE_BYTES: usize = 512;

/// Loads a scene and all the files that it names through `read`.
///
/// A file name is relative to the file that contains it, or else to the scene file.
pub fn load(path: &Path, read: &Read, options: &LoadOptions) -> Loaded {
    load_through(Access::Read(read), path, options, None)
}

/// Loads a scene from its text alone: files that it names are missing.
///
/// ```
/// let loaded = lookat_scene::load_str("Camera \"perspective\" WorldBegin Shape \"sphere\" WorldEnd");
/// assert_eq!(loaded.scene.unwrap().world.primitives.len(), 1);
/// ```
pub fn load_str(text: &str) -> Loaded {
    const NAME: &str = "scene.pbrt";
    let read =
        |path: &Path| if path == Path::new(NAME) { Ok(text.into()) } else { Err(ErrorKind::NotFound.into()) };
    load(Path::new(NAME), &read, &LoadOptions::default())
}

/// Like [`load`], but opens files on disk. It streams PLY files, and lists folders to suggest a name for a missing
/// file.
pub fn load_opened(path: &Path, open: &Open, options: &LoadOptions) -> Loaded {
    load_through(Access::Open(open), path, options, None)
}

/// Like [`load_opened`], but takes over what the last load without errors has read, and keeps what this one reads. The result is the
/// same.
pub fn load_again(
    path: &Path,
    open: &Open,
    cache: &mut LoadCache,
    stamp: &Stamped,
    options: &LoadOptions,
) -> Loaded {
    let new = cache.kept.next();
    let reuse = Reuse { stamp, old: &cache.kept, new: &new };
    let loaded = load_through(Access::Open(open), path, options, Some(reuse));
    if loaded.scene.is_some() {
        cache.kept = new.into_inner();
    }
    loaded
}

fn load_through(access: Access, path: &Path, options: &LoadOptions, reuse: Option<Reuse>) -> Loaded {
    let memory = options.max_memory.map_or_else(MemoryBudget::default, MemoryBudget::new);
    let mut loader = Loader {
        resolver: Resolver::new(Files::new(path, access, memory, reuse), options),
        open: Vec::new(),
        texts: HashMap::new(),
        repeated: 0,
    };
    match loader.resolver.files.open(path.to_owned(), None) {
        Ok(file) => {
            if let Some(format) = other_format(&loader.resolver.files.sources.file(file).text) {
                let at = Span { file, start: 0, end: 0 };
                let message = format!("{} is not a pbrt scene: it is {format}", path.display());
                let diagnostics = vec![Diagnostic::error(at, message)];
                let mut files = loader.resolver.files;
                // Binary contents are never shown.
                files.sources.files[0].text = Bytes::new();
                return nothing(files, diagnostics);
            }
            loader.file(file, Vec::new());
            loader.resolver.finish(file);
            conclude(loader.resolver, file, options)
        }
        Err(error) => {
            let file = loader.resolver.files.add(path.to_owned(), Bytes::new(), None);
            let at = Span { file, start: 0, end: 0 };
            let message = format!("cannot read {}: {}", path.display(), io_reason(&error));
            let mut diagnostic = Diagnostic::error(at, message);
            diagnostic.help = match error.kind() {
                ErrorKind::NotFound => {
                    loader.resolver.files.meant_scene(path).map(|meant| format!("did you mean {meant}?"))
                }
                ErrorKind::IsADirectory => {
                    Some(format!("name its files, as in {}", path.join("*.pbrt").display()))
                }
                _ => None,
            };
            nothing(loader.resolver.files, vec![diagnostic])
        }
    }
}

/// Runs the advice, and returns the scene.
fn conclude(resolver: Resolver, file: FileId, options: &LoadOptions) -> Loaded {
    let Resolver { files, mut report, facts, resolved, draft, .. } = resolver;
    let built = draft.build();
    let symbols = std::mem::take(&mut report.symbols);
    let summary = Summary {
        facts: &facts,
        symbols: &symbols,
        resolved: resolved.as_ref(),
        built: &built,
        drawn: built.world.shapes().filter(|primitive| !primitive.shape.is_invisible()).collect(),
        sources: &files.sources,
        end: files.sources.end(file),
        accept_part: options.accept_part,
    };
    advise(&summary, &mut report);
    report.symbols = symbols;
    let override_error = report.override_error.take();
    let can_keep_going =
        resolved.is_some() && !report.is_v4(&files.sources) && override_error.is_none() && !report.exhausted;
    let keeps_going = options.keep_going && !report.exhausted;
    let is_whole = (!report.has_errors() || keeps_going) && override_error.is_none() && !options.fast;
    let output = resolved.as_ref().map_or(DEFAULT_OUTPUT.into(), |resolved| resolved.output.clone());
    let mut places = resolved.as_ref().map(|resolved| resolved.places.clone()).unwrap_or_default();
    places.lights = facts.lights;
    let scene = resolved.filter(|_| is_whole);
    let scene = scene.map(|resolved| Scene { view: resolved.view, world: Arc::new(built.world) });
    let (diagnostics, symbols) = report.finish(&files.sources);
    Loaded {
        scene,
        places,
        output,
        symbols,
        unread: built.unread,
        can_keep_going,
        placement: options.view.placement().or(facts.placement),
        world_follows_camera: facts.uses_camera_space,
        override_error,
        ..nothing(files, diagnostics)
    }
}

/// The name of the picture of a texture.
fn picture_name(statement: &Statement) -> Option<&Text> {
    let Directive::Texture { entity, .. } = &statement.directive else { return None };
    let params = entity.params.iter().filter(|_| entity.name.value == "imagemap");
    params.filter(|param| param.name.value == "filename").find_map(|param| match &param.values.value {
        Values::Strings(names) => names.first(),
        _ => None,
    })
}

/// The result for a file that is not a scene.
fn nothing(files: Files, diagnostics: Vec<Diagnostic>) -> Loaded {
    let (sources, inputs, memory) = files.into_parts();
    Loaded { sources, inputs, memory, output: DEFAULT_OUTPUT.into(), diagnostics, ..Loaded::default() }
}

struct Loader<'a> {
    resolver: Resolver<'a>,
    /// The chain of open files, each included by its predecessor.
    open: Vec<PathBuf>,
    /// The texts of included files. A file that is included often is stored once.
    texts: HashMap<PathBuf, Bytes>,
    /// The bytes of repeated includes so far, including `DIRECTIVE_BYTES`.
    repeated: u64,
}

impl Loader<'_> {
    /// Resolves a file block by block and returns the number of its directives. `rest` is appended to its last directive.
    fn file(&mut self, id: FileId, mut rest: Vec<Param>) -> usize {
        let files = &self.resolver.files;
        let (memory, reuse) = (files.memory.clone(), files.reuse);
        let source = files.sources.file(id);
        let (path, text) = (source.path.clone(), source.text.clone());
        let mut room = Room::new(&text);
        self.open.push(path.clone());
        if let [_] = self.open[..]
            && let Some((block, first)) = part(id, &text, room.left(&memory))
        {
            self.resolver.begin_part(block, first);
        }
        let known = reuse.map(|reuse| RefCell::new(reuse.keep_text(&path, text.clone())));
        let mut find = |ty, at| known.as_ref()?.borrow_mut().find(ty, at);
        let mut parser = Parser::new(id, &text, &mut find);
        let mut directives = 0;
        while let Some(mut parsed) = parser.next_block(BLOCK, room.left(&memory)) {
            // Never more than there is room for.
            let _ = memory.reserve(parsed.bytes).map(Charge::keep);
            if let (Some(reuse), Some(known)) = (reuse, &known) {
                reuse.keep_lists(&path, &known.borrow(), std::mem::take(&mut parsed.lists));
            }
            self.report(&mut parsed);
            if parsed.is_last && !rest.is_empty() {
                self.append(std::mem::take(&mut rest), parsed.statements.last_mut());
            }
            directives += parsed.statements.len();
            self.resolver.draft.pictures.expect(parsed.statements.iter().filter_map(picture_name));
            for mut statement in parsed.statements {
                let is_shape = matches!(statement.directive, Directive::Entity(EntityKind::Shape, _));
                if let Some(params) = statement.directive.params_mut().filter(|_| !is_shape) {
                    self.resolver.files.read_lists(params);
                }
                match statement.directive {
                    Directive::Include { file, rest } => self.include(file, rest, statement.span),
                    directive => self.resolver.apply(Statement { directive, ..statement }),
                }
            }
        }
        self.open.pop();
        directives
    }

    /// Reports what was found while a block was parsed.
    fn report(&mut self, parsed: &mut Parsed) {
        let Resolver { report, files, draft, .. } = &mut self.resolver;
        if let Some(at) = parsed.exhausted {
            let most = byte_words(files.memory.limit());
            let message =
                format!("the scene is too large: up to here, it fills the memory limit, which is {most}");
            let copies = if draft.world.instances.is_empty() { ", and copies as ObjectInstance" } else { "" };
            let help = format!("raise the limit, or write large meshes as plymesh{copies}");
            report.push(Diagnostic::error(at, message).help(help));
            (report.incomplete, report.exhausted) = (true, true);
        }
        report.extend(std::mem::take(&mut parsed.diagnostics));
        report.v4_marks(std::mem::take(&mut parsed.v4_marks));
        report.incomplete_end |= parsed.broken_end;
        report.incomplete |= parsed.lost_include;
    }

    /// Appends the parameters after an Include to the last directive of the file.
    fn append(&mut self, rest: Vec<Param>, last: Option<&mut Statement>) {
        match last.and_then(|last| last.directive.params_mut()) {
            Some(params) => params.extend(rest),
            None => self.resolver.report.extend(rest.first().map(|first| {
                Diagnostic::error(first.span(), "these parameters belong to no directive").help(
                    "parameters after an Include belong to the last directive of the included file, which takes no parameters",
                )
            })),
        }
    }

    /// The error for an `Include` beyond the limits.
    fn refused(&self, at: Span) -> Option<Diagnostic> {
        if self.resolver.files.sources.files.len() > MAX_INCLUDES {
            return Some(Diagnostic::error(at, format!("the scene includes more than {MAX_INCLUDES} files")));
        }
        if self.repeated > MAX_REPEATED {
            let error = Diagnostic::error(at, "repeated includes add up to more than 4 GiB");
            return Some(error.help("to repeat shapes, use ObjectBegin and ObjectInstance"));
        }
        let message = || Diagnostic::error(at, format!("more than {MAX_DEPTH} nested includes"));
        (self.open.len() >= MAX_DEPTH).then(message)
    }

    fn include(&mut self, name: Text, rest: Vec<Param>, at: Span) {
        if let Some(error) = self.refused(name.span) {
            return self.resolver.report.push(error);
        }
        let (path, bytes) = match self.resolver.files.text_named(&name.value, name.span) {
            Ok(found) => found,
            Err((path, error)) => {
                let error = self.resolver.files.unreadable("include", &name, &path, &error);
                self.resolver.report.push(error);
                self.resolver.report.symbols.use_undefined(SymbolKind::Include, &name);
                self.resolver.report.incomplete = true;
                return;
            }
        };
        self.resolver.report.extend(self.resolver.files.not_found_by_pbrt(&name, &path));
        if let Some(from) = self.open.iter().position(|open| *open == path) {
            let chain: Vec<String> =
                self.open[from..].iter().map(|path| path.display().to_string()).collect();
            let message = format!("{} includes itself", path.display());
            let help = format!("the chain of includes is {} -> {}", chain.join(" -> "), path.display());
            self.resolver.report.push(Diagnostic::error(name.span, message).help(help));
            return;
        }
        let is_repeated = self.texts.contains_key(&path);
        let text = self.texts.entry(path.clone()).or_insert_with(|| bytes.keep()).clone();
        if let Some(format) = other_format(&text) {
            let message = format!("cannot include {}: it is {format}", path.display());
            self.resolver.report.push(Diagnostic::error(name.span, message));
            self.resolver.report.incomplete = true;
            return;
        }
        let length = text.len();
        let shown = path.display().to_string();
        let file = self.resolver.files.add(path, text, Some(at));
        let start = Span { file, start: 0, end: 0 };
        self.resolver.report.symbols.include(shown, start, name.span);
        let directives = self.file(file, rest);
        if is_repeated {
            self.repeated += (length + directives * DIRECTIVE_BYTES) as u64;
        }
    }
}

/// The memory for the statements of a text besides its numbers.
struct Room<'a> {
    text: &'a [u8],
    /// The most bytes of the numbers of one block.
    numbers: u64,
    is_counted: bool,
}

impl<'a> Room<'a> {
    fn new(text: &'a [u8]) -> Self {
        // Each `0 ` becomes eight bytes. Counting the numbers takes longer and is rarely needed.
        Room { text, numbers: 4 * text.len() as u64, is_counted: false }
    }

    fn left(&mut self, memory: &MemoryBudget) -> u64 {
        if !self.is_counted && 2 * self.numbers > memory.left() {
            (self.numbers, self.is_counted) = (number_bytes(self.text), true);
        }
        memory.left().saturating_sub(self.numbers)
    }
}

/// The block in which other files include this file, the world or the options, and its first directive. `None` for a scene, of
/// which this reads the start alone.
fn part(id: FileId, text: &[u8], most_bytes: u64) -> Option<(Block, Span)> {
    let mut nothing_known = |_, _| None;
    let mut parser = Parser::new(id, text, &mut nothing_known);
    let (mut first, mut has_options, mut has_world, mut has_look_at) = (None, false, false, false);
    while let Some(parsed) = parser.next_block(1, most_bytes) {
        for Statement { directive, keyword, .. } in parsed.statements {
            first.get_or_insert(keyword);
            match directive {
                Directive::WorldBegin | Directive::WorldEnd => return None,
                // It may contain the missing directives.
                Directive::Include { .. } if !has_world => return None,
                Directive::LookAt(_) => has_look_at = true,
                _ => {}
            }
            let home = home_block(&directive);
            has_options |= home == Some(Block::Options);
            has_world |= home == Some(Block::World);
            if has_world && (has_options || has_look_at) {
                return None;
            }
        }
    }
    let block = if has_world { Block::World } else { Block::Options };
    first.filter(|_| has_world || has_options).map(|first| (block, first))
}

/// The result of [`load`](crate::load()).
#[derive(Debug, Default)]
pub struct Loaded {
    /// The texts that diagnostics refer to.
    pub sources: Sources,
    /// All files read: scene text, pictures, meshes and spectra.
    pub inputs: BTreeSet<PathBuf>,
    /// The scene. `None` if there is a `override_error`, if there are errors without `keep_going`, if the text does not fit the memory limit, with
    /// `fast`, or if no scene could be built at all.
    pub scene: Option<Scene>,
    /// Where the text says how the scene is seen and lit.
    pub places: Places,
    /// The file that the scene names for its picture (`filename` of `Film`), relative to the working folder. Default:
    /// `pbrt.exr`.
    pub output: PathBuf,
    /// The problems, in reading order.
    pub diagnostics: Vec<Diagnostic>,
    /// Materials, textures, objects, media, coordinate systems and included files, in the order of their definition or,
    /// if undefined, of their first use.
    pub symbols: Vec<Symbol>,
    /// The memory budget that is left after reading.
    pub memory: MemoryBudget,
    /// With [`fast`](crate::LoadOptions::fast), the number of uses of mesh and picture files whose contents were not read;
    /// otherwise 0.
    pub unread: usize,
    /// True if `keep_going` would give a scene.
    pub can_keep_going: bool,
    /// The `LookAt` that places the camera. `None` for a camera that is placed otherwise.
    pub placement: Option<CameraPlacement>,
    /// True if the world uses the coordinate system of the camera.
    pub world_follows_camera: bool,
    /// The reason why the [`FilmOverride`](crate::FilmOverride) or the [`ViewOverride`](crate::ViewOverride) does not fit
    /// the scene.
    pub override_error: Option<String>,
}
