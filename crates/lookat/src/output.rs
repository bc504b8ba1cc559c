//! Output files: checked before the computation, and written to another folder if their own fails. Finished pictures are not replaced
//! without `--force`.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use lookat_image::{Format, ImageError, MemoryBudget, PictureFile, Window, io_reason, write_target};
use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::failure::Failure;

/// Fails if a picture of this width and height cannot be written.
pub fn check_output(file: &Path, size: [u32; 2]) -> Result<(), Failure> {
    let name = file.display();
    let Some(format) = Format::from_path(file) else {
        if file.is_dir() {
            let path = file.join("picture.exr");
            bail!("cannot write {name}: it is a folder; write {}", path.display());
        }
        bail!("{name}: lookat writes {}; choose the format by the extension", Format::NAMES);
    };
    let most = format.most_side();
    if size.iter().any(|side| *side > most) {
        bail!("cannot write {name}: this format has at most {most} pixels per side");
    }
    check_folder(file)
}

/// Fails if a result would replace one of its inputs.
pub fn check_inputs<'i>(file: &Path, inputs: impl IntoIterator<Item = &'i PathBuf>) -> Result<(), Failure> {
    if is_among(file, inputs) {
        Err(format!("cannot write {}: this file is an input; choose another name", file.display()).into())
    } else {
        Ok(())
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

    /// That of an open file, which had this name when it was opened.
    #[cfg(unix)]
    pub fn of_open(file: &File, _name: &Path) -> Option<Identity> {
        use std::os::unix::fs::MetadataExt;

        let found = file.metadata().ok()?;
        Some(Identity([found.dev(), found.ino()]))
    }

    #[cfg(not(unix))]
    pub fn of_open(_file: &File, name: &Path) -> Option<Identity> {
        Identity::of(name)
    }
}

/// What is the same for all paths to a file, also to one that does not exist yet: itself, or its folder and its name there.
pub fn place(file: &Path) -> (Option<Identity>, Option<&OsStr>) {
    let folder = match file.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    match Identity::of(file) {
        None => (Identity::of(folder), file.file_name()),
        found => (found, None),
    }
}

/// Fails unless this file can be written: its folder accepts files, its name is valid, and it is not a folder itself.
/// Leaves no file behind.
pub fn check_folder(file: &Path) -> Result<(), Failure> {
    if file.is_dir() {
        return Err(Failure::write(file, "it is a folder"));
    }
    // A `Path` ignores a slash at its end, but the file system does not.
    let name = file.file_name().unwrap_or_default();
    if !file.as_os_str().as_encoded_bytes().ends_with(name.as_encoded_bytes()) {
        let path = file.with_file_name(name);
        return Err(Failure::write(file, format!("it ends in a separator; write {}", path.display())));
    }
    let (target, folder) = write_target(file).map_err(|error| Failure::io("write", file, &error))?;
    if !folder.is_dir() {
        let reason = match folder.ancestors().find(|parent| parent.is_file()) {
            Some(file) => format!("{} is a file, not a folder", file.display()),
            None => format!("there is no folder {}", folder.display()),
        };
        return Err(Failure::write(file, reason));
    }
    try_writing(&target, &folder).map_err(|error| Failure::io("write", file, &error))
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
    ) -> Result<PathBuf, Failure> {
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
            bail!(
                "{error}; writing to the working folder and to {temporary} also failed: the result is lost"
            );
        };
        self.folder = folder;
        self.refusal.get_or_insert(error.to_string());
        Ok(self.folder.join(name))
    }

    /// Fails if results are not in the requested folder. The error says where they are.
    pub fn result(&self) -> Result<(), Failure> {
        let Some(refusal) = &self.refusal else { return Ok(()) };
        Err(format!("{refusal}; the result is in {} instead", self.folder.display()).into())
    }
}

/// Writes one file. Fails if the file is not in the requested place; the error says where it is.
pub fn write_result(file: &Path, write: impl Fn(&Path) -> Result<(), ImageError>) -> Result<(), Failure> {
    let mut destination = Destination::new(file.parent().unwrap_or(Path::new("")));
    destination.write(file.file_name().unwrap_or_default(), write)?;
    destination.result()
}

/// Creates a folder and its parents.
pub fn make_folder(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| not_created(folder, &error))
}

/// Fails unless this folder exists or can be created. Leaves no folder behind.
pub fn check_new_folder(folder: &Path) -> Result<(), Failure> {
    let parent = folder.ancestors().find(|parent| parent.exists()).unwrap_or(Path::new("."));
    tempfile::tempdir_in(parent).map(drop).map_err(|error| not_created(folder, &error))
}

fn not_created(folder: &Path, error: &io::Error) -> Failure {
    let reason = match folder.ancestors().find(|parent| parent.is_file()) {
        Some(file) => format!("{} is a file", file.display()),
        None => io_reason(error),
    };
    Failure::File { doing: "create the folder", path: folder.into(), reason }
}

/// The mark of a picture that is not complete, in its name.
pub const PARTIAL: &str = "partial";

/// A picture that is to be written.
#[derive(Debug, Clone, Copy)]
pub struct NewPicture {
    /// Width and height.
    pub size: [u32; 2],
    /// The mean, or the most that it can have. `None` if nobody knows.
    pub samples_per_pixel: Option<f64>,
    /// True if noise decides the number of samples: then [`SLACK`] counts as the same number.
    pub is_adaptive: bool,
    /// True for the result of an interruption, which goes to a name for such results.
    pub is_partial: bool,
}

/// The share by which numbers of samples differ between seeds.
const SLACK: f64 = 0.05;

/// What decides about an existing picture, of its metadata.
#[derive(Deserialize)]
struct Made {
    samples_per_pixel: f64,
    complete: bool,
    /// Its sums, which the metadata of parts describe.
    #[serde(default)]
    part: Option<IgnoredAny>,
}

/// Fails if the file is a finished picture and stays.
pub fn check_unfinished(file: &Path, new: NewPicture, ways_out: &str) -> Result<(), Failure> {
    match why_kept(file, new) {
        None => Ok(()),
        Some(why) => Err(format!("{} is not replaced: {why}; {ways_out}", file.display()).into()),
    }
}

/// Fails if the file, which a command makes of other pictures, is a finished picture that stays.
pub fn check_replaced(file: &Path, size: [u32; 2], samples_per_pixel: Option<f64>) -> Result<(), Failure> {
    let new = NewPicture { size, samples_per_pixel, is_adaptive: false, is_partial: false };
    check_unfinished(file, new, "replace it with --force, or choose another name")
}

/// The file for a picture: the named one or, if that is a finished picture, one beside it with a number. Also why.
pub fn free_file(file: PathBuf, new: NewPicture, inputs: &BTreeSet<PathBuf>) -> (PathBuf, Option<String>) {
    let Some(why) = why_kept(&file, new) else { return (file, None) };
    let is_free = |file: &PathBuf| !is_among(file, inputs) && why_kept(file, new).is_none();
    let why = format!("{} is not replaced: {why}", file.display());
    let beside = (2..u32::MAX).map(|number| marked(&file, &number.to_string())).find(is_free);
    (beside.unwrap_or(file), Some(why))
}

/// Why an existing file must stay. `None` if there is none, or a new picture may replace it. Reads the header alone.
fn why_kept(file: &Path, new: NewPicture) -> Option<String> {
    // Programs that reserve a name leave an empty file.
    if std::fs::metadata(file).map_or(true, |found| found.len() == 0) {
        return None;
    }
    if let Some(format @ (Format::Pfm | Format::Tga)) = Format::from_path(file) {
        let name = if format == Format::Pfm { "pfm" } else { "tga" };
        return Some(format!("a {name} file stores no render settings"));
    }
    let opened = match PictureFile::open(file, &MemoryBudget::default()) {
        Ok(opened) => opened,
        Err(error) => return Some(error.to_string()),
    };
    let made = opened.metadata().and_then(|text| serde_json::from_str::<Made>(&text).ok());
    let Some(made) = made else { return Some("another program made it".into()) };
    if !made.complete && !new.is_partial {
        return None;
    }
    let Window { width, height, .. } = opened.placement().data_window;
    let [new_width, new_height] = new.size;
    if u64::from(width) * u64::from(height) > u64::from(new_width) * u64::from(new_height) {
        return Some(format!(
            "it has {width} x {height} pixels, and the new picture {new_width} x {new_height}"
        ));
    }
    let slack = if new.is_adaptive { SLACK } else { 0.0 };
    let samples = format!("it has {} samples per pixel", rounded(made.samples_per_pixel));
    match new.samples_per_pixel {
        None => Some(format!("{samples}, and the number of the new picture is unknown")),
        Some(new) if made.samples_per_pixel > new * (1.0 + slack) => {
            Some(format!("{samples}, and the new picture {}", rounded(new)))
        }
        Some(_) => None,
    }
}

/// True for a picture of lookat that lacks samples, and has no sums.
pub fn is_interrupted(file: &Path) -> bool {
    let opened = PictureFile::open(file, &MemoryBudget::default());
    let text = opened.ok().and_then(|opened| opened.metadata());
    let made = text.and_then(|text| serde_json::from_str::<Made>(&text).ok());
    made.is_some_and(|made| !made.complete && made.part.is_none())
}

/// A number of samples with two decimals.
fn rounded(samples: f64) -> f64 {
    (100.0 * samples).round() / 100.0
}

/// The name of a file with a mark before its ending: `a.exr` becomes `a.partial.exr`. As long as a file name may be.
pub fn marked(file: &Path, mark: &str) -> PathBuf {
    const LONGEST: usize = 255;
    let ending = match file.extension() {
        Some(extension) => format!(".{mark}.{}", extension.display()),
        None => format!(".{mark}"),
    };
    let stem = file.file_stem().unwrap_or_default();
    let mut name = stem.to_owned();
    if stem.len() + ending.len() > LONGEST {
        let mut stem = stem.to_string_lossy().into_owned();
        while stem.len() + ending.len() > LONGEST && stem.pop().is_some() {}
        name = stem.into();
    }
    name.push(ending);
    file.with_file_name(name)
}
