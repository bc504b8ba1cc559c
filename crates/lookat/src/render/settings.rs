//! The settings of a rendering, the memory that it needs, and what the scene must have for them.

use std::path::Path;

use lookat_image::{Charge, Format, MemoryBudget, OutOfMemory, byte_words};
use lookat_render::{Layers, Settings, Stop, StopOptions, StopOptionsError, film_bytes, preparation_bytes};
use lookat_scene::{Loaded, SamplerKind, Scene, View};

use crate::args::{Render, raise_limit, way_out};
use crate::failure::Failure;
use crate::output::NewPicture;

/// The most pixels with a target error. Each takes about 300 bytes until it is done.
const MOST_PIXELS: u64 = 1 << 24;

/// The stopping rule of the arguments. Fails if they contradict each other.
pub fn stop(arguments: &Render) -> Result<Stop, StopOptionsError> {
    let Render { target_error, confidence, time, spp, adaptive, error_layers, .. } = *arguments;
    StopOptions { target_error, confidence, time, spp, adaptive, error_layers }.stop()
}

/// The render settings of the arguments, which have been checked.
pub fn settings(arguments: &Render, file: &Path) -> Settings {
    let mut stop = stop(arguments).unwrap_or_default();
    if let Stop::TargetError { error_layers, .. } = &mut stop {
        // Always, if the file can hold them.
        *error_layers |= Format::from_path(file) == Some(Format::Exr);
    }
    // The first part has the layers of all.
    let own = arguments.layers.iter().filter(|_| arguments.part.is_none_or(|part| part.index == 0));
    let layers = own.copied().fold(Layers::default(), Layers::union);
    let part = arguments.part;
    let is_extendable = arguments.is_extendable();
    let keep_sums = part.is_some() || arguments.checkpoint.is_some() || is_extendable;
    Settings { seed: arguments.seed, stop, layers, part, is_extendable, keep_sums, ..Settings::default() }
}

/// The samples of each pixel; their mean if they are adaptive, and the most if the error or the time decides.
pub fn most_samples(settings: &Settings, view: &View) -> u32 {
    match settings.stop {
        Stop::Samples { .. } | Stop::Adaptive => view.sampler.samples_per_pixel,
        Stop::Time { max_samples, .. } | Stop::TargetError { max_samples, .. } => max_samples,
    }
}

/// What is known of the picture before rendering.
pub fn new_picture(scene: &Scene, settings: &Settings) -> NewPicture {
    let crop = scene.view.film.crop;
    let most_samples = most_samples(settings, &scene.view);
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

/// Charges the memory of the samples of an earlier rendering.
pub fn reserve(bytes: u64, memory: &MemoryBudget) -> Result<Charge, Failure> {
    memory.reserve(bytes).map_err(|shortage| Failure::TooLarge(way_out(shortage)))
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
        let settings = settings(arguments, file);
        let samples = most_samples(&settings, &scene.view);
        if let Some(first) = settings.first_round().filter(|_| !settings.is_whole_round(samples)) {
            let option = match settings.stop {
                Stop::Adaptive | Stop::Time { .. } => "--adaptive",
                Stop::TargetError { .. } => "--target-error",
                Stop::Samples { .. } => "--error-layers",
            };
            let counts = [1, 2, 4, 8].map(|times| (times * first).to_string()).join(", ");
            let way_out = match arguments.more {
                Some(more) => format!("choose another number than {more} for --more"),
                None => "write such a number behind --spp".into(),
            };
            bail!(
                "with {option}, samples are added to pictures of {counts} and so on samples per pixel, and this one would have {samples}: {way_out}"
            );
        }
        let is_stratified = matches!(scene.view.sampler.kind, SamplerKind::Stratified { .. });
        if is_stratified && matches!(settings.stop, Stop::Samples { .. }) {
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
