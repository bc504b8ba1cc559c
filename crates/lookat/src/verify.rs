//! `lookat verify`: scenes against the pictures beside them.

mod page;
mod report_page;
mod table;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use lookat_image::{Aligned, Format, Image, align, io_reason, write_file};
use lookat_render::Settings;
use lookat_scene::{Overrides, Scene};

use crate::args::{Report, Verify};
use crate::metric::{Limit, Measurement, Metric, measure, not_finite};
use crate::output::{check_folder, check_inputs, is_among};
use crate::render::{Metadata, note_jitter};
use crate::source::load_scene;
use crate::{noise, report};

/// Endings of references, in the order in which they are looked for.
const ENDINGS: [&str; 7] = ["exr", "pfm", "hdr", "png", "tga", "jpg", "jpeg"];

/// What is to be said of a scene, from the best to the worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// It agrees with its reference.
    Agrees,
    /// It has no reference.
    New,
    /// It could not be told.
    Trouble,
    /// It differs from its reference.
    Differs,
}

impl Verdict {
    /// In the order in which they are counted.
    pub const ALL: [Verdict; 4] = [Verdict::Agrees, Verdict::Differs, Verdict::New, Verdict::Trouble];

    /// What is said of one scene.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Agrees => "agrees",
            Verdict::New => "new",
            Verdict::Trouble => "trouble",
            Verdict::Differs => "differs",
        }
    }

    /// What is said of so many.
    pub fn word_for(self, count: usize) -> &'static str {
        match self {
            Verdict::Agrees if count > 1 => "agree",
            Verdict::Differs if count > 1 => "differ",
            Verdict::New => "without a reference",
            Verdict::Trouble => "in trouble",
            _ => self.word(),
        }
    }
}

/// A scene that was looked at.
pub struct Outcome {
    pub name: String,
    pub verdict: Verdict,
    /// Why, in a few words.
    pub reason: String,
    /// The reference was written.
    pub updated: bool,
    /// What was compared, if it came to that.
    pub compared: Option<Compared>,
}

/// A render and its reference.
pub struct Compared {
    pub pair: Aligned,
    pub measurement: Measurement,
    pub samples_per_pixel: u32,
    pub seconds: f64,
}

/// A picture, and how long it took.
struct Rendered {
    image: Image,
    samples_per_pixel: u32,
    seconds: f64,
}

/// Runs the command.
pub fn verify(arguments: &Verify) -> ExitCode {
    crate::exit_code(run(arguments))
}

/// Looks at all scenes of the folder; the exit status.
fn run(arguments: &Verify) -> Result<u8, String> {
    let scenes = scenes(&arguments.folder)?;
    if !arguments.update && !scenes.iter().any(|scene| beside(scene).next().is_some()) {
        let folder = arguments.folder.display();
        return Err(format!(
            "no scene in {folder} has a picture of the same name beside it; --update writes them"
        ));
    }
    if let Some(file) = &arguments.report {
        check_report(file)?;
    }
    let table = table::Table::new(&scenes, arguments.json);
    table.header()?;
    let (mut verdicts, mut updated, mut pages) = (Vec::new(), false, Vec::new());
    for scene in &scenes {
        let outcome = look_at(arguments, scene);
        table.row(&outcome)?;
        verdicts.push(outcome.verdict);
        updated |= outcome.updated;
        if arguments.report.is_some() {
            pages.push(report_page::scene(&outcome));
        }
    }
    table.footer(&verdicts)?;
    if let Some(file) = &arguments.report {
        let title = format!("lookat verify {}", arguments.folder.display());
        write_file(file, page::page(&title, &pages).as_bytes()).map_err(|error| error.to_string())?;
    }
    Ok(match () {
        () if verdicts.contains(&Verdict::Trouble) => crate::TROUBLE,
        () => u8::from(updated || verdicts.contains(&Verdict::Differs)),
    })
}

/// Fails where no page can be written, before hours of rendering.
fn check_report(file: &Path) -> Result<(), String> {
    let ending = file.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    if !["html", "htm"].contains(&ending) || file.is_dir() {
        return Err(format!("{}: --report writes a page; its name must end in .html", file.display()));
    }
    check_folder(file)
}

/// The scene files of a folder, by name.
fn scenes(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let cannot = |error: std::io::Error| format!("cannot read {}: {}", folder.display(), io_reason(&error));
    let entries: Result<Vec<_>, _> = std::fs::read_dir(folder).map_err(cannot)?.collect();
    let mut files: Vec<PathBuf> = entries.map_err(cannot)?.into_iter().map(|entry| entry.path()).collect();
    files.retain(|file| {
        file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("pbrt")) && file.is_file()
    });
    files.sort();
    if files.is_empty() { Err(format!("there is no .pbrt file in {}", folder.display())) } else { Ok(files) }
}

/// The pictures beside a scene that may be its reference, the likeliest first.
fn beside(scene: &Path) -> impl Iterator<Item = PathBuf> {
    ENDINGS.iter().map(|ending| scene.with_extension(ending)).filter(|file| file.is_file())
}

/// The name of a scene: that of its file.
fn name(scene: &Path) -> String {
    scene.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Renders a scene and holds it against its reference.
fn look_at(arguments: &Verify, file: &Path) -> Outcome {
    let outcome = |verdict, reason: String| Outcome {
        name: name(file),
        verdict,
        reason,
        updated: false,
        compared: None,
    };
    if !arguments.update && beside(file).next().is_none() {
        return outcome(Verdict::New, "no picture beside it".into());
    }
    let overrides = Overrides { samples_per_pixel: arguments.spp, ..Overrides::default() };
    let report = Report { strict: false, json: false };
    let loaded = load_scene(file, &overrides, report);
    report::print(&loaded, false);
    let Some(scene) = &loaded.scene else { return outcome(Verdict::Trouble, "the scene has errors".into()) };
    note_jitter(scene, &loaded);
    // What the scene shows is no picture of it.
    let reference = beside(file).find(|picture| !is_among(picture, &loaded.inputs));
    if reference.is_none() && !arguments.update {
        return outcome(Verdict::New, "no picture beside it but one that it shows".into());
    }
    if arguments.update
        && let Some(reference) = &reference
        && Format::from_path(reference).is_none()
    {
        let reason = format!("{}: --update writes {}; remove it first", reference.display(), Format::NAMES);
        return outcome(Verdict::Trouble, reason);
    }
    let rendered = render(arguments, file, scene);
    let mut outcome = match &reference {
        None => outcome(Verdict::New, "no picture beside it".into()),
        Some(reference) => match hold_against(arguments, &rendered, reference) {
            Ok((verdict, reason, compared)) => Outcome { compared, ..outcome(verdict, reason) },
            Err(message) => outcome(Verdict::Trouble, message),
        },
    };
    if arguments.update && matches!(outcome.verdict, Verdict::Differs | Verdict::New) {
        let target = reference.unwrap_or_else(|| file.with_extension("exr"));
        match check_folder(&target).and_then(|()| check_inputs(&target, &loaded.inputs)) {
            Ok(()) => update(&rendered, &target, &mut outcome),
            Err(message) => (outcome.verdict, outcome.reason) = (Verdict::Trouble, message),
        }
    }
    outcome
}

/// Writes a new reference.
fn update(rendered: &Rendered, target: &Path, outcome: &mut Outcome) {
    match rendered.image.write(target) {
        Ok(()) => {
            outcome.updated = true;
            let samples = rendered.samples_per_pixel;
            outcome.reason += &format!("; wrote {}, {samples} samples per pixel", target.display());
        }
        Err(error) => {
            outcome.verdict = Verdict::Trouble;
            outcome.reason = error.to_string();
        }
    }
}

fn render(arguments: &Verify, file: &Path, scene: &Scene) -> Rendered {
    let samples_per_pixel = scene.sampler.samples_per_pixel;
    let settings = Settings {
        seed: arguments.seed,
        threads: arguments.threads.map_or(0, usize::from),
        // Always, so that limits are those of the picture that they were read from.
        error_layers: samples_per_pixel > 1,
        ..Settings::default()
    };
    let started = Instant::now();
    let mut image = lookat_render::render(scene, &settings, &|_| ControlFlow::Continue(())).image;
    let seconds = started.elapsed().as_secs_f64();
    image.metadata = Metadata::new(file, arguments.seed, f64::from(samples_per_pixel), true).as_json();
    Rendered { image, samples_per_pixel, seconds }
}

/// Compares a render with the reference in a file.
fn hold_against(
    arguments: &Verify,
    rendered: &Rendered,
    reference: &Path,
) -> Result<(Verdict, String, Option<Compared>), String> {
    let expected = Image::read(reference).map_err(|error| error.to_string())?;
    let pair = match align(&rendered.image, &expected) {
        Ok(pair) => pair,
        Err(error) => return Ok((Verdict::Differs, error.to_string(), None)),
    };
    let broken = [("render", &pair.actual), ("reference", &pair.expected)]
        .into_iter()
        .find_map(|(which, pixels)| not_finite(pixels, &pair).map(|(count, _)| (which, count)));
    let measurement = measure(&pair, THRESHOLD, &|_| broken.is_none());
    let (verdict, reason) = match broken {
        Some((which, count)) => (Verdict::Differs, not_finite_words(which, count)),
        None if pair.left_out > 0 => {
            (Verdict::Differs, format!("only one of the pictures has {} of the pixels", pair.left_out))
        }
        None => judge(arguments, &pair, &measurement)?,
    };
    let Rendered { samples_per_pixel, seconds, .. } = *rendered;
    Ok((verdict, reason, Some(Compared { pair, measurement, samples_per_pixel, seconds })))
}

fn not_finite_words(which: &str, count: usize) -> String {
    match count {
        1 => format!("1 pixel of the {which} is not finite"),
        _ => format!("{count} pixels of the {which} are not finite"),
    }
}

/// The threshold of share-above.
const THRESHOLD: f32 = 0.01;

/// Whether what was measured is within the limits or, without any, within noise.
fn judge(arguments: &Verify, pair: &Aligned, measurement: &Measurement) -> Result<(Verdict, String), String> {
    let default = [Limit { metric: Metric::NoiseP, value: noise::SIGNIFICANCE }];
    let limits = if arguments.max.is_empty() { &default[..] } else { &arguments.max[..] };
    if let Some(reason) = measurement.lacks(limits) {
        let other =
            if arguments.max.is_empty() { "; --max sets other limits, such as rmse=0.01" } else { "" };
        return Err(reason + other);
    }
    let beyond = measurement.metrics.iter().filter(|line| line.is_beyond(limits));
    let beyond: Vec<&str> = beyond.map(|line| line.metric.name()).collect();
    Ok(match beyond.as_slice() {
        [] if pair.actual == pair.expected => (Verdict::Agrees, "identical".into()),
        [] if arguments.max.is_empty() => (Verdict::Agrees, "within noise".into()),
        [] => (Verdict::Agrees, "within the limits".into()),
        _ if arguments.max.is_empty() => {
            let found = match &measurement.agreement {
                Some(Ok(found)) => noise::differences(found, noise::SIGNIFICANCE),
                _ => Vec::new(),
            };
            (Verdict::Differs, format!("by more than noise: {}", found.join("; ")))
        }
        beyond => (Verdict::Differs, format!("beyond the limits of {}", beyond.join(", "))),
    })
}
