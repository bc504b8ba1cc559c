//! The scenes of a folder, and the references beside them.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use lookat_image::{io_reason, open_file};

use crate::failure::Failure;

/// Endings of references, in order of preference.
const ENDINGS: [&str; 7] = ["exr", "pfm", "hdr", "png", "tga", "jpg", "jpeg"];

/// Everything in a folder that is named as a scene file, by name: also folders and dangling links.
pub fn scene_files(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let cannot = |error: std::io::Error| format!("cannot read {}: {}", folder.display(), io_reason(&error));
    let entries: Result<Vec<_>, _> = std::fs::read_dir(folder).map_err(cannot)?.collect();
    let mut files: Vec<PathBuf> = entries.map_err(cannot)?.into_iter().map(|entry| entry.path()).collect();
    files.retain(|file| file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("pbrt")));
    files.sort();
    if files.is_empty() {
        Err(format!("there is no .pbrt file in {}", folder.display()).into())
    } else {
        Ok(files)
    }
}

/// Everything beside a scene that is named as its reference, the preferred one first: also folders and dangling links.
pub fn beside(scene: &Path) -> impl Iterator<Item = PathBuf> {
    let exists = |file: &PathBuf| file.symlink_metadata().is_ok();
    let spellings = ENDINGS.iter().flat_map(|ending| [ending.to_string(), ending.to_uppercase()]);
    spellings.map(|ending| scene.with_extension(ending)).filter(exists)
}

/// The name of a scene: the name of its file, without the ending.
pub fn scene_name(scene: &Path) -> String {
    scene.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Why a file cannot be read, and what to do. `None` if it can.
pub fn why_unreadable(file: &Path) -> Option<String> {
    let name = file.display();
    let cannot_read = |error| Some(format!("cannot read {name}: {}", io_reason(&error)));
    match std::fs::metadata(file) {
        Ok(found) if found.is_dir() => Some(format!("{name} is a folder, not a file; rename the folder")),
        // Opening a pipe waits for a writer.
        Ok(found) if !found.is_file() => Some(format!("{name} is a pipe or a device, not a file; rename it")),
        Ok(_) => open_file(file).err().and_then(cannot_read),
        Err(error) => match (error.kind(), std::fs::read_link(file)) {
            (ErrorKind::NotFound, Ok(target)) => {
                let target = target.display();
                Some(format!(
                    "{name} is a link to {target}, where there is no file; restore it or remove the link"
                ))
            }
            _ => cannot_read(error),
        },
    }
}
