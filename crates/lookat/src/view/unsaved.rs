//! What pages have changed in the files and not written: the scene is read with it.

use std::path::Path;
use std::sync::Arc;

use super::write::FileChange;

/// The files on disk and their texts for the scene.
#[derive(Default, Clone)]
pub struct Unsaved(Vec<FileChange>);

impl Unsaved {
    /// The text to read in place of a file.
    pub fn text(&self, path: &Path) -> Option<Arc<Vec<u8>>> {
        self.0.iter().find(|change| change.path == path).map(|change| change.after.clone())
    }

    /// Goes on from these texts.
    pub fn add(&mut self, changes: Vec<FileChange>) {
        for change in changes {
            match self.0.iter_mut().find(|known| known.path == change.path) {
                Some(known) => known.after = change.after,
                None => self.0.push(change),
            }
        }
        self.0.retain(|change| change.before != change.after);
    }

    /// The changes from the files on disk to these texts and further `changes` of them.
    pub fn with(&self, changes: Vec<FileChange>) -> Vec<FileChange> {
        let mut all = self.clone();
        all.add(changes);
        all.0
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Forgets the changes of files that are no longer as they were. True if there were some that have not been written.
    pub fn forget_old(&mut self) -> bool {
        let mut is_lost = false;
        self.0.retain(|change| {
            let found = std::fs::read(&change.path).ok();
            let is_current = found.as_ref() == Some(&change.before);
            is_lost |= !is_current && found.as_ref() != Some(&change.after);
            is_current
        });
        is_lost
    }
}
