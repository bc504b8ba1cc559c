//! Renders a scene and compares it with its reference.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use lookat_image::{
    AlignError, Aligned, Format, Image, Limit, Measurement, MemoryBudget, Metric, THRESHOLD, align, mean,
    measure, not_finite,
};
use lookat_render::{Settings, Stop};
use lookat_scene::syntax::{Diagnostic, Severity};
use lookat_scene::{LoadOptions, Loaded, Scene};
use lookat_sight::Metadata;
use serde_json::json;

use crate::args::{Report, Verify};
use crate::failure::Failure;
use crate::output::{check_folder, check_inputs, is_among, write_result};
use crate::readable::plural;
use crate::render::settings::{charge_memory, note_jitter};
use crate::source::{load_scene, read_image, replace_samples};
use crate::verify::files::{beside, scene_name, why_unreadable};
use crate::verify::outcome::{Outcome, Verdict};
use crate::verify::page::picture::{PACKING_BYTES, Picture};
use crate::{compare as comparing, report};

/// Renders a scene and compares it with its reference. `inputs` are the files that all scenes read: none of them is replaced.
pub fn verify(arguments: &Verify, file: &Path, inputs: &BTreeSet<PathBuf>) -> Outcome {
    let mut outcome = Outcome {
        scene: scene_name(file),
        verdict: Verdict::New,
        reason: "no reference beside it".into(),
        updated: false,
        metrics: Vec::new(),
        visible_in_mean: None,
        samples_per_pixel: None,
        seconds: None,
        diagnostics: json!([]),
        messages: String::new(),
        mean: None,
        pictures: Vec::new(),
    };
    let mut images = Images::default();
    let judged = match why_unreadable(file) {
        Some(fault) => Err(fault.into()),
        None if !arguments.update && arguments.report.is_none() && beside(file).next().is_none() => Ok(()),
        None => fill(arguments, file, inputs, &mut outcome, &mut images),
    };
    if let Err(reason) = judged {
        (outcome.verdict, outcome.reason) = (Verdict::Failed, reason.into());
    }
    if arguments.report.is_some() {
        outcome.pictures = images.pictures();
    }
    outcome
}

/// The pictures of a scene, as far as there are any.
#[derive(Default)]
struct Images {
    reference: Option<Image>,
    render: Option<Image>,
    /// The render and its reference, over the pixels of both.
    pair: Option<Aligned>,
}

impl Images {
    fn pictures(&self) -> Vec<Picture> {
        if let Some(pair) = &self.pair {
            return vec![Picture::new(pair)];
        }
        let both = [("expected", &self.reference), ("actual", &self.render)];
        both.into_iter().filter_map(|(role, image)| Picture::alone(image.as_ref()?, role)).collect()
    }
}

/// Fills in the outcome of a scene file that can be read. Fails if the scene cannot be verified.
fn fill(
    arguments: &Verify,
    file: &Path,
    inputs: &BTreeSet<PathBuf>,
    outcome: &mut Outcome,
    images: &mut Images,
) -> Result<(), Failure> {
    let options = LoadOptions { max_memory: arguments.memory.limit(), ..LoadOptions::default() };
    let mut loaded = load_scene(file, &options, Report::default());
    replace_samples(&mut loaded, arguments.spp);
    report::print(&loaded, false);
    outcome.messages = report::text(&loaded);
    outcome.diagnostics = json!(lookat_scene::as_json(&loaded.diagnostics, &loaded.sources));
    let Some(scene) = &loaded.scene else { return Err(why_no_scene(&loaded).into()) };
    note_jitter(scene, &loaded);
    let packing = if arguments.report.is_some() { PACKING_BYTES } else { 0 };
    // A picture that the scene shows is not a picture of the scene.
    let reference = beside(file).find(|picture| !is_among(picture, &loaded.inputs));
    if let Some(reference) = &reference {
        check_reference(arguments, reference)?;
        let image = read_image(reference, &loaded.memory)?;
        let window = image.data_window;
        comparing::check_memory(window, window.area() * packing, &loaded.memory)?;
        images.reference = Some(image);
    } else if !arguments.update {
        if beside(file).next().is_some() {
            outcome.reason = "no reference beside the scene, except a picture that the scene uses".into();
        }
        // Only the report shows its picture.
        if arguments.report.is_none() {
            return Ok(());
        }
    }
    let target = reference.unwrap_or_else(|| file.with_extension("exr"));
    if arguments.update {
        // Before the scene is rendered.
        check_folder(&target).and_then(|()| check_inputs(&target, loaded.inputs.union(inputs)))?;
    }
    let (image, seconds) = render(arguments, file, scene, &loaded.memory)?;
    let samples_per_pixel = scene.view.sampler.samples_per_pixel;
    (outcome.samples_per_pixel, outcome.seconds) = (Some(samples_per_pixel), Some(seconds));
    let image = images.render.insert(image);
    match images.reference.as_ref().map(|reference| align(image, reference)) {
        Some(Ok(pair)) => {
            let bytes = pair.window.area() * (comparing::pixel_bytes(&pair) + packing);
            comparing::check_memory(pair.window, bytes, &loaded.memory)?;
            compare(arguments, images.pair.insert(pair), outcome)?;
        }
        // No option of verify chooses a layer.
        Some(Err(error @ AlignError::Channels(..))) => return Err(error.into()),
        Some(Err(error)) => (outcome.verdict, outcome.reason) = (Verdict::Differs, error.to_string()),
        None => {}
    }
    if arguments.update && matches!(outcome.verdict, Verdict::Differs | Verdict::New) {
        write_result(&target, |path| image.write(path))?;
        outcome.updated = true;
        let target = target.display();
        outcome.reason += &format!("; wrote {target}, {samples_per_pixel} samples per pixel");
    }
    Ok(())
}

/// The number of errors of a scene, and the first.
fn why_no_scene(loaded: &Loaded) -> String {
    let is_error = |diagnostic: &&Diagnostic| diagnostic.severity == Severity::Error;
    let errors: Vec<&Diagnostic> = loaded.diagnostics.iter().filter(is_error).collect();
    match errors.first() {
        Some(first) if errors.len() == 1 => format!("the scene has an error: {}", first.message),
        Some(first) => format!("the scene has {} errors, the first: {}", errors.len(), first.message),
        None => loaded.override_error.clone().unwrap_or_else(|| "the scene has errors".into()),
    }
}

/// Fails if a reference cannot be read, or `--update` cannot replace it.
fn check_reference(arguments: &Verify, reference: &Path) -> Result<(), Failure> {
    if let Some(fault) = why_unreadable(reference) {
        return Err(fault.into());
    }
    if arguments.update && Format::from_path(reference).is_none() {
        bail!("{}: --update writes {}; remove it first", reference.display(), Format::NAMES);
    }
    Ok(())
}

/// Renders a scene. Also gives the seconds that this took.
fn render(
    arguments: &Verify,
    file: &Path,
    scene: &Scene,
    memory: &MemoryBudget,
) -> Result<(Image, f64), Failure> {
    let samples_per_pixel = scene.view.sampler.samples_per_pixel;
    let settings = Settings {
        seed: arguments.seed,
        // Always, so that limits hold for the picture from which people read them.
        stop: Stop::Samples { error_layers: samples_per_pixel > 1 },
        ..Settings::default()
    };
    // For good: the allocator keeps the film's memory for the threads that allocated it.
    charge_memory(scene, &settings, memory)?.keep();
    let started = Instant::now();
    let mut image = lookat_render::render(scene, &settings, &|_| ControlFlow::Continue(())).image;
    let seconds = started.elapsed().as_secs_f64();
    image.metadata =
        Metadata::new(file, &scene.view.camera, arguments.seed, f64::from(samples_per_pixel)).as_json();
    Ok((image, seconds))
}

/// Measures two pictures, and judges them.
fn compare(arguments: &Verify, pair: &Aligned, outcome: &mut Outcome) -> Result<(), Failure> {
    let measurement = measure(pair, THRESHOLD, &|_| broken(pair).is_none());
    let significance = lookat_image::significance(&arguments.max);
    let found = measurement.agreement.as_ref().and_then(|found| found.as_ref().ok());
    outcome.visible_in_mean = found.map(|found| found.visible_in_mean(significance));
    outcome.mean = Some(mean(&pair.expected));
    let judged = judge(arguments, pair, &measurement);
    outcome.metrics = measurement.metrics;
    (outcome.verdict, outcome.reason) = judged?;
    Ok(())
}

/// Which picture has pixels that are not finite, and how many.
fn broken(pair: &Aligned) -> Option<(&'static str, usize)> {
    [("render", &pair.actual), ("reference", &pair.expected)]
        .into_iter()
        .find_map(|(which, pixels)| not_finite(pixels, pair).map(|(count, _)| (which, count)))
}

/// Whether the measurement is within the limits or, without any, within noise.
fn judge(
    arguments: &Verify,
    pair: &Aligned,
    measurement: &Measurement,
) -> Result<(Verdict, String), Failure> {
    if let Some((which, count)) = broken(pair) {
        let (one, many) = (format!("pixel of the {which} is"), format!("pixels of the {which} are"));
        return Ok((Verdict::Differs, format!("{} not finite", plural(count as u64, &one, &many))));
    }
    if pair.left_out > 0 {
        let reason = format!("only one of the pictures has {} of the pixels", pair.left_out);
        return Ok((Verdict::Differs, reason));
    }
    let default = [Limit { metric: Metric::NoiseP, value: lookat_image::SIGNIFICANCE }];
    let limits = if arguments.max.is_empty() { &default[..] } else { &arguments.max[..] };
    if let Some(reason) = measurement.lacks(limits) {
        let other =
            if arguments.max.is_empty() { "; --max sets other limits, such as rmse=0.01" } else { "" };
        return Err((reason + other).into());
    }
    let beyond: Vec<&str> = measurement.beyond(limits).into_iter().map(Metric::name).collect();
    let found = measurement.agreement.as_ref().and_then(|found| found.as_ref().ok());
    Ok(match (beyond.as_slice(), found) {
        ([], _) if pair.actual == pair.expected => (Verdict::Agrees, "identical".into()),
        ([], Some(found)) if measurement.is_undecided(limits) => {
            (Verdict::Undecided, lookat_image::undecided(found, lookat_image::significance(limits)))
        }
        ([], _) if arguments.max.is_empty() => (Verdict::Agrees, "within noise".into()),
        ([], _) => (Verdict::Agrees, "within the limits".into()),
        (_, Some(found)) if arguments.max.is_empty() => {
            let found = lookat_image::differences(found, lookat_image::SIGNIFICANCE);
            (Verdict::Differs, format!("by more than noise: {}", found.join("; ")))
        }
        (beyond, _) => (Verdict::Differs, {
            let limits = if beyond.len() == 1 { "limit" } else { "limits" };
            format!("exceeds the {limits} of {}", beyond.join(", "))
        }),
    })
}
