//! How often `compare` takes noise for a bug, and whether it finds a bug of one percent.

use std::ops::ControlFlow;
use std::path::Path;

use lookat_image::{Image, agreement, align};
use lookat_scene::{FilmOverride, LoadOptions, Scene};

const SIGNIFICANCE: f64 = 0.01;

/// A scene of pbrt-scenes, with its text changed.
fn scene(name: &str, resolution: Option<[u32; 2]>, samples_per_pixel: u32, [from, to]: [&str; 2]) -> Scene {
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pbrt-scenes").join(name).with_extension("pbrt");
    let read = |path: &Path| {
        let text = std::fs::read_to_string(path)?;
        assert!(path != file || text.contains(from), "{name} has no {from}");
        Ok(text.replace(from, to).into_bytes())
    };
    let film = FilmOverride { resolution, ..FilmOverride::default() };
    let options = LoadOptions { film, ..LoadOptions::default() };
    let mut scene = lookat_scene::load(&file, &read, &options).scene.expect(name);
    scene.view.sampler = scene.view.sampler.with_samples(samples_per_pixel);
    scene
}

fn render(scene: &Scene, seed: u64) -> Image {
    let settings = lookat_render::Settings {
        seed,
        stop: lookat_render::Stop::Samples { error_layers: true },
        ..Default::default()
    };
    lookat_render::render(scene, &settings, &|_| ControlFlow::Continue(())).image
}

/// Pairs of pictures that are said to differ. The pictures of a pair have different seeds.
fn differing(first: &Scene, second: &Scene, pairs: u64) -> u64 {
    let differs = |pair: &u64| {
        let pair = align(&render(first, 2 * pair), &render(second, 2 * pair + 1)).unwrap();
        !agreement(&pair).expect("there are enough samples").holds(SIGNIFICANCE)
    };
    (0..pairs).filter(differs).count() as u64
}

/// At 1 %, more than two of 20 pairs happen once in a thousand runs; the seeds are fixed.
#[test]
fn noise_is_no_difference() {
    for name in ["furnace", "cornell-matte", "filter-mitchell"] {
        let [first, second] = [32, 64].map(|spp| scene(name, Some([48, 48]), spp, ["", ""]));
        let found = differing(&first, &second, 20);
        assert!(found <= 2, "{name}: {found} of 20 pairs");
    }
}

#[test]
fn one_percent_of_a_material_is_found() {
    let right = scene("cornell-matte", None, 256, ["", ""]);
    for change in [
        ["[0.7 0.7 0.7]\n", "[0.707 0.707 0.707]\n"],
        ["[0.63 0.06 0.05]", "[0.6363 0.0606 0.0505]"],
        ["[0.14 0.45 0.09]", "[0.1414 0.4545 0.0909]"],
    ] {
        let changed = scene("cornell-matte", None, 256, change);
        assert!(differing(&changed, &right, 1) == 1, "{change:?}");
    }
}
