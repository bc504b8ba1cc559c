//! Changes of parameters, writing them and the camera into the files, reverting that, and opening the editor.

use std::collections::BTreeSet;

use lookat_scene::syntax::{EntityKind, Fix, ParamType};
use lookat_scene::{Location, Sources, Symbol, ViewOverride};

use crate::failure::Failure;
use crate::view::engine::Engine;
use crate::view::engine::opened::{describe, kind_of};
use crate::view::messages::{Action, At, Change, ChangedLines, News, Values};
use crate::view::outbox::Topic;
use crate::view::write::{FileChange, Shown, Unsaved, changes};
use crate::writer::lock;
use lookat_scene::DirectiveText;

impl Engine {
    /// Opens a place in the editor.
    pub fn open_editor(&self, by: u32, at: At) {
        let opened = self.opened.as_ref().filter(|opened| {
            at.reading == self.reading && (at.file as usize) < opened.loaded.sources.files.len()
        });
        let done = match (&self.editor, opened) {
            (Some(editor), Some(opened)) => {
                let Location { path, line, column } = opened.loaded.sources.location(at.span());
                editor.open(path, line, column)
            }
            _ => Err("the file has changed: point at the shape again".into()),
        };
        if let Err(reason) = done {
            self.tell_edited(by, Vec::new(), false, Some(reason.into()));
        }
    }

    /// Shows the lines that writing changes. A page writes what it was shown.
    pub fn show_changes(&self, by: u32) {
        let changes = self.unwritten();
        let lines = changes.iter().flatten().flat_map(FileChange::lines).collect();
        let refused = changes.as_ref().err().map(ToString::to_string);
        let mut shown = lock(&self.shown);
        match changes {
            Ok(changes) if shown.changes == changes => {}
            Ok(changes) => *shown = Shown { changes, pages: BTreeSet::new() },
            Err(_) => *shown = Shown::default(),
        }
        shown.pages.insert(by);
        drop(shown);
        self.tell_edited(by, lines, false, refused);
    }

    /// Changes the files, or takes changes back.
    pub fn edit(&mut self, by: u32, action: Action) {
        // Whether files have been written.
        let done = match action {
            Action::Write => {
                let changes = self.shown_changes(by);
                changes.and_then(|changes| self.history.write(changes)).map(|()| {
                    self.unsaved = Unsaved::default();
                    true
                })
            }
            Action::Discard => {
                self.unsaved = Unsaved::default();
                Ok(false)
            }
            Action::Undo if self.unsaved.undo() => Ok(false),
            Action::Redo if self.unsaved.redo() => Ok(false),
            Action::Undo => self.history.undo().map(|()| true),
            Action::Redo => self.history.redo().map(|()| true),
        };
        if done == Ok(true) {
            // The file has the camera now.
            self.set.camera = ViewOverride::default();
        }
        if done.is_ok() {
            self.read();
        }
        self.tell_edited(by, Vec::new(), done == Ok(true), done.err().map(String::from));
    }

    /// The changes that a page was shown, if nothing has been changed since.
    fn shown_changes(&self, by: u32) -> Result<Vec<FileChange>, Failure> {
        let mut shown = lock(&self.shown);
        if shown.changes.is_empty() || !shown.pages.contains(&by) {
            bail!("there is nothing to write");
        }
        let Shown { changes, .. } = std::mem::take(&mut *shown);
        if self.unwritten()? == changes {
            Ok(changes)
        } else {
            Err("the file, the camera or a parameter has changed meanwhile: nothing is written".into())
        }
    }

    /// The changes that are not written. Fails with the reason why there are none.
    fn unwritten(&self) -> Result<Vec<FileChange>, Failure> {
        let opened = self.opened.as_ref().ok_or("no scene has been read yet")?;
        let changes = self.unsaved.with(opened.changes(&self.set.camera)?);
        if changes.is_empty() {
            Err("the file already has this camera and these parameters; settings of the film are never written".into())
        } else {
            Ok(changes)
        }
    }

    fn tell_edited(&self, by: u32, lines: Vec<ChangedLines>, is_written: bool, refused: Option<String>) {
        self.shared.hub.tell(Topic::Edited(by), News::Edited { by, lines, is_written, refused });
    }
}

/// The directives that pages can change.
const CHANGEABLE: [EntityKind; 4] = [
    EntityKind::Material,
    EntityKind::MakeNamedMaterial,
    EntityKind::AreaLightSource,
    EntityKind::LightSource,
];

impl Engine {
    pub fn change(&mut self, change: Change) {
        let (mut places, mut refused) = (change.shown.clone(), None);
        match self.try_change(&change) {
            Ok(fixes) => places = places.into_iter().map(|at| moved(at, &fixes, self.reading)).collect(),
            Err(reason) => refused = Some(reason.into()),
        }
        let sources = self.opened.as_ref().map(|opened| &opened.loaded.sources);
        let current = places.iter().filter(|at| at.reading == self.reading);
        let directives = current.filter_map(|at| describe(sources?, at.span(), self.reading)).collect();
        let Change { by, number, .. } = change;
        self.shared.hub.tell(Topic::Changed(by), News::Changed { by, number, directives, refused });
    }

    /// Reads the scene with other values. Fails with the reason, and changes nothing.
    fn try_change(&mut self, change: &Change) -> Result<Vec<Fix>, Failure> {
        let opened = self.opened.as_ref().filter(|_| change.at.reading == self.reading);
        let sources = &opened.ok_or("the file has changed: point at the shape again")?.loaded.sources;
        let fixes = fixes(sources, change)?;
        let before = self.unsaved.clone();
        self.unsaved.add(
            format!("{} {} {}", change.at.file, change.at.start, change.name),
            changes(sources, &fixes)?,
        );
        let loaded = self.load_once();
        let known = self.opened.as_ref().map_or(&[][..], |opened| &opened.loaded.symbols);
        let read = match new_undefined(&loaded.symbols, known) {
            _ if loaded.scene.is_none() => Err(first_error(&loaded).into()),
            Some(symbol) => Err(format!("there is no {} \"{}\"", symbol.kind.name(), symbol.name).into()),
            None => self.open(loaded),
        };
        match &read {
            Ok(()) => {
                self.has_lost = false;
                self.tell_scene(None);
            }
            Err(_) => self.unsaved = before,
        }
        read.map(|()| fixes)
    }
}

/// The changes of the text. Fails with the reason why there is none.
fn fixes(
    sources: &Sources,
    Change { at, name, value_type, values, .. }: &Change,
) -> Result<Vec<Fix>, Failure> {
    let found = DirectiveText::at(sources, at.span()).filter(|found| CHANGEABLE.contains(&found.kind));
    let found = found.ok_or("there is no material or light at this place")?;
    let ty =
        ParamType::from_spelling(value_type).ok_or_else(|| format!("there is no type \"{value_type}\""))?;
    let mut known = kind_of(&found).into_iter().flat_map(|kind| kind.parameters());
    let parameter = known.find(|parameter| parameter.name == name);
    let parameter = parameter.ok_or_else(|| format!("there is no parameter \"{name}\""))?;
    // The text of a page may not make the program open files.
    let is_closed = matches!(ty, ParamType::Bool | ParamType::Texture) || !parameter.range.is_empty();
    if matches!(values, Values::Words(_)) && !is_closed {
        bail!("change \"{name}\" in the file: the page cannot name files");
    }
    let words: Vec<String> = match values {
        Values::Numbers(numbers) if numbers.iter().all(|number| number.is_finite()) => {
            numbers.iter().map(f64::to_string).collect()
        }
        Values::Words(words) if words.iter().all(|word| !word.contains(['"', '\\', '\n', '\r'])) => {
            words.iter().map(|word| format!("\"{word}\"")).collect()
        }
        _ => bail!("this value cannot be written"),
    };
    Ok(found.set(ty, name, &words))
}

/// A place after changes before it.
fn moved(at: At, fixes: &[Fix], reading: u32) -> At {
    let before = fixes.iter().filter(|fix| fix.span.file.0 == at.file && fix.span.start < at.start);
    let grown: i64 =
        before.map(|fix| fix.replacement.len() as i64 - i64::from(fix.span.end - fix.span.start)).sum();
    At { reading, start: (i64::from(at.start) + grown).max(0) as u32, ..at }
}

/// An undefined name that was not used before.
fn new_undefined<'s>(symbols: &'s [Symbol], before: &[Symbol]) -> Option<&'s Symbol> {
    let same = |symbol: &Symbol, other: &Symbol| (symbol.kind, &symbol.name) == (other.kind, &other.name);
    let is_undefined = |symbol: &&Symbol| symbol.definition.is_none();
    let mut undefined = symbols.iter().filter(is_undefined);
    undefined.find(|symbol| !before.iter().filter(is_undefined).any(|other| same(symbol, other)))
}

/// The message of the first error.
fn first_error(loaded: &lookat_scene::Loaded) -> String {
    use lookat_scene::syntax::Severity;
    let error = loaded.diagnostics.iter().find(|diagnostic| diagnostic.severity == Severity::Error);
    error.map(|error| error.message.clone()).or(loaded.override_error.clone()).unwrap_or_default()
}
