//! Where results go: looked at before they are computed.

use std::path::{Path, PathBuf};

use lookat_image::{Format, io_reason, write_target};

/// Fails where a picture of this width and height could not be written in the end.
pub fn check_output(file: &Path, size: [u32; 2]) -> Result<(), String> {
    let name = file.display();
    let Some(format) = Format::from_path(file) else {
        return Err(format!("{name}: lookat writes {}; choose one by the ending, with -o", Format::NAMES));
    };
    let most = format.most_side();
    if size.iter().any(|side| *side > most) {
        return Err(format!("cannot write {name}: such a file is at most {most} pixels wide and high"));
    }
    check_folder(file)
}

/// Fails where a result would replace one of the files that it is made from.
pub fn check_inputs<'i>(file: &Path, inputs: impl IntoIterator<Item = &'i PathBuf>) -> Result<(), String> {
    match is_among(file, inputs) {
        true => Err(format!("cannot write {}: the result is made from what is there", file.display())),
        false => Ok(()),
    }
}

/// Whether it is one of some files, by whatever name.
pub fn is_among<'i>(file: &Path, files: impl IntoIterator<Item = &'i PathBuf>) -> bool {
    let Ok(file) = file.canonicalize() else { return false };
    files.into_iter().any(|other| other.canonicalize().is_ok_and(|other| other == file))
}

/// Fails where there is no folder to write a file to, or none that may be written to, or one in its place.
pub fn check_folder(file: &Path) -> Result<(), String> {
    if file.is_dir() {
        return Err(format!("cannot write {}: it is a folder", file.display()));
    }
    let Some((target, folder)) = write_target(file) else {
        return Err(format!("cannot write {}: what is there is not a file", file.display()));
    };
    // It would be replaced, which takes no leave to write to it.
    if target.exists() {
        let opened = std::fs::OpenOptions::new().write(true).open(&target);
        opened.map_err(|error| format!("cannot write {}: {}", file.display(), io_reason(&error)))?;
    }
    if !folder.is_dir() {
        return Err(format!("cannot write {}: there is no folder {}", file.display(), folder.display()));
    }
    // Without a name: nothing is left.
    tempfile::tempfile_in(folder)
        .map_err(|error| format!("cannot write {}: {}", file.display(), io_reason(&error)))?;
    Ok(())
}

/// Makes a folder, and those that it is in.
pub fn make_folder(folder: &Path) -> Result<(), String> {
    if folder.is_file() {
        return Err(format!("cannot make the folder {}: what is there is a file", folder.display()));
    }
    std::fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make the folder {}: {}", folder.display(), io_reason(&error)))
}
