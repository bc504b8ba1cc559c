//! `lookat verify`: compares scenes with the pictures beside them.

mod page;
mod scene;
mod table;

use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lookat_image::{io_reason, open_file};
use lookat_scene::LoadOptions;
use serde::{Serialize, Serializer};
use serde_json::Value;

use crate::args::{Report, Verify};
use crate::failure::Failure;
use crate::metric::Measured;
use crate::output::{check_folder, check_inputs};
use crate::readable::{count, repeated_command};
use crate::source::load_scene;
use crate::verify::page::Picture;

/// The result for one scene, from the best to the worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Agrees with its reference.
    Agrees,
    /// Has no reference.
    New,
    /// The differences may be light that samples rarely hit.
    Undecided,
    /// Could not be compared.
    Failed,
    /// Differs from its reference.
    Differs,
}

impl Verdict {
    /// In the order of the summary line.
    pub const ALL: [Verdict; 5] =
        [Verdict::Agrees, Verdict::Differs, Verdict::Undecided, Verdict::New, Verdict::Failed];

    /// The word for one scene.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Agrees => "agrees",
            Verdict::New => "new",
            Verdict::Undecided => "undecided",
            Verdict::Failed => "failed",
            Verdict::Differs => "differs",
        }
    }

    /// The word for `count` scenes.
    pub fn word_for(self, count: usize) -> &'static str {
        match self {
            Verdict::Agrees if count > 1 => "agree",
            Verdict::Differs if count > 1 => "differ",
            Verdict::New => "without a reference",
            _ => self.word(),
        }
    }
}

/// One scene with its verdict: what `--json` prints, and what the table and the report show.
#[derive(Debug, Clone, Serialize)]
pub struct Outcome {
    /// The file name without `.pbrt`.
    pub scene: String,
    /// `agrees`, `differs`, `undecided`, `new` or `failed`.
    pub verdict: Verdict,
    /// Why, in words.
    pub reason: String,
    /// True if the reference was written.
    pub updated: bool,
    /// The metrics by name.
    #[serde(serialize_with = "by_name")]
    pub metrics: Vec<Measured>,
    /// Smallest bias of the mean that the noise tests would find, in the picture's unit, or null.
    pub visible_in_mean: Option<f64>,
    /// Samples per pixel of the render, or null.
    pub samples_per_pixel: Option<u32>,
    /// The time to render, or null.
    pub seconds: Option<f64>,
    /// The messages of the scene file, as in `check`.
    pub diagnostics: Value,
    /// The messages of the scene file as text. Empty without messages.
    #[serde(skip)]
    pub messages: String,
    /// The mean value of the reference. `None` if there are not two pictures of one size.
    #[serde(skip)]
    pub mean: Option<f64>,
    /// With `--report`: the two pictures over each other, or each one alone if they cannot be compared.
    #[serde(skip)]
    pub pictures: Vec<Picture>,
}

/// Metrics with their values, in the order of their names.
fn by_name<S: Serializer>(metrics: &[Measured], serializer: S) -> Result<S::Ok, S::Error> {
    let values: BTreeMap<_, _> = metrics.iter().map(|line| (line.metric.name(), line.value)).collect();
    values.serialize(serializer)
}

/// Runs the command.
pub fn verify(arguments: &Verify) -> ExitCode {
    crate::exit_code(run(arguments))
}

/// Verifies all scenes of the folder. Returns the exit status.
fn run(arguments: &Verify) -> Result<u8, Failure> {
    let scenes = scene_files(&arguments.folder)?;
    if !arguments.update
        && scenes.iter().all(|scene| why_unreadable(scene).is_none() && beside(scene).next().is_none())
    {
        let folder = arguments.folder.display();
        bail!("no scene in {folder} has a reference picture; --update writes references");
    }
    let inputs = inputs(arguments, &scenes);
    if let Some(file) = &arguments.report {
        check_report(file)?;
        check_inputs(file, &inputs)?;
    }
    let table = table::Table::new(&scenes, arguments.json);
    table.header()?;
    let (mut verdicts, mut updated) = (Vec::new(), false);
    let mut page = arguments.report.as_ref().map(|_| page::Page::new()).transpose()?;
    for scene in &scenes {
        let outcome = scene::verify(arguments, scene, &inputs);
        table.row(&outcome)?;
        verdicts.push(outcome.verdict);
        updated |= outcome.updated;
        if let Some(page) = &mut page {
            page.add(outcome)?;
        }
    }
    table.footer(&verdicts)?;
    if let (Some(file), Some(page)) = (&arguments.report, page) {
        let title = format!("lookat verify {}", arguments.folder.display());
        page.write(file, &title, &repeated_command())?;
    }
    let has = |verdict| verdicts.contains(&verdict);
    let is_trouble = has(Verdict::Failed) || has(Verdict::Undecided);
    Ok(if is_trouble { crate::TROUBLE } else { u8::from(updated || has(Verdict::Differs)) })
}

/// "20 scenes: 18 agree, 1 differs, 1 failed". `mark` takes the words of each verdict.
fn summary(verdicts: &[Verdict], mark: impl Fn(Verdict, String) -> String) -> String {
    let words = |verdict: Verdict| {
        let count = verdicts.iter().filter(|other| **other == verdict).count();
        (count > 0).then(|| mark(verdict, format!("{count} {}", verdict.word_for(count))))
    };
    let words: Vec<String> = Verdict::ALL.into_iter().filter_map(words).collect();
    format!("{}: {}", count(verdicts.len() as u64, "scene"), words.join(", "))
}

/// The files that the scenes read, as far as a result could replace them. Reads the texts of the scenes, no meshes and no pictures.
fn inputs(arguments: &Verify, scenes: &[PathBuf]) -> BTreeSet<PathBuf> {
    if !arguments.update && arguments.report.as_ref().is_none_or(|report| !report.exists()) {
        return BTreeSet::new();
    }
    let options = LoadOptions { fast: true, max_memory: arguments.memory.limit(), ..LoadOptions::default() };
    let readable = scenes.iter().filter(|scene| why_unreadable(scene).is_none());
    let loaded = readable.map(|scene| load_scene(scene, &options, Report::default()));
    loaded.flat_map(|loaded| loaded.inputs).collect()
}

/// Fails if the report cannot be written, before hours of rendering.
fn check_report(file: &Path) -> Result<(), Failure> {
    let ending = file.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    if !["html", "htm"].contains(&ending) || file.is_dir() {
        bail!("{}: --report writes a web page; its name must end in .html", file.display());
    }
    check_folder(file)
}

/// Endings of references, in order of preference.
const ENDINGS: [&str; 7] = ["exr", "pfm", "hdr", "png", "tga", "jpg", "jpeg"];

/// Everything in a folder that is named as a scene file, by name: also folders and dangling links.
fn scene_files(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
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
fn scene_name(scene: &Path) -> String {
    scene.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Why a file cannot be read, and what to do. `None` if it can.
fn why_unreadable(file: &Path) -> Option<String> {
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
