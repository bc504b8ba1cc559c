//! Renders the project's scenes.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use lookat_image::Image;
use lookat_scene::{Overrides, Scene};

/// A scene of `pbrt-scenes`, its text changed by `edit`.
///
/// # Panics
///
/// If it is not there or has errors.
pub fn scene(name: &str, overrides: &Overrides, edit: &dyn Fn(String) -> String) -> Scene {
    let file = folder().join(name).with_extension("pbrt");
    let read = |path: &Path| {
        let bytes = std::fs::read(path)?;
        Ok(if path == file { edit(String::from_utf8_lossy(&bytes).into_owned()).into_bytes() } else { bytes })
    };
    let loaded = lookat_scene::load(&file, &read, overrides);
    let problems: Vec<&str> = loaded.diagnostics.iter().map(|problem| problem.message.as_str()).collect();
    loaded.scene.unwrap_or_else(|| panic!("{}: {}", file.display(), problems.join("; ")))
}

/// The picture of a scene, with error layers.
pub fn render(scene: &Scene, seed: u64) -> Image {
    let settings = lookat_render::Settings {
        seed,
        stop: lookat_render::Stop::Samples { error_layers: true },
        ..Default::default()
    };
    lookat_render::render(scene, &settings, &|_| ControlFlow::Continue(())).image
}

/// The picture of a scene as users get it, on so many threads; 0 for all.
pub fn render_plainly(scene: &Scene, seed: u64, threads: usize) -> Image {
    let settings = lookat_render::Settings { seed, threads, ..Default::default() };
    lookat_render::render(scene, &settings, &|_| ControlFlow::Continue(())).image
}

/// The names of the scenes there, in order.
pub fn names() -> Vec<String> {
    let entries = std::fs::read_dir(folder()).expect("pbrt-scenes is there");
    let files = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let scenes = files.filter(|file| file.extension().is_some_and(|ending| ending == "pbrt"));
    let mut names: Vec<String> =
        scenes.filter_map(|file| Some(file.file_stem()?.to_string_lossy().into_owned())).collect();
    names.sort();
    names
}

/// What a scene shows: the first line of its file.
pub fn says(name: &str) -> String {
    let text = std::fs::read_to_string(folder().join(name).with_extension("pbrt")).unwrap_or_default();
    text.lines().next().unwrap_or_default().trim_start_matches("# ").to_owned()
}

/// The folder `pbrt-scenes`.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pbrt-scenes")
}
