//! Writing camera and parameters into the files, taking that back, and opening the editor.

use std::collections::BTreeSet;

use lookat_scene::Location;

use super::Engine;
use crate::lock::lock;
use crate::view::messages::{Action, Edit, Edited, News, Open, SetCamera};
use crate::view::outbox::Kind;
use crate::view::unsaved::Unsaved;
use crate::view::write::FileChange;

/// The changes that pages were shown last, and these pages.
#[derive(Default)]
pub(super) struct Shown {
    changes: Vec<FileChange>,
    pages: BTreeSet<u32>,
}

impl Engine {
    /// Opens a place in the editor.
    pub(super) fn open_editor(&self, Open { by, at }: Open) {
        let opened = self
            .opened
            .as_ref()
            .filter(|opened| at.reading == self.reading && (at.file as usize) < opened.sources().files.len());
        let done = match (&self.editor, opened) {
            (Some(editor), Some(opened)) => {
                let Location { path, line, column } = opened.sources().location(at.span());
                editor.open(path, line, column)
            }
            _ => Err("the file has changed: point at the shape again".into()),
        };
        if let Err(reason) = done {
            self.tell_edited(Edited { by, lines: Vec::new(), is_written: false, refused: Some(reason) });
        }
    }

    /// Shows the lines that writing changes. A page writes what it was shown.
    pub(super) fn show_changes(&self, by: u32) {
        let changes = self.unwritten();
        let lines = changes.iter().flatten().flat_map(FileChange::lines).collect();
        let refused = changes.as_ref().err().cloned();
        let mut shown = lock(&self.shown);
        match changes {
            Ok(changes) if shown.changes == changes => {}
            Ok(changes) => *shown = Shown { changes, pages: BTreeSet::new() },
            Err(_) => *shown = Shown::default(),
        }
        shown.pages.insert(by);
        drop(shown);
        self.tell_edited(Edited { by, lines, is_written: false, refused });
    }

    /// Changes the files, or takes changes back.
    pub(super) fn edit(&mut self, Edit { by, action }: Edit) {
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
            self.set.camera = SetCamera::default();
        }
        if done.is_ok() {
            self.read();
        }
        self.tell_edited(Edited { by, lines: Vec::new(), is_written: done == Ok(true), refused: done.err() });
    }

    /// The changes that a page was shown, if nothing has been changed since.
    fn shown_changes(&self, by: u32) -> Result<Vec<FileChange>, String> {
        let mut shown = lock(&self.shown);
        if shown.changes.is_empty() || !shown.pages.contains(&by) {
            return Err("there is nothing to write".into());
        }
        let Shown { changes, .. } = std::mem::take(&mut *shown);
        match self.unwritten()? == changes {
            true => Ok(changes),
            false => {
                Err("the file, the camera or a parameter has changed meanwhile: nothing is written".into())
            }
        }
    }

    /// The changes that are not written. Fails with the reason why there are none.
    fn unwritten(&self) -> Result<Vec<FileChange>, String> {
        let opened = self.opened.as_ref().ok_or("no scene has been read yet")?;
        let changes = self.unsaved.with(opened.changes(&self.set.camera)?);
        match changes.is_empty() {
            true => {
                Err("the file has this camera and these parameters already; the film is never written".into())
            }
            false => Ok(changes),
        }
    }

    fn tell_edited(&self, edited: Edited) {
        self.hub.tell(Kind::Edited(edited.by), News::Edited(edited).message());
    }
}
