//! Writes files that appear under their names whole or not at all.

mod attributes;
mod change;
mod temporary;

use std::fs::File;
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use crate::error::{Fault, ImageError};
use temporary::HIDDEN;

pub use change::{change_file, keep_aside};
pub use temporary::{TemporaryFile, TemporaryName, exit};

/// Writes a file that appears whole or not at all. Keeps the permissions of a file that it replaces and, where the system
/// lets, the owner and the extended attributes. Other hard links keep the previous contents.
///
/// # Errors
///
/// [`ImageError::Write`] if the file system refuses. The previous contents stay then.
pub fn write_file(path: &Path, mut contents: impl Read) -> Result<(), ImageError> {
    replace(path, |out| Ok(io::copy(&mut contents, out).map(drop)?))
        .map_err(|fault| ImageError::writing(path, fault))
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
    let mut new = TemporaryFile::new(&folder, HIDDEN)?;
    if target.is_file() {
        // A picture is written even if the system refuses to give it the attributes.
        let _ = attributes::copy(&target, &new.file);
    }
    fill(&mut new.file, write)?;
    Ok(new.persist(&target)?)
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
