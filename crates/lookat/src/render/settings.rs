//! The settings of a rendering, the memory that it needs, and what the scene must have for them.

use std::path::Path;

use lookat_image::{Charge, Format, MemoryBudget, OutOfMemory, byte_words};
use lookat_render::{Layers, Settings, Stop, TargetError, film_bytes, preparation_bytes};
use lookat_scene::{Loaded, SamplerKind, Scene};

use crate::args::{Render, raise_limit};
use crate::failure::Failure;
use crate::output::NewPicture;

/// The default confidence of the target error.
const CONFIDENCE: f64 = 0.95;

/// The most pixels with a target error. Each takes about 300 bytes until it is done.
const MOST_PIXELS: u64 = 1 << 24;

/// The render settings of the arguments.
pub fn settings(arguments: &Render, file: &Path) -> Settings {
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
    // The first part has the layers of all.
    let own = arguments.layers.iter().filter(|_| arguments.part.is_none_or(|part| part.index == 0));
    let layers = own.copied().fold(Layers::default(), Layers::union);
    let part = arguments.part;
    let is_extendable = arguments.is_extendable();
    let keep_sums = part.is_some() || arguments.checkpoint.is_some() || is_extendable;
    Settings { seed: arguments.seed, stop, layers, part, is_extendable, keep_sums, ..Settings::default() }
}

/// The target error, if there is one.
pub fn target_error(settings: &Settings) -> Option<TargetError> {
    if let Stop::TargetError { target, .. } = settings.stop { Some(target) } else { None }
}

/// What is known of the picture before rendering.
pub fn new_picture(scene: &Scene, settings: &Settings) -> NewPicture {
    let crop = scene.view.film.crop;
    let most_samples = match settings.stop {
        Stop::Samples { .. } | Stop::Adaptive => scene.view.sampler.samples_per_pixel,
        Stop::Time { max_samples, .. } | Stop::TargetError { max_samples, .. } => max_samples,
    };
    NewPicture {
        size: [crop.width(), crop.height()],
        samples_per_pixel: Some(own_samples(settings, most_samples).into()),
        is_adaptive: matches!(settings.stop, Stop::Adaptive | Stop::TargetError { .. }),
        is_partial: false,
    }
}

/// The samples that a rendering takes of so many.
fn own_samples(settings: &Settings, samples: u32) -> u32 {
    settings.part.map_or(samples, |part| part.range(samples).len() as u32)
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

/// Fails if the file cannot hold the layers, or the scene has too few samples or too many pixels for the settings.
pub fn check_settings(arguments: &Render, scene: &Scene, file: &Path) -> Result<(), Failure> {
    let Render { error_layers, target_error, .. } = *arguments;
    if let Some(part) = arguments.part {
        if Format::from_path(file) != Some(Format::Exr) {
            bail!("{}: only an .exr file can store a part; choose one with -o", file.display());
        }
        let samples = scene.view.sampler.samples_per_pixel;
        if part.of > samples {
            bail!(
                "{samples} samples per pixel make at most {samples} parts; write a smaller N, or increase --spp"
            );
        }
    }
    if arguments.is_extendable() {
        if Format::from_path(file) != Some(Format::Exr) {
            bail!("{}: only an .exr file can keep sums; choose one with -o", file.display());
        }
        if matches!(scene.view.sampler.kind, SamplerKind::Stratified { .. }) {
            bail!(
                "nothing can be added to stratified samples, whose grid has a fixed size: write Sampler \"sobol\" in the scene"
            );
        }
    }
    if target_error.is_some() && scene.view.film.crop.area() > MOST_PIXELS {
        bail!("--target-error supports at most {MOST_PIXELS} pixels; render parts with --crop");
    }
    if (error_layers || !arguments.layers.is_empty()) && Format::from_path(file) != Some(Format::Exr) {
        let layers = if error_layers { "error layers" } else { "layers" };
        bail!("{}: only an .exr file can store {layers}; choose one with -o", file.display());
    }
    if error_layers && target_error.is_none() {
        check_error_layers(scene.view.sampler.samples_per_pixel)
            .map_err(|error| format!("{error}; increase --spp"))?;
    }
    Ok(())
}

/// Fails without enough samples for error layers.
pub fn check_error_layers(samples_per_pixel: u32) -> Result<(), Failure> {
    if samples_per_pixel < 2 {
        bail!("error layers need at least 2 samples per pixel, preferably 16 or more");
    }
    Ok(())
}

/// Warns if error layers change the sampler of the scene.
pub fn note_jitter(scene: &Scene, loaded: &Loaded) {
    if scene.view.sampler.jittered() != scene.view.sampler {
        let file = loaded.sources.files[0].path.display();
        say!("{file}: error layers need jittered samples, so \"bool jitter\" \"false\" is ignored");
    }
}

/// Warns if an option replaces the sampler of the scene.
pub fn note_sampler(arguments: &Render, scene: &Scene, loaded: &Loaded) {
    let option = match (arguments.target_error, arguments.time) {
        (Some(_), _) => "--target-error",
        (None, Some(_)) => "--time",
        (None, None) if arguments.adaptive => "--adaptive",
        (None, None) if arguments.error_layers => return note_jitter(scene, loaded),
        (None, None) => return,
    };
    let replaced = match scene.view.sampler.kind {
        SamplerKind::Sobol { .. } => None,
        SamplerKind::Random => arguments.target_error.map(|_| "random"),
        SamplerKind::Stratified { .. } => Some("stratified"),
    };
    if let Some(replaced) = replaced {
        let file = loaded.sources.files[0].path.display();
        say!("{file}: {option} uses Sampler \"sobol\" instead of \"{replaced}\"");
    }
}
