//! `lookat render`: renders a scene file to a picture.

mod batch;
mod fireflies;
mod frames;
mod progress;
mod summary;
mod written;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use lookat_image::{Charge, Format, MemoryBudget, OutOfMemory, byte_words};
use lookat_render::{
    Layers, Prepared, Progress, Settings, Statistics, Stop, TargetError, film_bytes, preparation_bytes,
};
use lookat_scene::syntax::Diagnostic;
use lookat_scene::{FilmOverride, LoadOptions, Loaded, MAX_PIXELS, SamplerKind, Scene};

use crate::args::{Render, crop_edges, raise_limit};
use crate::light::note_linear;
use crate::live::Live;
use crate::output::{NewPicture, check_inputs, check_output, check_unfinished, marked};
use crate::render::batch::{Job, jobs, render_again, render_each};
use crate::render::fireflies::Fireflies;
use crate::render::frames::{focus, render_frames};
use crate::render::progress::Shown;
pub use crate::render::progress::progress_bar;
pub use crate::render::summary::{JsonPicture, Metadata};
use crate::render::summary::{JsonTarget, Numbered, explain_black, narrow_filter, summarize};
use crate::render::written::{Kept, Output, PARTIAL, SoFar};
use crate::report::SceneResult;
use crate::source::{load_scene, load_watched, replace_samples};
use crate::{Failure, interrupt, report, sight, standard_error};

/// True once there are samples to write.
static HAS_SAMPLES: AtomicBool = AtomicBool::new(false);

/// The default confidence of the target error.
const CONFIDENCE: f64 = 0.95;

/// The most pixels with a target error. Each takes about 300 bytes until it is done.
const MOST_PIXELS: u64 = 1 << 24;

/// Runs the command.
pub fn render(arguments: &Render) -> ExitCode {
    let prepared =
        crop_edges(arguments.crop.as_deref()).and_then(|_| check_arguments(arguments)).and_then(|()| {
            let jobs = jobs(arguments)?;
            standard_error::detach();
            Ok((jobs, Live::new(&arguments.live, arguments.tone)?))
        });
    ExitCode::from(match prepared {
        Ok((mut jobs, live)) => match &live.watch {
            Some(watch) => render_again(jobs.remove(0), &live, watch),
            None => render_each(&jobs, &live),
        },
        Err(message) => {
            let mut result = SceneResult::without_scene(&arguments.scenes[0]);
            let status = fail(message, &mut result);
            finish(arguments, &result, status)
        }
    })
}

/// How a scene is loaded.
fn load_options(arguments: &Render) -> LoadOptions {
    let crop = crop_edges(arguments.crop.as_deref()).unwrap_or_default();
    let mut view = arguments.first_view();
    if arguments.focus.is_some() {
        // Any distance: --focus replaces it when the scene is prepared.
        view.focal_distance = Some(1.0);
    }
    LoadOptions {
        film: FilmOverride { resolution: arguments.resolution, quarter: arguments.quick, crop },
        view: view.options(),
        keep_going: arguments.keep_going,
        max_memory: arguments.memory.limit(),
        ..LoadOptions::default()
    }
}

/// Renders one scene. Returns the exit status.
fn render_scene(Job { arguments, inputs }: &Job, live: &Live) -> u8 {
    let path = &arguments.scenes[0];
    let options = load_options(arguments);
    let mut loaded = match &live.watch {
        Some(watch) => {
            let note = |file: &Path| {
                watch.note(file);
                None
            };
            load_watched(path, &options, arguments.report, &note, None)
        }
        None => load_scene(path, &options, arguments.report),
    };
    if loaded.scene.is_some() {
        loaded.inputs.extend(inputs.iter().cloned());
    }
    // If --spp is a maximum, the scene keeps its own number.
    let is_maximum = arguments.target_error.is_some() || arguments.time.is_some();
    let samples = arguments.spp.filter(|_| !is_maximum).or(arguments.quick.then_some(1));
    replace_samples(&mut loaded, samples);
    if !arguments.report.json {
        report::print(&loaded, arguments.quiet);
    }
    let diagnostics = report::json(&loaded.diagnostics, &loaded.sources);
    let mut result = SceneResult { diagnostics, ..SceneResult::without_scene(path) };
    let mut advice = Vec::new();
    let status = match (&loaded.scene, &loaded.override_error) {
        (None, Some(message)) if !report::has_errors(&loaded) => fail(message.clone().into(), &mut result),
        (None, _) => {
            if loaded.can_keep_going && !arguments.report.json && !arguments.quiet {
                say!("not rendered; to skip directives with errors, use --keep-going");
            }
            report::failure(&loaded)
        }
        (Some(scene), _) => match pictures(arguments, scene, &loaded, live, &mut result, &mut advice) {
            Ok(true) => 0,
            Ok(false) => interrupt::STATUS,
            Err(failure) => fail(failure, &mut result),
        },
    };
    result.diagnostics.extend(report::json(&advice, &loaded.sources));
    finish(arguments, &result, status)
}

/// Renders the picture or the pictures of a scene. False after an interruption.
fn pictures(
    arguments: &Render,
    scene: &Scene,
    loaded: &Loaded,
    live: &Live,
    result: &mut SceneResult,
    advice: &mut Vec<Diagnostic>,
) -> Result<bool, Failure> {
    if interrupt::flow().is_break() {
        return Ok(false);
    }
    arguments.first_view().check_use(scene)?;
    if !arguments.quiet {
        note_sampler(arguments, scene, loaded);
        note_linear(&picture_file(arguments, loaded), arguments.tone);
    }
    if arguments.frames.is_used() {
        let (frames, written) = render_frames(arguments, scene, loaded, live);
        result.frames = frames;
        return written;
    }
    let Some((picture, written)) = picture(arguments, scene, loaded, None, live, advice)? else {
        return Ok(true);
    };
    let is_complete = picture.complete;
    result.picture = Some(picture);
    written.map(|()| is_complete)
}

/// Prints the result as JSON, if requested. Returns the exit status.
fn finish(arguments: &Render, result: &SceneResult, status: u8) -> u8 {
    let lost = arguments.report.json && crate::print_json(result).is_err();
    if lost { crate::lost() } else { status }
}

/// Reports an error outside the scene.
fn fail(failure: Failure, result: &mut SceneResult) -> u8 {
    say!("error: {failure}");
    result.error = Some(failure.to_string());
    failure.status()
}

/// Checks the arguments together, before loading the scene.
fn check_arguments(arguments: &Render) -> Result<(), Failure> {
    if let (Some([width, height]), None) = (arguments.resolution, &arguments.crop)
        && u64::from(width) * u64::from(height) > MAX_PIXELS
    {
        let message = "--resolution has more than 100 million pixels; render parts with --crop";
        return Err(message.into());
    }
    if arguments.target_error.is_some() && arguments.spp.is_some_and(|most| most < 64) {
        bail!("--target-error needs at least 64 samples per pixel to estimate the error; increase --spp");
    }
    if arguments.error_layers && arguments.time.is_some() && arguments.target_error.is_none() {
        bail!("--error-layers with --time also needs --target-error");
    }
    Ok(())
}

/// The render settings of the arguments.
fn settings(arguments: &Render, file: &Path) -> Settings {
    let confidence = arguments.confidence.unwrap_or(CONFIDENCE);
    let Render { time, spp, adaptive, error_layers, .. } = *arguments;
    let stop = match (arguments.target_error, time) {
        (Some(relative), limit) => Stop::TargetError {
            target: TargetError { relative, confidence },
            max_samples: spp.unwrap_or(Stop::DEFAULT_MAX_SAMPLES_OF_TARGET),
            limit,
            // Always, if the file can hold them.
            error_layers: error_layers || Format::from_path(file) == Some(Format::Exr),
        },
        (None, Some(limit)) => {
            Stop::Time { limit, max_samples: spp.unwrap_or(Stop::DEFAULT_MAX_SAMPLES_OF_TIME), adaptive }
        }
        (None, None) if adaptive => Stop::Adaptive,
        (None, None) => Stop::Samples { error_layers },
    };
    let layers = arguments.layers.iter().copied().fold(Layers::default(), Layers::union);
    Settings { seed: arguments.seed, stop, layers, ..Settings::default() }
}

fn target_error(settings: &Settings) -> Option<TargetError> {
    match settings.stop {
        Stop::TargetError { target, .. } => Some(target),
        Stop::Samples { .. } | Stop::Adaptive | Stop::Time { .. } => None,
    }
}

/// What is known of the picture before rendering.
fn new_picture(scene: &Scene, settings: &Settings) -> NewPicture {
    let crop = scene.view.film.crop;
    let most_samples = match settings.stop {
        Stop::Samples { .. } | Stop::Adaptive => scene.view.sampler.samples_per_pixel,
        Stop::Time { max_samples, .. } | Stop::TargetError { max_samples, .. } => max_samples,
    };
    NewPicture {
        size: [crop.width(), crop.height()],
        samples_per_pixel: Some(most_samples.into()),
        is_adaptive: matches!(settings.stop, Stop::Adaptive | Stop::TargetError { .. }),
        is_partial: false,
    }
}

/// The file of the picture.
fn picture_file(arguments: &Render, loaded: &Loaded) -> PathBuf {
    // A draft replaces no finished picture.
    let own = if arguments.quick { marked(&loaded.output, "quick") } else { loaded.output.clone() };
    arguments.output.clone().unwrap_or(own)
}

/// A written picture, and whether it is where it was asked for.
type Written = (JsonPicture, Result<(), Failure>);

/// Renders and writes the picture. `None` if the files of the scene have changed meanwhile.
fn picture(
    arguments: &Render,
    scene: &Scene,
    loaded: &Loaded,
    prepared: Option<&mut Prepared>,
    live: &Live,
    advice: &mut Vec<Diagnostic>,
) -> Result<Option<Written>, Failure> {
    let file = picture_file(arguments, loaded);
    // Check before hours of rendering, not after.
    let crop = scene.view.film.crop;
    check_output(&file, [crop.width(), crop.height()])?;
    check_inputs(&file, &loaded.inputs)?;
    check_inputs(&marked(&file, PARTIAL), &loaded.inputs)?;
    let settings = settings(arguments, &file);
    let new = new_picture(scene, &settings);
    if !arguments.force {
        check_unfinished(&file, new, "replace it with --force, or choose another name with -o")?;
    }
    let _charge = charge_memory(scene, &settings, &loaded.memory)?;
    if arguments.target_error.is_some() && crop.area() > MOST_PIXELS {
        let message =
            format!("--target-error supports at most {MOST_PIXELS} pixels; render parts with --crop");
        return Err(message.into());
    }
    check_layers(&file, arguments, scene)?;
    let notice = "stopping; interrupt again to quit without a picture";
    interrupt::stop_in_order((!arguments.quiet).then_some(notice), || HAS_SAMPLES.load(Ordering::Relaxed));
    let (mut scene, is_frame) = (scene.clone(), prepared.is_some());
    let mut own;
    let prepared = match prepared {
        Some(prepared) => prepared,
        None => {
            own = Prepared::new(&scene);
            &mut own
        }
    };
    if let Some(place) = arguments.focus {
        crate::say(&focus(prepared, &mut scene.view, place)?);
    }
    if !arguments.quiet && !is_frame {
        *advice = sight::advise(loaded, &scene, prepared);
        if !arguments.report.json {
            report::print_each(advice, &loaded.sources);
        }
    }
    let started = Instant::now();
    let shown = Shown::new(arguments, crop.area());
    live.begin(&file, [crop.width(), crop.height()]);
    let output = Output { arguments, loaded, camera: &scene.view.camera, settings: &settings, new, file };
    let so_far = Mutex::new(SoFar::default());
    let progress = |progress: Progress| {
        if progress.done > 0 {
            HAS_SAMPLES.store(true, Ordering::Relaxed);
            if let Ok(mut so_far) = so_far.try_lock() {
                so_far.write_if_asked(&output, &progress);
            }
        }
        shown.update(&progress);
        live.update(&progress);
        live.flow()
    };
    let mut rendered = prepared.render(&scene.view, &settings, &progress);
    shown.clear();
    if !rendered.complete && interrupt::flow().is_continue() {
        return Ok(None);
    }
    live.finish(&rendered.image);
    let is_told = !arguments.quiet && !arguments.report.json;
    let luminances = if rendered.complete && !arguments.quiet {
        fireflies::luminances(&rendered.image, &scene.view.film, rendered.statistics.least)
    } else {
        None
    };
    let seconds = started.elapsed().saturating_sub(rendered.preparation).as_secs_f64();
    let numbered = Numbered::new(&rendered.image, prepared, &loaded.sources);
    let Kept { file, destination, kept, light, samples_per_pixel } =
        output.write(&mut rendered, numbered.clone())?;
    if rendered.complete {
        so_far.into_inner().unwrap_or_else(PoisonError::into_inner).remove();
    }
    let black = light.is_some_and(|light| light.is_black(summary::residue(&scene)));
    let Statistics { least, most, rays, rejected, clamped, target, .. } = rendered.statistics;
    let fireflies = luminances
        .and_then(|luminances| Fireflies::find(&luminances, &scene, prepared, &settings, &loaded.sources));
    let picture = JsonPicture {
        file: file.display().to_string(),
        width: rendered.image.data_window.width,
        height: rendered.image.data_window.height,
        samples_per_pixel,
        least_samples: least,
        most_samples: most,
        seconds,
        rays,
        rejected_samples: rejected,
        clamped_samples: clamped,
        complete: rendered.complete,
        black,
        light,
        numbered,
        fireflies,
        target: target_error(&settings).zip(target).map(|(target, reached)| JsonTarget::new(target, reached)),
    };
    if let Some(why) = kept.filter(|_| !arguments.report.json) {
        say!("{why}; the new picture is in {}", picture.file);
    }
    if arguments.quiet && !picture.complete {
        say!("interrupted; the partial picture is in {}", picture.file);
    }
    if is_told {
        summarize(&picture, &rendered);
        let is_shown = rendered.complete
            && least > 0
            && !black
            && narrow_filter(&rendered, &scene.view.filter).is_none();
        if let Some(light) = light {
            light.print(&file, is_shown);
        }
        for line in picture.fireflies.iter().flat_map(Fireflies::lines) {
            crate::say(&line);
        }
        if arguments.adaptive && rendered.complete && least == most {
            crate::say(ALIKE);
        }
    }
    // A picture that shows nothing is never what was meant: --quiet does not hide it.
    if !arguments.report.json {
        explain_black(&picture, &rendered, &scene, prepared, &loaded.sources);
    }
    live.wait();
    Ok(Some((picture, destination.result())))
}

/// Charges the memory to render the scene. Fails if there is not enough.
pub fn charge_memory(scene: &Scene, settings: &Settings, memory: &MemoryBudget) -> Result<Charge, Failure> {
    let (film, rest) = (film_bytes(&scene.view, settings), preparation_bytes(&scene.world));
    let refused = |OutOfMemory { needed, used, limit }| {
        let smaller = if film > rest { "; a crop window makes the film smaller" } else { "" };
        let [needed, film, rest, used, limit] =
            [used.saturating_add(needed), film, rest, used, limit].map(byte_words);
        Failure::TooLarge(format!(
            "rendering needs {needed} of memory: {used} for the scene, {rest} for BVHs and lights, {film} for the film; {}{smaller}",
            raise_limit(&limit)
        ))
    };
    memory.reserve(film.saturating_add(rest)).map_err(refused)
}

/// The message if `--adaptive` changed nothing. See `allotment.rs` and `adaptive.rs` in lookat-render.
const ALIKE: &str = "--adaptive had no effect: it needs noise, at least 8 samples per pixel, and 512 pixels";

/// Fails if the layers are impossible.
fn check_layers(file: &Path, arguments: &Render, scene: &Scene) -> Result<(), Failure> {
    let is_asked = arguments.error_layers || !arguments.layers.is_empty();
    if is_asked && Format::from_path(file) != Some(Format::Exr) {
        let layers = if arguments.error_layers { "error layers" } else { "layers" };
        bail!("{}: only an .exr file can store {layers}; choose one with -o", file.display());
    }
    let has_scene_samples = arguments.error_layers && arguments.target_error.is_none();
    let checked =
        if has_scene_samples { check_error_layers(scene.view.sampler.samples_per_pixel) } else { Ok(()) };
    Ok(checked.map_err(|error| format!("{error}; increase --spp"))?)
}

/// Fails without enough samples for error layers.
pub fn check_error_layers(samples_per_pixel: u32) -> Result<(), Failure> {
    let message = "error layers need at least 2 samples per pixel, preferably 16 or more";
    if samples_per_pixel < 2 { Err(message.into()) } else { Ok(()) }
}

/// Warns if error layers change the sampler of the scene.
pub fn note_jitter(scene: &Scene, loaded: &Loaded) {
    if scene.view.sampler.jittered() != scene.view.sampler {
        let file = loaded.sources.files[0].path.display();
        say!("{file}: error layers need jittered samples, so \"bool jitter\" \"false\" is ignored");
    }
}

/// Warns if an option replaces the sampler of the scene.
fn note_sampler(arguments: &Render, scene: &Scene, loaded: &Loaded) {
    let option = match (arguments.target_error, arguments.time) {
        (Some(_), _) => "--target-error",
        (None, Some(_)) => "--time",
        (None, None) if arguments.adaptive => "--adaptive",
        (None, None) if arguments.error_layers => return note_jitter(scene, loaded),
        (None, None) => return,
    };
    let is_kept = match scene.view.sampler.kind {
        SamplerKind::Sobol { .. } => true,
        SamplerKind::Random => arguments.target_error.is_none(),
        SamplerKind::Stratified { .. } => false,
    };
    if !is_kept {
        let file = loaded.sources.files[0].path.display();
        say!("{file}: {option} uses Sampler \"sobol\"");
    }
}
