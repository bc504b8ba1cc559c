//! Why a command ends without its result.

use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lookat_image::{AlignError, ImageError, io_reason};

/// Returns from a function with an error message: a [`Failure`], or what else a text becomes.
macro_rules! bail {
    ($($message:tt)*) => {
        return Err(format!($($message)*).into())
    };
}

/// Prints a line to standard error. Ignores a closed standard error.
macro_rules! say {
    ($($line:tt)*) => {
        crate::say(&format!($($line)*))
    };
}

/// The exit status for a scene with errors.
pub const SCENE_FAULT: u8 = 1;

/// The exit status of `lookat resume` where there is no checkpoint, or none that is whole; `EX_NOINPUT` of sysexits.h.
const NO_CHECKPOINT: u8 = 66;

/// Why a command ends without its result. Its text is fit to be shown to the user.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Failure {
    /// The arguments do not fit together or do not fit the scene, or a request of a page cannot be granted.
    #[error("{0}")]
    Refused(String),
    /// The scene does not fit the memory limit.
    #[error("{0}")]
    TooLarge(String),
    /// The contents of a file are wrong, and will be when it is read again.
    #[error("{0}")]
    Damaged(String),
    /// There is no checkpoint, or all that there is is damaged.
    #[error("{0}")]
    NoCheckpoint(String),
    /// A file or folder cannot be read or written.
    #[error("cannot {doing} {}: {reason}", path.display())]
    File { doing: &'static str, path: PathBuf, reason: String },
    #[error(transparent)]
    Picture(#[from] ImageError),
    #[error(transparent)]
    Alignment(#[from] AlignError),
    /// Standard output cannot be written.
    #[error("cannot write to standard output")]
    Unwritten,
}

impl Failure {
    /// A file or folder that cannot be written.
    pub fn write(path: &Path, reason: impl Into<String>) -> Failure {
        Failure::File { doing: "write", path: path.into(), reason: reason.into() }
    }

    /// A file or folder on which the system refuses an operation, such as "write".
    pub fn io(doing: &'static str, path: &Path, error: &io::Error) -> Failure {
        Failure::File { doing, path: path.into(), reason: io_reason(error) }
    }

    /// The exit status.
    pub fn status(&self) -> u8 {
        match self {
            Failure::TooLarge(_) => SCENE_FAULT,
            Failure::NoCheckpoint(_) => NO_CHECKPOINT,
            _ => crate::TROUBLE,
        }
    }
}

impl From<String> for Failure {
    fn from(message: String) -> Failure {
        Failure::Refused(message)
    }
}

impl From<&str> for Failure {
    fn from(message: &str) -> Failure {
        message.to_owned().into()
    }
}

impl From<Failure> for String {
    fn from(failure: Failure) -> String {
        failure.to_string()
    }
}

/// The exit status of a command. Prints its error message.
pub fn exit_code(result: Result<u8, impl Into<Failure>>) -> ExitCode {
    ExitCode::from(result.unwrap_or_else(|failure| {
        let failure = failure.into();
        say!("error: {failure}");
        failure.status()
    }))
}
