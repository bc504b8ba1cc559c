//! `lookat render`: from a scene file to a picture.

use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use lookat_image::Format;
use lookat_render::{Progress, Rendered, Settings};
use lookat_scene::{Loaded, MAX_PIXELS, Overrides, Scene};
use serde::Serialize;

use crate::args::Render;
use crate::interrupt;
use crate::report::{self, JsonDiagnostic};
use crate::source::load_scene;

/// Set when there are samples to write.
static HAS_SAMPLES: AtomicBool = AtomicBool::new(false);

const FAILED: u8 = 1;

/// What `--json` prints.
#[derive(Serialize)]
struct JsonResult<'a> {
    scene: String,
    diagnostics: Vec<JsonDiagnostic<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    picture: Option<JsonPicture>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

#[derive(Serialize)]
struct JsonPicture {
    file: String,
    width: u32,
    height: u32,
    samples_per_pixel: f64,
    seconds: f64,
    rays: u64,
    rejected_samples: u64,
    complete: bool,
}

/// What a picture says of its making. It must not change from run to run.
#[derive(Serialize)]
pub struct Metadata {
    program: &'static str,
    version: &'static str,
    scene: String,
    seed: u64,
    samples_per_pixel: f64,
    complete: bool,
}

impl Metadata {
    pub fn new(scene: &Path, seed: u64, samples_per_pixel: f64, complete: bool) -> Metadata {
        let (program, version) = ("lookat", env!("CARGO_PKG_VERSION"));
        Metadata { program, version, scene: scene.display().to_string(), seed, samples_per_pixel, complete }
    }

    pub fn as_json(&self) -> Option<String> {
        serde_json::to_string(self).ok()
    }
}

/// Runs the command.
pub fn render(arguments: &Render) -> ExitCode {
    if let Err(message) = check_arguments(arguments) {
        crate::say(&format!("error: {message}"));
        return ExitCode::from(crate::TROUBLE);
    }
    let crop = arguments.crop.as_deref().and_then(|edges| <[f64; 4]>::try_from(edges).ok());
    let overrides = Overrides {
        samples_per_pixel: arguments.spp,
        resolution: arguments.resolution,
        crop,
        quick: arguments.quick,
        keep_going: arguments.report.keep_going,
    };
    let loaded = load_scene(&arguments.scene, &overrides, arguments.report);
    if !arguments.report.json {
        report::print(&loaded, arguments.quiet);
    }
    let mut result = JsonResult {
        scene: arguments.scene.display().to_string(),
        diagnostics: report::json(&loaded),
        picture: None,
        error: None,
    };
    let status = match &loaded.scene {
        None => FAILED,
        Some(scene) => match picture(arguments, scene, &loaded) {
            Ok(picture) => {
                let status = if picture.complete { 0 } else { interrupt::STATUS };
                result.picture = Some(picture);
                status
            }
            Err(message) => {
                crate::say(&format!("error: {message}"));
                result.error = Some(message);
                crate::TROUBLE
            }
        },
    };
    let lost = arguments.report.json && !crate::print_json(&result);
    ExitCode::from(if lost { crate::TROUBLE } else { status })
}

/// What is wrong with the arguments together, before it is blamed on the scene.
fn check_arguments(arguments: &Render) -> Result<(), String> {
    if let Some([x0, x1, y0, y1]) = arguments.crop.as_deref()
        && (x0 == x1 || y0 == y1)
    {
        return Err("--crop takes the left, right, top and bottom edge, and leaves nothing so".into());
    }
    if let (Some([width, height]), None) = (arguments.resolution, &arguments.crop)
        && u64::from(width) * u64::from(height) > MAX_PIXELS
    {
        let message = "--resolution asks for more than 100 million pixels; render parts of it with --crop";
        return Err(message.into());
    }
    Ok(())
}

/// Renders and writes the picture.
fn picture(arguments: &Render, scene: &Scene, loaded: &Loaded) -> Result<JsonPicture, String> {
    let file = arguments.output.clone().unwrap_or_else(|| scene.film.file.clone());
    // Before hours of rendering, not after.
    check_output(&file)?;
    if arguments.error_layers {
        check_error_layers(&file, scene)?;
        if !arguments.quiet {
            note_jitter(scene, loaded);
        }
    }
    let notice = "stopping; once more ends at once, without a picture";
    interrupt::watch(notice, || HAS_SAMPLES.load(Ordering::Relaxed))?;
    let settings = Settings {
        seed: arguments.seed,
        threads: arguments.threads.map_or(0, usize::from),
        error_layers: arguments.error_layers,
        ..Settings::default()
    };
    let started = Instant::now();
    let mut rendered = with_progress(arguments, |progress| lookat_render::render(scene, &settings, progress));
    let seconds = started.elapsed().as_secs_f64();

    let samples_per_pixel = rendered.statistics.samples as f64 / scene.film.crop.area() as f64;
    let scene_file = &loaded.sources.files[0].path;
    let metadata = Metadata::new(scene_file, arguments.seed, samples_per_pixel, rendered.complete);
    rendered.image.metadata = metadata.as_json();
    let file = if rendered.complete { file } else { partial(&file) };
    rendered.image.write(&file).map_err(|error| error.to_string())?;
    let picture = JsonPicture {
        file: file.display().to_string(),
        width: rendered.image.data_window.width,
        height: rendered.image.data_window.height,
        samples_per_pixel,
        seconds,
        rays: rendered.statistics.rays,
        rejected_samples: rendered.statistics.rejected,
        complete: rendered.complete,
    };
    if !arguments.quiet && !arguments.report.json {
        summarize(&picture, &rendered);
    }
    Ok(picture)
}

/// Fails where the picture could not be written in the end.
fn check_output(file: &Path) -> Result<(), String> {
    if Format::from_path(file).is_none() {
        let name = file.display();
        return Err(format!("{name}: lookat writes {}; choose one by the ending, with -o", Format::NAMES));
    }
    check_folder(file)
}

/// Fails where there is no folder to write a file to.
pub fn check_folder(file: &Path) -> Result<(), String> {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            Err(format!("cannot write {}: there is no folder {}", file.display(), folder.display()))
        }
        _ => Ok(()),
    }
}

/// Fails where there can be no error layers.
fn check_error_layers(file: &Path, scene: &Scene) -> Result<(), String> {
    if Format::from_path(file) != Some(Format::Exr) {
        return Err(format!(
            "{}: only an .exr file can hold error layers; choose one with -o",
            file.display()
        ));
    }
    if scene.sampler.samples_per_pixel < 2 {
        return Err("--error-layers needs at least 2 samples per pixel, better 16 or more; see --spp".into());
    }
    Ok(())
}

/// Says where error layers make another picture than the scene asks for.
pub fn note_jitter(scene: &Scene, loaded: &Loaded) {
    if scene.sampler.jittered() != scene.sampler {
        let file = loaded.sources.files[0].path.display();
        crate::say(&format!(
            "{file}: the samples are jittered for the error layers, in spite of \"bool jitter\" false"
        ));
    }
}

/// The name of a picture that is not finished: `a.exr` becomes `a.partial.exr`, so it replaces no finished one.
fn partial(file: &Path) -> PathBuf {
    match file.extension() {
        Some(extension) => file.with_extension(format!("partial.{}", extension.display())),
        None => file.with_extension("partial"),
    }
}

/// Shows a progress bar on a terminal, and stops on Ctrl-C.
fn with_progress(
    arguments: &Render,
    render: impl FnOnce(&(dyn Fn(Progress) -> ControlFlow<()> + Sync)) -> Rendered,
) -> Rendered {
    let bar = progress_bar(arguments.quiet || arguments.report.json);
    let rendered = render(&|progress: Progress| {
        HAS_SAMPLES.store(true, Ordering::Relaxed);
        bar.set_position(progress.done * 1000 / progress.total.max(1));
        if interrupt::is_asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    bar.finish_and_clear();
    rendered
}

/// A bar of a thousand steps on a terminal.
pub fn progress_bar(silent: bool) -> ProgressBar {
    let hidden = silent || !std::io::stderr().is_terminal();
    let bar = if hidden { ProgressBar::hidden() } else { ProgressBar::new(1000) };
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {percent:>3} %  {eta} left") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// The one line at the end.
fn summarize(picture: &JsonPicture, rendered: &Rendered) {
    let JsonPicture { file, width, height, samples_per_pixel, seconds, rays, .. } = picture;
    let rate = *rays as f64 / seconds / 1e6;
    let samples = match (rendered.complete, *samples_per_pixel) {
        (true, 1.0) => "1 sample".to_owned(),
        (true, count) => format!("{count} samples"),
        (false, count) => format!("{count:.1} samples"),
    };
    let part = if rendered.complete { "" } else { "; interrupted, a partial picture" };
    crate::say(&format!(
        "{file}: {width} x {height} pixels, {samples} each, {seconds:.2} s, {rate:.2} million rays/s{part}"
    ));
    if rendered.image.channels.iter().all(|channel| channel.samples.iter().all(|sample| *sample == 0.0)) {
        crate::say("the picture is all black: no light reaches what the camera sees");
    }
    if rendered.statistics.rejected > 0 {
        let count = rendered.statistics.rejected;
        crate::say(&format!("{count} samples were infinite or not a number, and count as black"));
    }
}
