//! Loads a scene that names one file, which holds the input.

use std::path::Path;

use lookat_scene::Overrides;

#[path = "../tests/promises.rs"]
#[allow(dead_code)]
mod promises;

/// Checks the promises for a scene whose only other file is `data`.
pub fn load(scene: &str, data: &[u8]) {
    let read = |path: &Path| Ok(if path == Path::new("scene.pbrt") { scene.into() } else { data.to_vec() });
    let overrides = Overrides { max_memory: Some(1 << 28), ..Overrides::default() };
    promises::check(&lookat_scene::load(Path::new("scene.pbrt"), &read, &overrides));
}
