//! What the targets share.

use std::io::Result;
use std::path::Path;

use lookat_scene::LoadOptions;

#[path = "../../tests/properties/promises.rs"]
pub mod promises;

/// Checks the promises for a scene whose files come from `read`. The scene is `scene.pbrt`.
pub fn check_scene(read: &dyn Fn(&Path) -> Result<Vec<u8>>) {
    // Given, because finding out the limit of the machine takes longer than reading a small scene.
    let options = LoadOptions { max_memory: Some(1 << 28), ..LoadOptions::default() };
    promises::check(&lookat_scene::load(Path::new("scene.pbrt"), read, &options));
}

/// The same for a scene whose only other file is `data`.
pub fn check_file(scene: &str, data: &[u8]) {
    check_scene(&|path| Ok(if path == Path::new("scene.pbrt") { scene.into() } else { data.to_vec() }));
}
