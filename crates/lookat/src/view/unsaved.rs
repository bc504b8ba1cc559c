//! What pages have changed in the files and not written: the scene is read with it.

use std::path::Path;

use bytes::Bytes;
use lookat_image::has_text;

use super::write::{FileChange, forget_first};

/// The files on disk and their texts for the scene, with the states before and after.
#[derive(Default, Clone)]
pub struct Unsaved {
    files: Vec<FileChange>,
    /// The earlier states, and what was changed then.
    done: Vec<(String, Vec<FileChange>)>,
    undone: Vec<(String, Vec<FileChange>)>,
}

impl Unsaved {
    /// The text to read in place of a file.
    pub fn text(&self, path: &Path) -> Option<Bytes> {
        self.files.iter().find(|change| change.path == path).map(|change| change.after.clone())
    }

    /// Goes on from these texts. Changes of the same thing in a row are undone at once.
    pub fn add(&mut self, what: String, changes: Vec<FileChange>) {
        if self.done.last().is_none_or(|(before, _)| *before != what) {
            self.done.push((what, self.files.clone()));
            forget_first(&mut self.done, |(_, changes)| changes);
        }
        self.undone.clear();
        self.files = self.with(changes);
    }

    /// The changes from the files on disk to these texts and further `changes` of them.
    pub fn with(&self, changes: Vec<FileChange>) -> Vec<FileChange> {
        let mut all = self.files.clone();
        for change in changes {
            match all.iter_mut().find(|known| known.path == change.path) {
                Some(known) => known.after = change.after,
                None => all.push(change),
            }
        }
        all.retain(|change| change.before != change.after);
        all
    }

    /// Returns to the state before the last change. False if there is none.
    pub fn undo(&mut self) -> bool {
        let Some((what, before)) = self.done.pop() else { return false };
        self.undone.push((what, std::mem::replace(&mut self.files, before)));
        true
    }

    pub fn redo(&mut self) -> bool {
        let Some((what, after)) = self.undone.pop() else { return false };
        self.done.push((what, std::mem::replace(&mut self.files, after)));
        true
    }

    pub fn can_undo(&self) -> bool {
        !self.done.is_empty()
    }

    pub fn can_redo(&self) -> bool {
        !self.undone.is_empty()
    }

    pub fn is_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// Forgets the changes of files that are no longer as they were, and the way to them. True if there were some that have not
    /// been written.
    pub fn forget_old(&mut self) -> bool {
        let is_there = |path: &Path, text: &[u8]| has_text(path, text).is_ok_and(|is_same| is_same);
        let is_old = |change: &FileChange| !is_there(&change.path, &change.before);
        let is_written = |change: &FileChange| is_there(&change.path, &change.after);
        let steps = || self.done.iter().chain(&self.undone).flat_map(|(_, changes)| changes);
        let is_lost = self.files.iter().any(|change| is_old(change) && !is_written(change));
        let has_old_steps = steps().any(is_old);
        self.files.retain(|change| !is_old(change));
        if is_lost || has_old_steps || (self.files.is_empty() && !self.done.is_empty()) {
            self.done.clear();
            self.undone.clear();
        }
        is_lost
    }
}
