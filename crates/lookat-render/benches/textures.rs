//! Pictures of a square with a texture: `cargo bench -p lookat-render --bench textures`.

use std::ops::ControlFlow;
use std::path::Path;

use divan::Bencher;
use divan::counter::ItemsCount;
use lookat_render::{Scene, Settings, render};

/// Pixels on each side.
const SIDE: usize = 128;
const SAMPLES: usize = 4;

fn main() {
    divan::main();
}

/// The square fills the picture.
fn scene(texture: &str) -> Scene {
    let text = format!(
        "LookAt 0 0 -1 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 90
         Film \"image\" \"integer xresolution\" {SIDE} \"integer yresolution\" {SIDE}
         Sampler \"random\" \"integer pixelsamples\" {SAMPLES}
         Integrator \"directlighting\" WorldBegin LightSource \"distant\"
         Scale 0.1 0.1 0.1 Texture \"t\" \"spectrum\" \"{texture}\" Scale 10 10 10
         Material \"matte\" \"texture Kd\" \"t\"
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]
         \"point P\" [-2 -2 0 2 -2 0 2 2 0 -2 2 0] \"float uv\" [0 0 20 0 20 20 0 20] WorldEnd"
    );
    let loaded =
        lookat_render::scene::load(Path::new("square"), &|_| Ok(text.clone().into()), &Default::default());
    loaded.scene.expect("the scene is right")
}

/// The first is what all others need too.
#[divan::bench(args = ["constant", "uv", "checkerboard", "dots", "fbm", "wrinkled", "windy", "marble"])]
fn texture(bencher: Bencher, texture: &str) {
    let scene = scene(texture);
    let settings = Settings { threads: 1, ..Settings::default() };
    bencher
        .counter(ItemsCount::new(SIDE * SIDE * SAMPLES))
        .bench_local(|| render(&scene, &settings, &|_| ControlFlow::Continue(())));
}
