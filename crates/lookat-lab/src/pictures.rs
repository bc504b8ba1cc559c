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
    let settings = lookat_render::Settings { seed, error_layers: true, ..Default::default() };
    lookat_render::render(scene, &settings, &|_| ControlFlow::Continue(())).image
}

/// The picture of a scene as users get it.
pub fn render_plainly(scene: &Scene, seed: u64) -> Image {
    let settings = lookat_render::Settings { seed, ..Default::default() };
    lookat_render::render(scene, &settings, &|_| ControlFlow::Continue(())).image
}

/// The folder `pbrt-scenes`.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pbrt-scenes")
}
