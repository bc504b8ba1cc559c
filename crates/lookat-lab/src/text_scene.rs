//! Scenes from text.

use std::ops::ControlFlow;
use std::path::Path;

use lookat_image::Image;
use lookat_scene::{Loaded, Scene};

/// What is read of a scene text.
pub(crate) fn load(text: &str) -> Loaded {
    lookat_scene::load(Path::new("case.pbrt"), &|_| Ok(text.into()), &Default::default())
}

/// A scene that must be right.
///
/// # Panics
///
/// If it has errors.
pub(crate) fn scene(text: &str) -> Scene {
    let loaded = load(text);
    let problems: Vec<&str> = loaded.diagnostics.iter().map(|problem| problem.message.as_str()).collect();
    loaded.scene.unwrap_or_else(|| panic!("{}: {text}", problems.join("; ")))
}

/// The picture of a scene, on so many threads; 0 for all.
pub(crate) fn render(scene: &Scene, threads: usize) -> Image {
    let settings = lookat_render::Settings { threads, ..Default::default() };
    lookat_render::render(scene, &settings, &|_| ControlFlow::Continue(())).image
}
