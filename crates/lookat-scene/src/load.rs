//! Loads a scene: reads files, follows `Include`, and passes every directive to the resolver.

use std::collections::HashMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bytes::Bytes;
use lookat_image::{Charge, MemoryBudget, byte_words, io_reason};
use lookat_syntax::{
    Diagnostic, Directive, EntityKind, FileId, Param, Span, Statement, Text, number_bytes, parse_again,
};

use crate::advice::{Evidence, advise};
use crate::cache::{LoadCache, Reuse, Stamped};
use crate::facts::Block;
use crate::files::{Access, Files, Open, Read, other_format};
use crate::film::DEFAULT_OUTPUT;
use crate::load_options::LoadOptions;
use crate::loaded::Loaded;
use crate::resolve::{Resolver, home_block};
use crate::symbols::SymbolKind;
use crate::{Places, Scene};

/// The most included files. A scene with more includes files in a loop.
const MAX_INCLUDES: usize = 10_000;
/// The greatest depth of nested includes.
const MAX_DEPTH: usize = 100;
/// The most bytes of repeated includes, counting every inclusion after the first.
const MAX_REPEATED: u64 = 4 << 30;
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
    let read = |path: &Path| match path == Path::new(NAME) {
        true => Ok(text.into()),
        false => Err(ErrorKind::NotFound.into()),
    };
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
    (cache, stamp): (&mut LoadCache, &Stamped),
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
                return nothing(loader.resolver.files.without_texts(), diagnostics);
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
                    Some("to render all scenes of a folder, use `lookat verify`".into())
                }
                _ => None,
            };
            nothing(loader.resolver.files, vec![diagnostic])
        }
    }
}

/// Loads meshes and pictures, runs the advice, and returns the scene.
fn conclude(resolver: Resolver, file: FileId, options: &LoadOptions) -> Loaded {
    let Resolver { files, mut report, facts, settled, draft, .. } = resolver;
    let built = draft.load(options.fast, &files, &mut report);
    let symbols = std::mem::take(&mut report.symbols);
    let evidence = Evidence {
        facts: &facts,
        symbols: &symbols,
        settled: settled.as_ref(),
        built: &built,
        drawn: built.drawn(),
        sources: &files.sources,
        end: files.sources.end(file),
        accept_part: options.accept_part,
    };
    advise(&evidence, &mut report);
    report.symbols = symbols;
    let misfit = report.misfit.take();
    let placement = options.view.placement().or(facts.placement);
    let world_follows_camera = facts.uses_camera_space;
    let can_keep_going = settled.is_some() && !report.is_v4(&files.sources) && misfit.is_none();
    let is_whole = (!report.has_errors() || options.keep_going) && misfit.is_none() && !options.fast;
    let unread = built.unread;
    let output = settled.as_ref().map_or(DEFAULT_OUTPUT.into(), |settled| settled.output.clone());
    let mut places = settled.as_ref().map_or_else(Places::default, |settled| settled.places.clone());
    places.lights = facts.lights;
    let scene = settled.filter(|_| is_whole);
    let scene = scene.map(|settled| Scene { view: settled.view, world: Arc::new(built.world) });
    let (diagnostics, symbols) = report.finish(&files.sources);
    let (sources, inputs, memory) = files.into_parts();
    Loaded {
        sources,
        inputs,
        memory,
        scene,
        places,
        output,
        diagnostics,
        symbols,
        unread,
        can_keep_going,
        placement,
        world_follows_camera,
        misfit,
    }
}

/// The memory left for the statements of a text, besides its numbers.
fn room(memory: &MemoryBudget, text: &[u8]) -> u64 {
    // Each `0 ` becomes eight bytes. Counting the numbers takes longer and is rarely needed.
    let numbers = 4 * text.len() as u64;
    let numbers = if 2 * numbers > memory.left() { number_bytes(text) } else { numbers };
    memory.left().saturating_sub(numbers)
}

/// The result for a file that is not a scene.
fn nothing(files: Files, diagnostics: Vec<Diagnostic>) -> Loaded {
    let (sources, inputs, memory) = files.into_parts();
    Loaded {
        sources,
        inputs,
        memory,
        scene: None,
        places: Places::default(),
        output: DEFAULT_OUTPUT.into(),
        diagnostics,
        symbols: Vec::new(),
        unread: 0,
        can_keep_going: false,
        placement: None,
        world_follows_camera: false,
        misfit: None,
    }
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
    /// Resolves a file and returns the number of its directives. `rest` is appended to its last directive.
    fn file(&mut self, id: FileId, rest: Vec<Param>) -> usize {
        let files = &self.resolver.files;
        let source = files.sources.file(id);
        self.open.push(source.path.clone());
        let memory = &files.memory;
        let mut known = files.reuse.map(|reuse| reuse.known_lists(&source.path, source.text.clone()));
        let mut parsed = parse_again(id, &source.text, room(memory, &source.text), &mut |ty, at| {
            known.as_mut()?.find(ty, at)
        });
        if let (Some(reuse), Some(known)) = (files.reuse, known) {
            reuse.keep_text(&source.path, known, std::mem::take(&mut parsed.lists));
        }
        // Never more than there is room for.
        let _ = memory.reserve(parsed.bytes).map(Charge::keep);
        if let Some(at) = parsed.exhausted {
            let most = byte_words(memory.limit());
            let message = format!(
                "the scene is too large: from here on, it needs more memory than the limit, which is {most}"
            );
            let help =
                "raise the limit; to save memory, use plymesh for large meshes and ObjectInstance for copies";
            self.resolver.report.push(Diagnostic::error(at, message).help(help));
            self.resolver.report.incomplete = true;
        }
        self.resolver.report.extend(parsed.diagnostics);
        self.resolver.report.v4_marks(parsed.v4_marks);
        self.resolver.report.incomplete_end |= parsed.broken_end;
        self.resolver.report.incomplete |= parsed.lost_include;
        if let Some(first) = rest.first() {
            let at = first.span();
            match parsed.statements.last_mut().and_then(|last| last.directive.params_mut()) {
                Some(params) => params.extend(rest),
                None => {
                    self.resolver
                        .report
                        .push(Diagnostic::error(at, "these parameters belong to no directive").help(
                        "parameters after an Include belong to the last directive of the included file, which takes no parameters",
                    ))
                }
            }
        }
        if let [first, ..] = &parsed.statements[..]
            && self.open.len() == 1
        {
            match part_of(&parsed.statements) {
                Some(Block::World) => self.resolver.begin_part(first.keyword),
                Some(_) => self.resolver.begin_options_part(first.keyword),
                None => {}
            }
        }
        let directives = parsed.statements.len();
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
        self.open.pop();
        directives
    }

    fn include(&mut self, name: Text, rest: Vec<Param>, at: Span) {
        if self.resolver.files.sources.files.len() > MAX_INCLUDES {
            let message = format!("the scene includes more than {MAX_INCLUDES} files");
            self.resolver.report.push(Diagnostic::error(name.span, message));
            return;
        }
        if self.repeated > MAX_REPEATED {
            let message = "repeated includes add up to more than 4 GiB";
            self.resolver.report.push(
                Diagnostic::error(name.span, message)
                    .help("to repeat shapes, use ObjectBegin and ObjectInstance"),
            );
            return;
        }
        if self.open.len() >= MAX_DEPTH {
            let message = format!("more than {MAX_DEPTH} nested includes");
            self.resolver.report.push(Diagnostic::error(name.span, message));
            return;
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

/// The block in which other files include this file: the world or the options. `None` for a scene.
fn part_of(statements: &[Statement]) -> Option<Block> {
    let is_in = |statement: &Statement, block| home_block(&statement.directive) == Some(block);
    let includes = |statement: &Statement| matches!(statement.directive, Directive::Include { .. });
    let any = |is: &dyn Fn(&Directive) -> bool| statements.iter().any(|statement| is(&statement.directive));
    let has_options = statements.iter().any(|statement| is_in(statement, Block::Options));
    match statements.iter().position(|statement| is_in(statement, Block::World)) {
        Some(first) => {
            let is_around = |it: &Directive| matches!(it, Directive::WorldEnd | Directive::LookAt(_));
            // An earlier Include may contain the missing directives.
            let is_alone = !has_options && !any(&is_around) && !statements[..first].iter().any(includes);
            is_alone.then_some(Block::World)
        }
        None => {
            let is_world = |it: &Directive| matches!(it, Directive::WorldBegin | Directive::WorldEnd);
            let is_alone = !any(&is_world) && !statements.iter().any(includes);
            (has_options && is_alone).then_some(Block::Options)
        }
    }
}
