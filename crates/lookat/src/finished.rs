//! Finished pictures are not replaced without `--force`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use lookat_image::{Format, MemoryBudget, PictureFile, Window};
use serde::Deserialize;

use crate::output::is_among;

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
}

/// Fails if the file is a finished picture and stays.
pub fn check_unfinished(file: &Path, new: NewPicture, ways_out: &str) -> Result<(), String> {
    match why_kept(file, new) {
        None => Ok(()),
        Some(why) => Err(format!("{} is not replaced: {why}; {ways_out}", file.display())),
    }
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
    let samples = format!("it has {} samples per pixel", digits(made.samples_per_pixel));
    match new.samples_per_pixel {
        None => Some(format!("{samples}, and the number of the new picture is unknown")),
        Some(new) if made.samples_per_pixel > new * (1.0 + slack) => {
            Some(format!("{samples}, and the new picture {}", digits(new)))
        }
        Some(_) => None,
    }
}

/// A number of samples, rounded for people.
fn digits(samples: f64) -> f64 {
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
