//! Renders a scene and compares it with its reference.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use lookat_image::{AlignError, Aligned, Format, MemoryBudget, align};
use lookat_render::{Settings, Stop};
use lookat_scene::syntax::{Diagnostic, Severity};
use lookat_scene::{LoadOptions, Loaded, Scene};
use serde_json::json;

use crate::args::{Report, Verify};
use crate::failure::Failure;
use crate::metric::{Limit, Metric, THRESHOLD, measure, not_finite};
use crate::output::{check_folder, check_inputs, is_among, write_result};
use crate::render::{Metadata, charge_memory, note_jitter};
use crate::source::{load_scene, read_image, replace_samples};
use crate::verify::page::PACKING_BYTES;
use crate::verify::{
    Diagnostics, Outcome, Rendered, SceneComparison, Verdict, beside, scene_name, why_unreadable,
};
use crate::{compare as comparing, report};

/// A verdict and its reason.
type Judgment = (Verdict, String);

/// Renders a scene and compares it with its reference. `inputs` are the files that all scenes read: none of them is replaced.
pub fn verify(arguments: &Verify, file: &Path, inputs: &BTreeSet<PathBuf>) -> Outcome {
    let diagnostics = Diagnostics { text: String::new(), json: json!([]) };
    let mut outcome = Outcome {
        name: scene_name(file),
        verdict: Verdict::New,
        reason: "no reference beside it".into(),
        updated: false,
        diagnostics,
        render: None,
        reference: None,
        comparison: None,
    };
    let judged = match why_unreadable(file) {
        Some(fault) => Err(fault.into()),
        None if !arguments.update && arguments.report.is_none() && beside(file).next().is_none() => Ok(()),
        None => fill(arguments, file, inputs, &mut outcome),
    };
    if let Err(reason) = judged {
        (outcome.verdict, outcome.reason) = (Verdict::Trouble, reason.into());
    }
    outcome
}

/// Fills in the outcome of a scene file that can be read. Fails if the scene cannot be verified.
fn fill(
    arguments: &Verify,
    file: &Path,
    inputs: &BTreeSet<PathBuf>,
    outcome: &mut Outcome,
) -> Result<(), Failure> {
    let options = LoadOptions { max_memory: arguments.memory.limit(), ..LoadOptions::default() };
    let mut loaded = load_scene(file, &options, Report { strict: false, json: false });
    replace_samples(&mut loaded, arguments.spp);
    report::print(&loaded, false);
    outcome.diagnostics = Diagnostics {
        text: report::text(&loaded),
        json: json!(report::json(&loaded.diagnostics, &loaded.sources)),
    };
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
        outcome.reference = Some(image);
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
    let rendered = outcome.render.insert(render(arguments, file, scene, &loaded.memory)?);
    if let Some(expected) = &outcome.reference {
        outcome.comparison = match align(&rendered.image, expected) {
            Ok(pair) => {
                let bytes = pair.window.area() * (comparing::pixel_bytes(&pair) + packing);
                comparing::check_memory(pair.window, bytes, &loaded.memory)?;
                Some(compare(arguments, pair))
            }
            // No option of verify chooses a layer.
            Err(error @ AlignError::Channels(..)) => return Err(error.into()),
            Err(error) => {
                (outcome.verdict, outcome.reason) = (Verdict::Differs, error.to_string());
                None
            }
        };
    }
    if let Some(comparison) = &outcome.comparison {
        (outcome.verdict, outcome.reason) = judge(arguments, comparison)?;
    }
    if arguments.update && matches!(outcome.verdict, Verdict::Differs | Verdict::New) {
        update(&target, outcome)?;
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

/// Writes a new reference.
fn update(target: &Path, outcome: &mut Outcome) -> Result<(), Failure> {
    let Some(Rendered { image, samples_per_pixel, .. }) = &outcome.render else { return Ok(()) };
    write_result(target, |path| image.write(path))?;
    outcome.updated = true;
    outcome.reason += &format!("; wrote {}, {samples_per_pixel} samples per pixel", target.display());
    Ok(())
}

fn render(
    arguments: &Verify,
    file: &Path,
    scene: &Scene,
    memory: &MemoryBudget,
) -> Result<Rendered, Failure> {
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
    Ok(Rendered { image, samples_per_pixel, seconds })
}

fn compare(arguments: &Verify, pair: Aligned) -> SceneComparison {
    let measurement = measure(&pair, THRESHOLD, &|_| broken(&pair).is_none());
    let significance = comparing::significance(&arguments.max);
    let found = measurement.agreement.as_ref().and_then(|found| found.as_ref().ok());
    let detectable = found.map(|found| found.visible_in_mean(significance));
    SceneComparison { pair, measurement, detectable }
}

/// Which picture has pixels that are not finite, and how many.
fn broken(pair: &Aligned) -> Option<(&'static str, usize)> {
    [("render", &pair.actual), ("reference", &pair.expected)]
        .into_iter()
        .find_map(|(which, pixels)| not_finite(pixels, pair).map(|(count, _)| (which, count)))
}

/// Whether the measurement is within the limits or, without any, within noise.
fn judge(arguments: &Verify, comparison: &SceneComparison) -> Result<Judgment, Failure> {
    let SceneComparison { pair, measurement, .. } = comparison;
    match broken(pair) {
        Some((which, 1)) => return Ok((Verdict::Differs, format!("1 pixel of the {which} is not finite"))),
        Some((which, count)) => {
            return Ok((Verdict::Differs, format!("{count} pixels of the {which} are not finite")));
        }
        None => {}
    }
    if pair.left_out > 0 {
        let reason = format!("only one of the pictures has {} of the pixels", pair.left_out);
        return Ok((Verdict::Differs, reason));
    }
    let default = [Limit { metric: Metric::NoiseP, value: comparing::SIGNIFICANCE }];
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
            (Verdict::Undecided, comparing::undecided(found, comparing::significance(limits)))
        }
        ([], _) if arguments.max.is_empty() => (Verdict::Agrees, "within noise".into()),
        ([], _) => (Verdict::Agrees, "within the limits".into()),
        (_, Some(found)) if arguments.max.is_empty() => {
            let found = comparing::differences(found, comparing::SIGNIFICANCE);
            (Verdict::Differs, format!("by more than noise: {}", found.join("; ")))
        }
        (beyond, _) => (Verdict::Differs, format!("exceeds the limits of {}", beyond.join(", "))),
    })
}
