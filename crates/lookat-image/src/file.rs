//! Files that appear under their names whole or not at all.

use std::fs::File;
use std::io::{BufWriter, Write};
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
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    replace(path, |out| Ok(out.write_all(bytes)?)).map_err(|fault| ImageError::writing(path, fault))
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

/// The file that writing to `path` replaces, and its folder: a link stays, and its target is replaced. `None` if a socket,
/// a pipe or a device has that name, or links form a circle.
pub fn write_target(path: &Path) -> Option<(PathBuf, PathBuf)> {
    if path.exists() && !path.is_file() && !path.is_dir() {
        return None;
    }
    let target = path.canonicalize().ok().or_else(|| followed(path))?;
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.into(),
        _ => ".".into(),
    };
    Some((target, folder))
}

/// Where a link leads to that leads to nothing yet.
fn followed(path: &Path) -> Option<PathBuf> {
    let mut at = path.to_path_buf();
    // As many links as Linux follows.
    for _ in 0..40 {
        let Ok(next) = std::fs::read_link(&at) else { return Some(at) };
        at = at.parent().unwrap_or(Path::new("")).join(next);
    }
    None
}

/// Writes a file that appears whole or not at all.
pub(crate) fn replace(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let Some((target, folder)) = write_target(path) else {
        return Err(Fault::Unfit("the existing path is not a file".into()));
    };
    let mut file = temporary_file(&folder)?;
    // The mode is kept, where the file system knows one; the owner is who writes.
    if let Ok(before) = std::fs::metadata(&target) {
        let _ = file.as_file().set_permissions(before.permissions());
    }
    let mut out = BufWriter::new(file.as_file_mut());
    write(&mut out)?;
    out.flush()?;
    drop(out);
    // Some file systems only now say that they are full.
    file.as_file().sync_data()?;
    let mut temporary = temporary();
    temporary.retain(|path| path != file.path());
    file.persist(&target).map_err(|refused| refused.error)?;
    Ok(())
}

/// A temporary file, which [`exit`] removes.
fn temporary_file(folder: &Path) -> Result<NamedTempFile, Fault> {
    let mut temporary = temporary();
    // Made by `create_new` and not by tempfile, so that the picture gets the permissions of any other file.
    let file = tempfile::Builder::new().prefix(".lookat-").make_in(folder, |path| File::create_new(path))?;
    temporary.push(file.path().into());
    Ok(file)
}
