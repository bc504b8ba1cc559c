//! Output files: checked before the computation, and written to another folder if their own fails.

use std::ffi::OsStr;
use std::fs::OpenOptions;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use lookat_image::{Format, ImageError, io_reason, write_target};

/// Fails if a picture of this width and height cannot be written.
pub fn check_output(file: &Path, size: [u32; 2]) -> Result<(), String> {
    let name = file.display();
    let Some(format) = Format::from_path(file) else {
        if file.is_dir() {
            let path = file.join("picture.exr");
            return Err(format!("cannot write {name}: it is a folder; write {}", path.display()));
        }
        return Err(format!("{name}: lookat writes {}; choose the format by the extension", Format::NAMES));
    };
    let most = format.most_side();
    if size.iter().any(|side| *side > most) {
        return Err(format!("cannot write {name}: this format has at most {most} pixels per side"));
    }
    check_folder(file)
}

/// Fails if a result would replace one of its inputs.
pub fn check_inputs<'i>(file: &Path, inputs: impl IntoIterator<Item = &'i PathBuf>) -> Result<(), String> {
    match is_among(file, inputs) {
        true => Err(format!("cannot write {}: this file is an input; choose another name", file.display())),
        false => Ok(()),
    }
}

/// True if `file` is one of `files`, even under another name or through a link.
pub fn is_among<'i>(file: &Path, files: impl IntoIterator<Item = &'i PathBuf>) -> bool {
    let Some(file) = Identity::of(file) else { return false };
    files.into_iter().any(|other| Identity::of(other).is_some_and(|other| other == file))
}

/// What an existing file or folder has under all its names.
#[derive(Debug, PartialEq, Eq)]
pub struct Identity(
    /// The numbers of the device and, on it, of the file.
    #[cfg(unix)]
    [u64; 2],
    /// The path without links.
    #[cfg(not(unix))]
    PathBuf,
);

impl Identity {
    #[cfg(unix)]
    pub fn of(file: &Path) -> Option<Identity> {
        use std::os::unix::fs::MetadataExt;

        let found = std::fs::metadata(file).ok()?;
        Some(Identity([found.dev(), found.ino()]))
    }

    #[cfg(not(unix))]
    pub fn of(file: &Path) -> Option<Identity> {
        file.canonicalize().ok().map(Identity)
    }
}

/// Fails unless this file can be written: its folder accepts files, its name is valid, and it is not a folder itself.
/// Leaves no file behind.
pub fn check_folder(file: &Path) -> Result<(), String> {
    if file.is_dir() {
        return cannot(file, "it is a folder");
    }
    // A `Path` ignores a slash at its end, but the file system does not.
    let name = file.file_name().unwrap_or_default();
    if !file.as_os_str().as_encoded_bytes().ends_with(name.as_encoded_bytes()) {
        let path = file.with_file_name(name);
        return cannot(file, &format!("it ends in a separator; write {}", path.display()));
    }
    let (target, folder) = write_target(file).or_else(|error| cannot(file, &io_reason(&error)))?;
    if !folder.is_dir() {
        return cannot(
            file,
            &match folder.ancestors().find(|parent| parent.is_file()) {
                Some(file) => format!("{} is a file, not a folder", file.display()),
                None => format!("there is no folder {}", folder.display()),
            },
        );
    }
    match try_writing(&target, &folder) {
        Ok(()) => Ok(()),
        Err(error) => cannot(file, &io_reason(&error)),
    }
}

fn cannot<T>(file: &Path, reason: &str) -> Result<T, String> {
    Err(format!("cannot write {}: {reason}", file.display()))
}

/// Tries the file operations that writing needs.
fn try_writing(target: &Path, folder: &Path) -> io::Result<()> {
    match std::fs::symlink_metadata(target) {
        // Replacing a file does not need permission to write it, so check the permission here.
        Ok(_) => drop(OpenOptions::new().write(true).open(target)?),
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        // For example, the name is too long.
        Err(error) => return Err(error),
    }
    // The file has no name, so that nothing is left even if the program is killed. It has contents, because a full disk
    // accepts empty files.
    tempfile::tempfile_in(folder)?.write_all(&[0; 4096])
}

/// The folder for results. If it stops accepting files (a full disk, a removed folder), the results go to a new folder
/// in the working folder, or else in the folder for temporary files.
pub struct Destination {
    folder: PathBuf,
    /// The first error of the requested folder, if the results are in another folder.
    refusal: Option<String>,
}

impl Destination {
    pub fn new(folder: &Path) -> Destination {
        Destination { folder: folder.into(), refusal: None }
    }

    /// The folder of the last result.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Writes a file of this name: calls `write` with its path, and returns the path. If `write` fails, tries other
    /// folders. Fails if no folder accepts the file.
    pub fn write(
        &mut self,
        name: &OsStr,
        write: impl Fn(&Path) -> Result<(), ImageError>,
    ) -> Result<PathBuf, String> {
        let file = self.folder.join(name);
        let Err(error) = write(&file) else { return Ok(file) };
        let places = [std::env::current_dir().unwrap_or_default(), std::env::temp_dir()];
        let rescued = places.iter().find_map(|place| {
            let folder = tempfile::Builder::new().prefix("lookat-rescued-").tempdir_in(place).ok()?;
            write(&folder.path().join(name)).ok()?;
            Some(folder.keep())
        });
        let Some(folder) = rescued else {
            let temporary = places[1].display();
            return Err(format!(
                "{error}; writing to the working folder and to {temporary} also failed: the result is lost"
            ));
        };
        self.folder = folder;
        self.refusal.get_or_insert(error.to_string());
        Ok(self.folder.join(name))
    }

    /// Fails if results are not in the requested folder. The error says where they are.
    pub fn result(&self) -> Result<(), String> {
        let Some(refusal) = &self.refusal else { return Ok(()) };
        Err(format!("{refusal}; the result is in {} instead", self.folder.display()))
    }
}

/// Writes one file. Fails if the file is not in the requested place; the error says where it is.
pub fn write_result(file: &Path, write: impl Fn(&Path) -> Result<(), ImageError>) -> Result<(), String> {
    let mut destination = Destination::new(file.parent().unwrap_or(Path::new("")));
    destination.write(file.file_name().unwrap_or_default(), write)?;
    destination.result()
}

/// Creates a folder and its parents.
pub fn make_folder(folder: &Path) -> Result<(), String> {
    std::fs::create_dir_all(folder).map_err(|error| not_created(folder, &error))
}

/// Fails unless this folder exists or can be created. Leaves no folder behind.
pub fn check_new_folder(folder: &Path) -> Result<(), String> {
    let parent = folder.ancestors().find(|parent| parent.exists()).unwrap_or(Path::new("."));
    tempfile::tempdir_in(parent).map(drop).map_err(|error| not_created(folder, &error))
}

fn not_created(folder: &Path, error: &io::Error) -> String {
    let reason = match folder.ancestors().find(|parent| parent.is_file()) {
        Some(file) => format!("{} is a file", file.display()),
        None => io_reason(error),
    };
    format!("cannot create the folder {}: {reason}", folder.display())
}
