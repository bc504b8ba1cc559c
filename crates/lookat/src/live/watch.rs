//! The files of a scene, and whether they have changed.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant, SystemTime};

use lookat_scene::Stamp;
use notify::event::{AccessKind, AccessMode, ModifyKind};
use notify::{Event, EventKind, RecommendedWatcher, RecursiveMode, Watcher};

use crate::writer::lock;

/// The time between two looks at the files, where the system tells no change.
const STEP: Duration = Duration::from_millis(100);
/// The time after which a file that is written in place is complete.
const CALM: Duration = Duration::from_millis(5);
/// Whether the system tells the end of writing: when the file is closed.
const TELLS_END: bool = cfg!(target_os = "linux");
/// The most looks at a file that is written.
const MOST_LOOKS: u32 = 40;
/// A file that has changed within this time may change again without a new stamp: the clocks of file systems are that coarse.
const COARSE: Duration = Duration::from_secs(2);

/// The files of the scene, with their state when the scene was read. Some may have been missing. An editor writes a file in place, or
/// renames another file to it.
#[derive(Default)]
pub struct Watch {
    files: Mutex<BTreeMap<PathBuf, Noted>>,
    next: Mutex<Option<Instant>>,
    has_changed: AtomicBool,
    /// Whether the system has told of the change.
    is_told: AtomicBool,
    folders: Mutex<Option<Folders>>,
    told: Arc<Told>,
}

/// A file before it was read.
struct Noted {
    /// `None` for a file that does not exist.
    stamp: Option<Stamp>,
    at: SystemTime,
}

/// What the system tells of folders.
#[derive(Default)]
struct Told {
    /// The names of the files.
    names: Mutex<BTreeSet<OsString>>,
    /// Whether one may have changed since the last look at the files.
    has_news: AtomicBool,
}

/// The folders of the files, of which the system tells changes. A file that is renamed to one of a scene is seen only there.
struct Folders {
    watcher: RecommendedWatcher,
    known: BTreeSet<PathBuf>,
}

impl Watch {
    /// Calls `wake` as soon as the system tells that a file may have changed. Where it tells nothing, as of some network drives,
    /// [`Watch::has_changed`] still finds the changes.
    pub fn new(wake: impl Fn() + Send + 'static) -> Watch {
        let watch = Watch::default();
        let told = watch.told.clone();
        let tell = move |event: notify::Result<Event>| {
            if event.is_ok_and(|event| told.is_news(&event)) {
                told.has_news.store(true, Ordering::Relaxed);
                wake();
            }
        };
        let watcher = notify::recommended_watcher(tell).ok();
        *lock(&watch.folders) = watcher.map(|watcher| Folders { watcher, known: BTreeSet::new() });
        watch
    }

    /// Forgets all files: the scene is read again.
    pub fn restart(&self) {
        lock(&self.files).clear();
        lock(&self.told.names).clear();
        self.has_changed.store(false, Ordering::Relaxed);
    }

    /// Notes a file before it is read.
    pub fn note(&self, file: &Path) {
        // First, so that no change is missed.
        if let Some(folders) = &mut *lock(&self.folders) {
            folders.add(file);
        }
        lock(&self.told.names).extend(file.file_name().map(ToOwned::to_owned));
        let noted = || Noted { stamp: stamp(file), at: SystemTime::now() };
        lock(&self.files).entry(file.to_owned()).or_insert_with(noted);
    }

    /// The stamp with which a file was noted. `None` if it may change without another one.
    pub fn stamp(&self, file: &Path) -> Option<Stamp> {
        let files = lock(&self.files);
        let Noted { stamp, at } = files.get(file)?;
        stamp.filter(|stamp| {
            let age = stamp.modified.and_then(|modified| at.duration_since(modified).ok());
            age.is_some_and(|age| age > COARSE)
        })
    }

    /// True if a file has changed since it was noted. Looks at the files every `STEP`, and when the system tells of a change.
    pub fn has_changed(&self) -> bool {
        self.look(false)
    }

    /// True if a file has changed since it was noted. Looks at the files in any case.
    pub fn has_changed_by_now(&self) -> bool {
        self.look(true)
    }

    fn look(&self, is_due: bool) -> bool {
        if let Ok(mut next) = self.next.try_lock() {
            let has_news = self.told.has_news.swap(false, Ordering::Relaxed);
            if is_due || has_news || next.is_none_or(|next| next <= Instant::now()) {
                if lock(&self.files).iter().any(|(file, noted)| stamp(file) != noted.stamp) {
                    self.has_changed.store(true, Ordering::Relaxed);
                    self.is_told.store(has_news, Ordering::Relaxed);
                }
                *next = Some(Instant::now() + STEP);
            }
        }
        self.has_changed.load(Ordering::Relaxed)
    }

    /// Waits for the end of writing.
    pub fn settle(&self) {
        let mut before = self.stamps();
        let looks = if TELLS_END && self.is_told.load(Ordering::Relaxed) { 0 } else { MOST_LOOKS };
        for _ in 0..looks {
            std::thread::sleep(CALM);
            let now = self.stamps();
            if now == before {
                return;
            }
            before = now;
        }
    }

    fn stamps(&self) -> Vec<Option<Stamp>> {
        lock(&self.files).keys().map(|file| stamp(file)).collect()
    }

    /// Waits while `go_on` holds, until a file has changed and all files have been left alone for a moment. A program that
    /// saves a file may first remove it.
    pub fn wait(&self, go_on: impl Fn() -> bool) {
        let mut before = None;
        while go_on() {
            std::thread::sleep(STEP);
            if self.has_changed() {
                let now = self.stamps();
                if before.as_ref() == Some(&now) {
                    return;
                }
                before = Some(now);
            }
        }
    }
}

impl Told {
    /// Whether a file may have changed, and is complete.
    fn is_news(&self, event: &Event) -> bool {
        let may_be_complete = match event.kind {
            EventKind::Access(AccessKind::Close(AccessMode::Write)) => true,
            EventKind::Access(_) => false,
            EventKind::Modify(ModifyKind::Name(_)) => true,
            _ => !TELLS_END,
        };
        let names = lock(&self.names);
        may_be_complete
            && event.paths.iter().filter_map(|path| path.file_name()).any(|name| names.contains(name))
    }
}

impl Folders {
    /// Adds the folder of a file. Where the system has no room for it, nothing is told of it.
    fn add(&mut self, file: &Path) {
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !self.known.contains(folder) && self.watcher.watch(folder, RecursiveMode::NonRecursive).is_ok() {
            self.known.insert(folder.to_owned());
        }
    }
}

fn stamp(file: &Path) -> Option<Stamp> {
    let found = std::fs::metadata(file).ok()?;
    Some(Stamp { modified: found.modified().ok(), length: found.len(), number: number(&found) })
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

    #[test]
    fn changes_are_told() {
        let folder = tempfile::tempdir().unwrap();
        let [file, other] = ["a", "b"].map(|name| folder.path().join(name));
        std::fs::write(&file, "1").unwrap();
        let (tell, told) = std::sync::mpsc::channel();
        let watch = Watch::new(move || tell.send(()).unwrap_or(()));
        let wait = |watch: &Watch| {
            // Events of earlier changes come, too.
            while !watch.has_changed() {
                told.recv_timeout(Duration::from_secs(20)).unwrap();
            }
            watch.settle();
            watch.restart();
            watch.note(&file);
        };
        watch.note(&file);
        std::fs::write(&file, "12").unwrap();
        wait(&watch);
        std::fs::write(&other, "123").unwrap();
        std::fs::rename(&other, &file).unwrap();
        wait(&watch);
        assert!(!watch.has_changed());
    }

    /// A file is known by its stamp once it has been left alone for a while.
    #[test]
    fn stamps_tell_versions_apart() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a");
        std::fs::write(&file, "1").unwrap();
        let stamp = |age: Duration| {
            let opened = std::fs::File::options().write(true).open(&file).unwrap();
            opened.set_modified(SystemTime::now() - age).unwrap();
            let watch = Watch::default();
            assert_eq!(watch.stamp(&file), None);
            watch.note(&file);
            watch.stamp(&file)
        };
        assert_eq!(stamp(Duration::ZERO), None);
        let [old, older] = [10, 20].map(|age| stamp(Duration::from_secs(age)));
        assert!(old.is_some() && older.is_some() && old != older);
    }
}
