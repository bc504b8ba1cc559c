//! What can go wrong with a picture file, in plain words.

use std::io;
use std::path::{Path, PathBuf};

use crate::{Format, OutOfMemory};

/// Why a picture could not be read or written. Its text names the file and is fit to be shown to the user.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ImageError {
    /// The path to write to has an extension that stands for no format, or has none.
    #[error("unknown picture format `{}`: lookat writes {}", extension(path), Format::NAMES)]
    UnknownFormat {
        /// The path as it was given.
        path: PathBuf,
    },
    /// The file system refused, or the picture does not fit the format. The target is as it was before.
    #[error("cannot write {}: {reason}", path.display())]
    Write {
        /// The path as it was given.
        path: PathBuf,
        /// Lower case, or the words of the operating system; no full stop.
        reason: String,
    },
    /// The file system refused, or the file is of a kind that lookat does not read, or has no such layer.
    #[error("cannot read {}: {reason}", path.display())]
    Read {
        /// The path as it was given.
        path: PathBuf,
        /// Lower case, or the words of the operating system; no full stop.
        reason: String,
    },
    /// The memory budget has no room for the pixels; none was decoded.
    #[error("cannot read {}, {width} x {height} pixels: {shortage}", path.display())]
    TooLarge {
        /// The path as it was given.
        path: PathBuf,
        /// The number of columns.
        width: u32,
        /// The number of rows.
        height: u32,
        /// What is missing.
        shortage: OutOfMemory,
    },
    /// The contents are not of the format that the extension claims.
    #[error("{} does not match its extension{}", path.display(), named(*format))]
    NotThatFormat {
        /// The path as it was given.
        path: PathBuf,
        /// The ending of the format that the contents are of, if they tell.
        format: Option<&'static str>,
    },
    /// The contents begin like the format and then break off or contradict themselves.
    #[error("{} is damaged: {reason}", path.display())]
    Damaged {
        /// The path as it was given.
        path: PathBuf,
        /// Lower case, no full stop.
        reason: String,
    },
}

impl ImageError {
    #[cfg(feature = "write")]
    pub(crate) fn writing(path: &Path, fault: Fault) -> Self {
        ImageError::Write { path: path.into(), reason: fault.reason() }
    }

    pub(crate) fn reading(path: &Path, fault: Fault) -> Self {
        let path = path.into();
        match fault {
            Fault::Foreign(format) => ImageError::NotThatFormat { path, format },
            Fault::Damaged(reason) => ImageError::Damaged { path, reason },
            Fault::TooLarge { width, height, shortage } => {
                ImageError::TooLarge { path, width, height, shortage }
            }
            Fault::Io(_) | Fault::Unfit(_) => ImageError::Read { path, reason: fault.reason() },
        }
    }
}

/// What the code of one format reports: an error that does not know its path yet.
#[derive(Debug)]
pub(crate) enum Fault {
    /// The file system refused.
    Io(io::Error),
    /// The file does not begin as the format does, but maybe as the one with this ending.
    Foreign(Option<&'static str>),
    /// The file begins as the format does, but cannot be right.
    Damaged(String),
    /// The memory budget has no room for the pixels.
    TooLarge { width: u32, height: u32, shortage: OutOfMemory },
    /// The format cannot hold the picture, or the picture is beyond what lookat handles.
    Unfit(String),
}

impl Fault {
    fn reason(self) -> String {
        match self {
            Fault::Io(error) => io_reason(&error),
            Fault::Foreign(format) => format!("the format is wrong{}", named(format)),
            Fault::TooLarge { shortage, .. } => shortage.to_string(),
            Fault::Damaged(reason) | Fault::Unfit(reason) => reason,
        }
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::UnexpectedEof => Fault::Damaged("the file ends too early".into()),
            _ => Fault::Io(error),
        }
    }
}

/// The names as a message shows them.
pub(crate) fn listed(names: &[impl AsRef<str>]) -> String {
    const MOST: usize = 20;
    let shown: Vec<String> =
        names.iter().take(MOST).map(|name| name.as_ref().escape_debug().to_string()).collect();
    let more = match names.len().saturating_sub(MOST) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    shown.join(", ") + &more
}

/// What a file is, as the end of a message.
fn named(format: Option<&'static str>) -> String {
    format.map_or_else(String::new, |ending| format!(": its contents are {ending}"))
}

/// Why something cannot be done with a file, for people: the words of the operating system, where there are no plainer ones,
/// without its number for them.
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

/// The extension with its dot, or else the whole path.
fn extension(path: &Path) -> String {
    match path.extension() {
        Some(extension) => format!(".{}", extension.display()),
        None => path.display().to_string(),
    }
}
