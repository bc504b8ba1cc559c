//! Writes files that appear under their names whole or not at all.

use std::fs::File;
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

use crate::error::{Fault, ImageError};

/// The temporary files of all files that are being written.
static TEMPORARY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn temporary() -> MutexGuard<'static, Vec<PathBuf>> {
    TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Writes a file that appears whole or not at all.
///
/// # Errors
///
/// [`ImageError::Write`] if the file system refuses. The previous contents stay then.
pub fn write_file(path: &Path, mut contents: impl Read) -> Result<(), ImageError> {
    replace(path, |out| Ok(io::copy(&mut contents, out).map(drop)?))
        .map_err(|fault| ImageError::writing(path, fault))
}

/// Ends the process with an exit status, and removes the temporary files of files that other threads are writing. No such
/// file appears under its name any more.
pub fn exit(status: i32) -> ! {
    let temporary = temporary();
    for path in temporary.iter() {
        let _ = std::fs::remove_file(path);
    }
    // The lock is held to the end, so that no thread makes or renames another one.
    std::process::exit(status)
}

/// The file that writing to `path` replaces, and its folder. A link stays, and its target is replaced.
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

/// Writes a file that appears whole or not at all.
pub(crate) fn replace(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let (target, folder) = write_target(path).map_err(|error| Fault::Unfit(error.to_string()))?;
    let mut file = temporary_file(&folder)?;
    // The mode is kept, where the file system knows one; the owner is who writes.
    if let Ok(before) = std::fs::metadata(&target) {
        let _ = file.as_file().set_permissions(before.permissions());
    }
    let written = fill(file.as_file_mut(), write);
    let mut temporary = temporary();
    let path = file.path().to_owned();
    let done = written.and_then(|()| Ok(file.persist(&target).map(drop).map_err(|refused| refused.error)?));
    temporary.retain(|other| *other != path);
    done
}

fn fill(
    file: &mut File,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let mut out = BufWriter::new(&mut *file);
    write(&mut out)?;
    out.flush()?;
    drop(out);
    // Some file systems only now say that they are full.
    Ok(file.sync_data()?)
}

/// A temporary file, which [`exit`] removes.
fn temporary_file(folder: &Path) -> Result<NamedTempFile, Fault> {
    let mut temporary = temporary();
    // Made by `create_new` and not by tempfile, so that the picture gets the permissions of any other file.
    let file = tempfile::Builder::new().prefix(".lookat-").make_in(folder, |path| File::create_new(path))?;
    temporary.push(file.path().into());
    Ok(file)
}
