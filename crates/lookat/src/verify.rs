//! `lookat verify`: compares scenes with the pictures beside them.

mod page;
mod scene;
mod table;

use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lookat_image::{Aligned, Image, io_reason, open_file};
use lookat_scene::LoadOptions;
use serde_json::Value;

use crate::args::{Report, Verify};
use crate::failure::Failure;
use crate::metric::Measurement;
use crate::output::{check_folder, check_inputs};
use crate::readable::repeated_command;
use crate::source::load_scene;

/// The result for one scene, from the best to the worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// Agrees with its reference.
    Agrees,
    /// Has no reference.
    New,
    /// The differences may be light that samples rarely hit.
    Undecided,
    /// Could not be compared.
    Trouble,
    /// Differs from its reference.
    Differs,
}

impl Verdict {
    /// In the order of the summary line.
    pub const ALL: [Verdict; 5] =
        [Verdict::Agrees, Verdict::Differs, Verdict::Undecided, Verdict::New, Verdict::Trouble];

    /// The word for one scene.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Agrees => "agrees",
            Verdict::New => "new",
            Verdict::Undecided => "undecided",
            Verdict::Trouble => "failed",
            Verdict::Differs => "differs",
        }
    }

    /// The word for `count` scenes.
    pub fn word_for(self, count: usize) -> &'static str {
        match self {
            Verdict::Agrees if count > 1 => "agree",
            Verdict::Differs if count > 1 => "differ",
            Verdict::New => "without a reference",
            Verdict::Trouble => "failed",
            _ => self.word(),
        }
    }
}

/// One scene with its verdict, and everything the report shows of it.
pub struct Outcome {
    /// The name of the scene file, without its ending.
    pub name: String,
    pub verdict: Verdict,
    /// The reason for the verdict, in a few words.
    pub reason: String,
    /// Whether `--update` wrote the reference.
    pub updated: bool,
    pub diagnostics: Diagnostics,
    /// `None` if the scene was not rendered.
    pub render: Option<Rendered>,
    /// `None` if there is no reference, or it cannot be read.
    pub reference: Option<Image>,
    /// `None` if there are not two pictures of one size.
    pub comparison: Option<SceneComparison>,
}

/// The messages of a scene file.
pub struct Diagnostics {
    /// As people read them. Empty without messages.
    pub text: String,
    /// As `lookat check --json` prints them.
    pub json: Value,
}

/// A picture, and how it was made.
pub struct Rendered {
    pub image: Image,
    pub samples_per_pixel: u32,
    pub seconds: f64,
}

/// A render and its reference, over the pixels of both.
pub struct SceneComparison {
    pub pair: Aligned,
    pub measurement: Measurement,
    /// The smallest bias of the mean that the test for noise finds in 95 of 100 renders, in the unit of the picture. `None`
    /// without that test.
    pub detectable: Option<f64>,
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
            page.add(page::scene(&outcome))?;
        }
    }
    table.footer(&verdicts)?;
    if let (Some(file), Some(page)) = (&arguments.report, page) {
        let title = format!("lookat verify {}", arguments.folder.display());
        page.write(file, &title, &repeated_command())?;
    }
    Ok(match () {
        () if verdicts.contains(&Verdict::Trouble) || verdicts.contains(&Verdict::Undecided) => {
            crate::TROUBLE
        }
        () => u8::from(updated || verdicts.contains(&Verdict::Differs)),
    })
}

/// The files that the scenes read, as far as a result could replace them. Reads the texts of the scenes, no meshes and no pictures.
fn inputs(arguments: &Verify, scenes: &[PathBuf]) -> BTreeSet<PathBuf> {
    if !arguments.update && arguments.report.as_ref().is_none_or(|report| !report.exists()) {
        return BTreeSet::new();
    }
    let options = LoadOptions { fast: true, max_memory: arguments.memory.limit(), ..LoadOptions::default() };
    let readable = scenes.iter().filter(|scene| why_unreadable(scene).is_none());
    let loaded = readable.map(|scene| load_scene(scene, &options, Report { strict: false, json: false }));
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
