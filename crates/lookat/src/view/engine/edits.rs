//! Writing the camera into the files, and taking that back.

use lookat_scene::Location;

use super::Engine;
use crate::view::messages::{Action, Edit, Edited, News, Open, SetCamera};
use crate::view::outbox::Kind;
use crate::view::unsaved::Unsaved;
use crate::view::write::FileChange;

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
            let edited = Edited { by, lines: Vec::new(), is_written: false, refused: Some(reason) };
            self.hub.tell(Kind::Edited(by), News::Edited(edited).message());
        }
    }

    /// Changes the files, or shows what would change.
    pub(super) fn edit(&mut self, Edit { by, action }: Edit) {
        let (is_shown, is_write) = (matches!(action, Action::Show), matches!(action, Action::Write));
        // Whether files have been written.
        let done = match action {
            Action::Show => self.show_changes(by).map(|()| false),
            Action::Write => {
                let shown = self.shown.take().filter(|(page, _)| *page == by);
                let changes = shown.ok_or_else(|| "there is nothing to write".to_owned());
                changes.and_then(|(_, changes)| self.history.write(changes)).map(|()| true)
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
        let shown = self.shown.iter().filter(|_| is_shown && done.is_ok()).flat_map(|(_, changes)| changes);
        let lines = shown.flat_map(FileChange::lines).collect();
        if done == Ok(true) {
            // The file has the camera now.
            self.set.camera = SetCamera::default();
        }
        if done == Ok(true) && is_write {
            self.unsaved = Unsaved::default();
        }
        if !is_shown && done.is_ok() {
            self.read();
        }
        let edited = Edited { by, lines, is_written: done == Ok(true), refused: done.err() };
        self.hub.tell(Kind::Edited(by), News::Edited(edited).message());
    }

    fn show_changes(&mut self, by: u32) -> Result<(), String> {
        self.shown = None;
        let opened = self.opened.as_ref().ok_or("no scene has been read yet")?;
        let changes = self.unsaved.with(opened.changes(&self.set.camera)?);
        if changes.is_empty() {
            return Err(
                "the file has this camera and these parameters already; the film is never written".into()
            );
        }
        self.shown = Some((by, changes));
        Ok(())
    }
}
