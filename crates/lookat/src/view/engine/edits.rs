//! Writing the camera into the files, and taking that back.

use super::Engine;
use crate::view::messages::{Action, Edit, Edited, News, SetCamera};
use crate::view::outbox::Kind;
use crate::view::write::FileChange;

impl Engine {
    /// Changes the files, or shows what would change.
    pub(super) fn edit(&mut self, Edit { by, action }: Edit) {
        let done = match action {
            Action::Show => self.show_changes(by),
            Action::Write => {
                let shown = self.shown.take().filter(|(page, _)| *page == by);
                shown.map_or(Err("there is nothing to write".into()), |(_, changes)| {
                    self.history.write(changes)
                })
            }
            Action::Undo => self.history.undo(),
            Action::Redo => self.history.redo(),
        };
        let is_shown = matches!(action, Action::Show) && done.is_ok();
        let lines = self
            .shown
            .iter()
            .filter(|_| is_shown)
            .flat_map(|(_, changes)| changes)
            .flat_map(FileChange::lines);
        let edited = Edited { by, lines: lines.collect(), refused: done.err() };
        if !matches!(action, Action::Show) && edited.refused.is_none() {
            // The file has the camera now.
            self.set.camera = SetCamera::default();
            self.read();
        }
        self.hub.tell(Kind::Edited(by), News::Edited(edited).message());
    }

    fn show_changes(&mut self, by: u32) -> Result<(), String> {
        self.shown = None;
        let opened = self.opened.as_ref().ok_or("no scene has been read yet")?;
        let changes = opened.changes(&self.set.camera)?;
        if changes.is_empty() {
            return Err("the file has this camera already".into());
        }
        self.shown = Some((by, changes));
        Ok(())
    }
}
