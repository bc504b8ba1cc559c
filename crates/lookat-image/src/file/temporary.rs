//! Temporary files.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::TempPath;

/// The temporary files of this process.
static TEMPORARY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// The temporary files. While they are locked, [`exit`] waits.
pub fn temporary() -> MutexGuard<'static, Vec<PathBuf>> {
    TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends the process with an exit status, and removes its temporary files. No file that another thread is writing appears under its
/// name any more.
pub fn exit(status: i32) -> ! {
    let temporary = temporary();
    for path in temporary.iter() {
        let _ = std::fs::remove_file(path);
    }
    // The lock is held to the end, so that no thread makes or renames another one.
    std::process::exit(status)
}

/// The name of a temporary file: between these parts stand the name of the computer and random letters.
#[derive(Debug, Clone, Copy)]
pub struct TemporaryName {
    /// The beginning.
    pub prefix: &'static str,
    /// The end, such as `.html`.
    pub suffix: &'static str,
    /// True if only the user can read the file; otherwise it has the permissions of any new file.
    pub is_private: bool,
}

impl TemporaryName {
    /// The beginning, with the name of the computer.
    fn start(self) -> String {
        format!("{}{}-", self.prefix, computer())
    }
}

/// The name of files that are renamed once they are whole.
pub const HIDDEN: TemporaryName = TemporaryName { prefix: ".lookat-", suffix: "", is_private: false };

/// A file that is removed when it is dropped and by [`exit`]. If the process is killed, the next one that makes such a file in
/// this folder removes it.
#[derive(Debug)]
pub struct TemporaryFile {
    /// Open for reading and writing. Its lock tells others that its process lives.
    pub file: File,
    path: PathBuf,
    is_kept: bool,
}

impl TemporaryFile {
    /// Makes an empty file in a folder.
    ///
    /// # Errors
    ///
    /// The folder accepts no files.
    pub fn new(folder: &Path, name: TemporaryName) -> io::Result<TemporaryFile> {
        remove_abandoned(folder, name);
        let mut temporary = temporary();
        let mut builder = tempfile::Builder::new();
        let made =
            builder.prefix(&name.start()).suffix(name.suffix).make_in(folder, |path| make(path, name))?;
        let (file, path) = made.keep().map_err(|refused| refused.error)?;
        temporary.push(path.clone());
        Ok(TemporaryFile { file, path, is_kept: false })
    }

    /// Where the file is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the file its name, and replaces another one of this name.
    pub(super) fn persist(self, target: &Path) -> io::Result<()> {
        let _no_exit = temporary();
        std::fs::rename(&self.path, target)
    }

    /// Gives the file another temporary name, of the locked ones of this process.
    pub(super) fn rename(&mut self, name: TempPath, temporary: &mut Vec<PathBuf>) -> io::Result<()> {
        std::fs::rename(&self.path, &name)?;
        temporary.retain(|other| *other != self.path);
        self.path = name.keep().map_err(|refused| refused.error)?;
        temporary.push(self.path.clone());
        Ok(())
    }

    /// Keeps the file under its present name.
    pub(super) fn keep(&mut self, temporary: &mut Vec<PathBuf>) {
        temporary.retain(|other| *other != self.path);
        self.is_kept = true;
    }
}

impl Drop for TemporaryFile {
    fn drop(&mut self) {
        let mut temporary = temporary();
        temporary.retain(|other| *other != self.path);
        if !self.is_kept {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Makes a file of a new name, and locks it.
fn make(path: &Path, name: TemporaryName) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).create_new(true);
    #[cfg(unix)]
    if name.is_private {
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    }
    let file = options.open(path)?;
    // Elsewhere a lock keeps others from reading.
    if cfg!(unix) && (matches!(file.try_lock(), Err(TryLockError::WouldBlock)) || !path.exists()) {
        // Another process took it for one without a process, before it was locked. Another name is tried.
        return Err(ErrorKind::AlreadyExists.into());
    }
    Ok(file)
}

/// Removes the temporary files that no process holds a lock on: their process is gone. Files of other computers stay, because not every
/// network drive shows their locks.
pub(super) fn remove_abandoned(folder: &Path, name: TemporaryName) {
    if !cfg!(unix) {
        return;
    }
    let prefix = name.start();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_named = entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes());
        if !is_named || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        let path = entry.path();
        let Ok(file) = crate::open_file(&path) else { continue };
        // The lock is held until the file is gone: a process that is about to use the file sees it.
        if file.try_lock().is_ok() {
            let _ = std::fs::remove_file(&path);
        }
    }
}

/// The name of this computer, as far as it fits a file name.
#[cfg(unix)]
fn computer() -> String {
    let name = rustix::system::uname();
    let name = name.nodename().to_string_lossy();
    name.chars().filter(char::is_ascii_alphanumeric).take(64).collect()
}

#[cfg(not(unix))]
fn computer() -> &'static str {
    ""
}
