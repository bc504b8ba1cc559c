//! The files of a scene, and whether they have changed.

use std::collections::BTreeMap;
use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

/// The time between two looks at the files.
const STEP: Duration = Duration::from_millis(100);

/// What tells one version of a file from another: an editor writes it in place or renames another file. `None` for a file
/// that does not exist.
type Stamp = Option<(Option<SystemTime>, u64, u64)>;

/// The files of the scene, with their state when the scene was read. Some may have been missing.
#[derive(Default)]
pub struct Watch {
    files: Mutex<BTreeMap<PathBuf, Stamp>>,
    next: Mutex<Option<Instant>>,
    has_changed: AtomicBool,
}

impl Watch {
    /// Forgets all files: the scene is read again.
    pub fn restart(&self) {
        self.files.lock().unwrap_or_else(PoisonError::into_inner).clear();
        self.has_changed.store(false, Ordering::Relaxed);
    }

    /// Notes a file before it is read.
    pub fn note(&self, file: &Path) {
        let mut files = self.files.lock().unwrap_or_else(PoisonError::into_inner);
        files.entry(file.to_owned()).or_insert_with(|| stamp(file));
    }

    /// True if a file has changed since it was noted. Looks at the files every `STEP`.
    pub fn has_changed(&self) -> bool {
        if let Ok(mut next) = self.next.try_lock()
            && next.is_none_or(|next| next <= Instant::now())
        {
            let files = self.files.lock().unwrap_or_else(PoisonError::into_inner);
            if files.iter().any(|(file, noted)| stamp(file) != *noted) {
                self.has_changed.store(true, Ordering::Relaxed);
            }
            *next = Some(Instant::now() + STEP);
        }
        self.has_changed.load(Ordering::Relaxed)
    }

    /// Waits while `go_on` holds, until a file has changed and all files have been left alone for a moment. A program that
    /// saves a file may first remove it.
    pub fn wait(&self, go_on: impl Fn() -> bool) {
        let mut before = None;
        while go_on() {
            std::thread::sleep(STEP);
            if self.has_changed() {
                let files = self.files.lock().unwrap_or_else(PoisonError::into_inner);
                let now: Vec<Stamp> = files.keys().map(|file| stamp(file)).collect();
                if before.as_ref() == Some(&now) {
                    return;
                }
                before = Some(now);
            }
        }
    }
}

fn stamp(file: &Path) -> Stamp {
    std::fs::metadata(file).ok().map(|found| (found.modified().ok(), found.len(), number(&found)))
}

/// The number of a file, which changes if another file is renamed to it.
#[cfg(unix)]
fn number(found: &Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::ino(found)
}

#[cfg(not(unix))]
fn number(_: &Metadata) -> u64 {
    0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noted(file: &Path) -> Watch {
        let watch = Watch::default();
        watch.note(file);
        assert!(!watch.has_changed());
        *watch.next.lock().unwrap() = None;
        watch
    }

    #[test]
    fn files_that_are_written_renamed_removed_and_made_have_changed() {
        let folder = tempfile::tempdir().unwrap();
        let [file, other] = ["a", "b"].map(|name| folder.path().join(name));
        let watch = noted(&file);
        std::fs::write(&file, "1").unwrap();
        assert!(watch.has_changed());
        let watch = noted(&file);
        std::fs::write(&file, "12").unwrap();
        assert!(watch.has_changed());
        // Of the same length and time.
        let watch = noted(&file);
        let time = std::fs::metadata(&file).unwrap().modified().unwrap();
        std::fs::write(&other, "21").unwrap();
        std::fs::File::options().write(true).open(&other).unwrap().set_modified(time).unwrap();
        std::fs::rename(&other, &file).unwrap();
        assert_eq!(watch.has_changed(), cfg!(unix));
        let watch = noted(&file);
        std::fs::remove_file(&file).unwrap();
        assert!(watch.has_changed());
        watch.restart();
        assert!(!watch.has_changed());
    }
}
