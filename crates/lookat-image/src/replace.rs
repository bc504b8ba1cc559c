//! Files that appear under their names whole or not at all, and keep the attributes of the files they replace.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tempfile::TempPath;

use crate::{ImageError, ImageFault, open_file};

/// Writes a file that appears whole or not at all. It keeps the permissions of a file that it replaces and, if the system
/// allows it, the owner and the extended attributes. Other hard links keep the previous contents.
///
/// # Errors
///
/// [`ImageFault::Refused`] if the file system refuses. The previous contents stay then.
pub fn write_file(path: &Path, mut contents: impl Read) -> Result<(), ImageError> {
    replace(path, None, |out| Ok(io::copy(&mut contents, out).map(drop)?))
        .map_err(|fault| ImageError::writing(path, fault))
}

/// The file that writing to `path` replaces, and its folder. Links are followed.
///
/// # Errors
///
/// A socket, a pipe or a device has this name, or links form a circle.
pub fn write_target(path: &Path) -> io::Result<(PathBuf, PathBuf)> {
    if path.exists() && !path.is_file() && !path.is_dir() {
        return Err(io::Error::other("the existing path is not a file"));
    }
    let target = path.canonicalize().or_else(|_| followed(path))?;
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.into(),
        _ => ".".into(),
    };
    Ok((target, folder))
}

/// The path at the end of a link to a file that does not exist yet.
fn followed(path: &Path) -> io::Result<PathBuf> {
    let mut at = path.to_path_buf();
    // As many links as Linux follows.
    for _ in 0..40 {
        let Ok(next) = std::fs::read_link(&at) else { return Ok(at) };
        at = at.parent().unwrap_or(Path::new("")).join(next);
    }
    Err(io::Error::other("its links form a circle"))
}

/// Replaces a file: the new one appears whole or not at all. The file before it gets the name `previous` too, if there is one.
pub(crate) fn replace(
    path: &Path,
    previous: Option<&Path>,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), ImageFault>,
) -> Result<(), ImageFault> {
    let (target, folder) = write_target(path)?;
    let mut new = TemporaryFile::new(&folder, HIDDEN)?;
    if target.is_file() {
        // A picture is written even if the system refuses to give it the attributes.
        let _ = copy_attributes(&target, &new.file);
    }
    fill(&mut new.file, write)?;
    if let Some(previous) = previous.filter(|_| target.is_file()) {
        // A second name, so that the first one never lacks its file. Some file systems have none: then there is no previous file.
        let _ = std::fs::remove_file(previous);
        let _ = std::fs::hard_link(&target, previous);
    }
    Ok(new.persist(&target)?)
}

/// Removes temporary files of a folder that belong to programs that were killed.
pub fn remove_leftovers(folder: &Path) {
    remove_abandoned(folder, HIDDEN);
}

/// Writes the contents of a file.
pub(crate) fn fill(
    file: &mut File,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), ImageFault>,
) -> Result<(), ImageFault> {
    let own = file.try_clone();
    let synced = std::thread::scope(|scope| -> Result<_, ImageFault> {
        let (is_writing, waits) = mpsc::channel::<()>();
        // The disk begins with what is written while more is encoded.
        let sync = move || -> io::Result<()> {
            // Without a second handle, all is synced at the end.
            let Ok(own) = own else { return Ok(()) };
            while waits.recv_timeout(SYNC_STEP) == Err(RecvTimeoutError::Timeout) {
                own.sync_data()?;
            }
            Ok(())
        };
        let early = std::thread::Builder::new().spawn_scoped(scope, sync);
        let mut out = BufWriter::new(&mut *file);
        write(&mut out)?;
        out.flush()?;
        drop((out, is_writing));
        // Each failure of a disk is told once.
        Ok(early.map_or(Ok(()), |early| early.join().unwrap_or(Ok(()))))
    })?;
    synced?;
    // Some file systems only now say that they are full.
    Ok(file.sync_data()?)
}

/// The time after which a file is synced that is still being written.
const SYNC_STEP: Duration = Duration::from_millis(50);

/// The temporary files of this process.
static TEMPORARY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// The temporary files. While they are locked, [`exit`] waits.
pub(crate) fn temporary() -> MutexGuard<'static, Vec<PathBuf>> {
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

/// The name of a temporary file. The name of the computer and random letters stand between the prefix and the suffix.
#[derive(Debug, Clone, Copy)]
pub struct TemporaryName {
    /// The start of the name.
    pub prefix: &'static str,
    /// The end of the name, such as `.html`.
    pub suffix: &'static str,
    /// True if only the user can read the file; otherwise it has the permissions of any new file.
    pub is_private: bool,
}

impl TemporaryName {
    /// The prefix, with the name of the computer.
    fn start(self) -> String {
        format!("{}{}-", self.prefix, computer())
    }
}

/// The name of files that are renamed once they are whole.
pub(crate) const HIDDEN: TemporaryName = TemporaryName { prefix: ".lookat-", suffix: "", is_private: false };

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

    /// The path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the file its name, and replaces another one of this name.
    pub(crate) fn persist(self, target: &Path) -> io::Result<()> {
        let _no_exit = temporary();
        std::fs::rename(&self.path, target)
    }

    /// Gives the file another temporary name, of the locked ones of this process.
    pub(crate) fn rename(&mut self, name: TempPath, temporary: &mut Vec<PathBuf>) -> io::Result<()> {
        std::fs::rename(&self.path, &name)?;
        temporary.retain(|other| *other != self.path);
        self.path = name.keep().map_err(|refused| refused.error)?;
        temporary.push(self.path.clone());
        Ok(())
    }

    /// Keeps the file under its present name.
    pub(crate) fn keep(&mut self, temporary: &mut Vec<PathBuf>) {
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
pub(crate) fn remove_abandoned(folder: &Path, name: TemporaryName) {
    if !cfg!(unix) {
        return;
    }
    let prefix = name.start();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_named = entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes());
        if !is_named || !entry.file_type().is_ok_and(|file_type| file_type.is_file()) {
            continue;
        }
        let path = entry.path();
        let Ok(file) = open_file(&path) else { continue };
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

/// Gives a new file the permissions of an old one, its owner and its extended attributes. Fails if the system refuses some of them; the
/// new file has the others then.
#[cfg(unix)]
pub(crate) fn copy_attributes(old: &Path, new: &File) -> io::Result<()> {
    use std::os::unix::fs::{MetadataExt, fchown};

    let (before, now) = (std::fs::metadata(old)?, new.metadata()?);
    let mut results = Vec::new();
    if before.uid() != now.uid() {
        results.push(fchown(new, Some(before.uid()), None));
    }
    if before.gid() != now.gid() {
        results.push(fchown(new, None, Some(before.gid())));
    }
    // Access control lists are attributes, too.
    results.push(copy_extended_attributes(old, new));
    // Last, because a new owner takes some of them away.
    results.push(new.set_permissions(before.permissions()));
    results.into_iter().collect()
}

/// Gives a new file the permissions of an old one.
#[cfg(not(unix))]
pub(crate) fn copy_attributes(old: &Path, new: &File) -> io::Result<()> {
    new.set_permissions(std::fs::metadata(old)?.permissions())
}

#[cfg(unix)]
fn copy_extended_attributes(old: &Path, new: &File) -> io::Result<()> {
    use std::collections::BTreeMap;
    use std::ffi::OsString;

    use xattr::FileExt;

    // A file system without attributes has nothing to keep.
    let names = xattr::list_deref(old).into_iter().flatten();
    let wanted = names.filter_map(|name| Some((xattr::get_deref(old, &name).transpose()?, name)));
    let wanted = wanted.map(|(value, name)| Ok((name, value?)));
    let wanted = wanted.collect::<io::Result<BTreeMap<OsString, Vec<u8>>>>()?;
    for name in new.list_xattr().into_iter().flatten().filter(|name| !wanted.contains_key(name)) {
        new.remove_xattr(&name)?;
    }
    for (name, value) in wanted {
        if new.get_xattr(&name)?.as_ref() != Some(&value) {
            new.set_xattr(&name, &value)?;
        }
    }
    Ok(())
}

/// The number of hard links of a file.
#[cfg(unix)]
pub(crate) fn links(file: &Path) -> io::Result<u64> {
    Ok(std::os::unix::fs::MetadataExt::nlink(&std::fs::metadata(file)?))
}

/// The number of hard links of a file: 1 where the system does not report it.
#[cfg(not(unix))]
pub(crate) fn links(file: &Path) -> io::Result<u64> {
    std::fs::metadata(file).map(|_| 1)
}

/// True if a file has exactly this text. Takes no memory for a larger file.
///
/// # Errors
///
/// The errors of [`open_file`] and of reading.
pub fn has_text(path: &Path, text: &[u8]) -> io::Result<bool> {
    has_rest(&open_file(path)?, text)
}

/// True if the rest of an open file is exactly this text.
pub(crate) fn has_rest(mut file: &File, text: &[u8]) -> io::Result<bool> {
    let mut buffer = vec![0; 1 << 16];
    let mut rest = text;
    loop {
        let read = match file.read(&mut buffer) {
            Ok(0) => return Ok(rest.is_empty()),
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            read => read?,
        };
        match rest.strip_prefix(&buffer[..read]) {
            Some(left) => rest = left,
            None => return Ok(false),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_compared_to_its_end() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let text = vec![7; 200_000];
        std::fs::write(&path, &text).unwrap();
        assert!(has_text(&path, &text).unwrap());
        assert!(!has_text(&path, &text[1..]).unwrap());
        assert!(!has_text(&path, &[&text[..], &[7]].concat()).unwrap());
        assert!(!has_text(&path, &[&text[1..], &[8]].concat()).unwrap());
        assert_eq!(has_text(folder.path(), &text).unwrap_err().kind(), ErrorKind::IsADirectory);
    }
}
