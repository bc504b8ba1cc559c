//! What the tests of several files share.

use std::path::Path;

use lookat_scene::{LoadOptions, Scene, load};

pub(crate) use crate::lanes::baseline;

/// A number without a pattern, from -1 to 1.
pub(crate) fn noise(i: usize, k: f64) -> f64 {
    ((i as f64 * k).sin() * 1e4).fract()
}

/// The scene of a text without mistakes.
pub(crate) fn scene(text: &str) -> Scene {
    let loaded = load(Path::new("test.pbrt"), &|_| Ok(text.to_owned().into()), &LoadOptions::default());
    loaded.scene.unwrap_or_else(|| panic!("{:?} {text}", loaded.diagnostics))
}
