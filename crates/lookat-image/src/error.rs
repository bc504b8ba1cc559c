//! Errors of picture files, in words for the user.

use std::io;
use std::path::{Path, PathBuf};

use crate::{Format, OutOfMemory};

/// A picture that could not be read or written. The message names the file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.message())]
pub struct ImageError {
    /// The path as it was given.
    pub path: PathBuf,
    /// True for a file to write. It is unchanged then.
    pub is_output: bool,
    /// The reason.
    pub fault: ImageFault,
}

/// The reason why a picture file cannot be read or written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ImageFault {
    /// The extension of a file to write is missing or stands for no format.
    UnknownFormat,
    /// The first bytes belong to another format: to the one with this extension, if they tell.
    WrongFormat(Option<&'static str>),
    /// The file starts like its format, and then breaks off or contradicts itself. Lower case, no full stop.
    Damaged(String),
    /// The memory budget has no room for the pixels. None was decoded.
    TooLarge {
        /// The number of columns.
        width: u32,
        /// The number of rows.
        height: u32,
        /// The missing memory.
        shortage: OutOfMemory,
    },
    /// The file system refused, lookat does not support this kind of file, or the format cannot hold the picture.
    /// Lower case, no full stop.
    Refused(String),
}

impl ImageError {
    /// The error for a file to read.
    pub fn reading(path: &Path, fault: impl Into<ImageFault>) -> Self {
        ImageError { path: path.into(), is_output: false, fault: fault.into() }
    }

    /// The error for a file to write.
    pub fn writing(path: &Path, fault: impl Into<ImageFault>) -> Self {
        ImageError { path: path.into(), is_output: true, fault: fault.into() }
    }

    fn message(&self) -> String {
        let (path, action) = (self.path.display(), if self.is_output { "write" } else { "read" });
        match &self.fault {
            ImageFault::UnknownFormat => {
                let extension = self.path.extension().map(|extension| format!(".{}", extension.display()));
                let name = extension.unwrap_or_else(|| path.to_string());
                format!("unknown picture format `{name}`: lookat writes {}", Format::NAMES)
            }
            ImageFault::WrongFormat(None) => {
                let extension = self.path.extension().unwrap_or_default().to_ascii_uppercase();
                format!("{path} is not in the {} format", extension.display())
            }
            ImageFault::WrongFormat(Some(format)) => {
                format!("{path} does not match its extension: its contents are {format}")
            }
            ImageFault::Damaged(reason) => format!("{path} is damaged: {reason}"),
            ImageFault::TooLarge { width, height, shortage } => {
                format!("cannot {action} {path}, {width} x {height} pixels: {shortage}")
            }
            ImageFault::Refused(reason) => format!("cannot {action} {path}: {reason}"),
        }
    }
}

impl From<io::Error> for ImageFault {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::UnexpectedEof => ImageFault::Damaged("the file ends too early".into()),
            _ => ImageFault::Refused(io_reason(&error)),
        }
    }
}

/// The names as a message shows them.
pub(crate) fn listed(names: &[impl AsRef<str>]) -> String {
    const MOST: usize = 20;
    let shown = names.iter().take(MOST).map(|name| name.as_ref().escape_debug().to_string());
    let shown = shown.collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MOST) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// The reason of an I/O error: plain words for common ones, otherwise those of the operating system without its error code.
pub fn io_reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file or folder".into(),
        io::ErrorKind::PermissionDenied => "permission denied".into(),
        io::ErrorKind::IsADirectory => "it is a folder".into(),
        io::ErrorKind::NotADirectory => "it is not a folder".into(),
        io::ErrorKind::InvalidFilename => "the name is too long; most file systems take 255 bytes".into(),
        io::ErrorKind::FileTooLarge => "it is larger than a file may be (see ulimit -f)".into(),
        io::ErrorKind::StorageFull => "no space is left on the disk".into(),
        _ => {
            let text = error.to_string();
            text.split_once(" (os error").map_or(text.as_str(), |(words, _)| words).to_string()
        }
    }
}
