//! Scenes that each isolate one part of the format, against renders of them by pbrt-v3 at 1,024 samples.
//!
//! A picture is compared by its mean and by the means of blocks of 8 x 8 pixels: noise falls with more samples, a wrong
//! meaning does not. `LOOKAT_TEST_SPP=256 cargo test --release -p lookat --test references -- --nocapture` prints the
//! figures at another number of samples, and then holds them to the bounds of a correct render.

use std::path::{Path, PathBuf};

use lookat_image::Image;
use lookat_scene::{Loaded, Overrides};

/// The scenes, and the bound on their block differences at 16 samples, in percent: one and a half times what was measured.
/// The seed is fixed, so what was measured is measured again.
const SCENES: [(&str, f64); 20] = [
    ("camera-mirrored", 1.6),
    ("camera-transform-chain", 1.1),
    ("coordinate-systems", 0.8),
    ("cornell-matte", 5.0),
    ("cropwindow", 1.9),
    ("delta-lights", 0.3),
    ("filter-gaussian", 1.0),
    ("filter-mitchell", 1.3),
    ("filter-sinc", 2.8),
    ("filter-triangle", 0.8),
    ("frameaspect-portrait", 2.3),
    ("furnace", 0.5),
    ("meshes", 0.7),
    ("object-instances", 0.3),
    ("orthographic-thin-lens", 2.8),
    ("screenwindow-offcentre", 1.8),
    ("seed-orthographic", 1.4),
    ("seed-perspective", 0.5),
    ("seed-thin-lens", 0.6),
    ("sphere-partial", 0.25),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn load(path: &Path, overrides: &Overrides) -> Loaded {
    lookat_scene::load(path, &|path| std::fs::read(path), overrides)
}

fn render(scene: &lookat_scene::Scene) -> Image {
    let go_on = |_| std::ops::ControlFlow::Continue(());
    lookat_render::render(scene, &lookat_render::Settings::default(), &go_on).image
}

/// The relative difference of the means, and the 95th percentile of that of the blocks, both in percent.
fn difference(actual: &Image, expected: &Image) -> (f64, f64) {
    let (a, b) = (actual.rgb().unwrap(), expected.rgb().unwrap());
    let mean = |pixels: &mut dyn Iterator<Item = [f32; 3]>| -> f64 {
        let (sum, count) = pixels.fold((0.0, 0), |(sum, count), p| {
            (sum + p.iter().map(|x| f64::from(*x)).sum::<f64>(), count + 3)
        });
        sum / f64::from(count.max(1))
    };
    // Two black blocks are alike.
    let relative = |a: f64, b: f64| if a == b { 0.0 } else { 100.0 * (a - b) / b };
    let (width, height) = (expected.data_window.width as usize, expected.data_window.height as usize);
    let mut blocks = Vec::new();
    for y0 in (0..height).step_by(8) {
        for x0 in (0..width).step_by(8) {
            let block = |image: &[[f32; 3]]| {
                let rows = y0..(y0 + 8).min(height);
                let places = rows.flat_map(|y| (x0..(x0 + 8).min(width)).map(move |x| y * width + x));
                mean(&mut places.map(|at| image[at]))
            };
            blocks.push(relative(block(&a), block(&b)).abs());
        }
    }
    blocks.sort_by(f64::total_cmp);
    let bias = relative(mean(&mut a.iter().copied()), mean(&mut b.iter().copied()));
    (bias, blocks[blocks.len() * 95 / 100])
}

#[test]
fn pictures_are_those_of_pbrt() {
    let asked: Option<u32> = std::env::var("LOOKAT_TEST_SPP").ok().map(|text| text.parse().unwrap());
    let mut wrong = Vec::new();
    for (name, block_bound) in SCENES {
        let overrides = Overrides { samples_per_pixel: Some(asked.unwrap_or(16)), ..Overrides::default() };
        let loaded = load(&root().join("pbrt-scenes").join(name).with_extension("pbrt"), &overrides);
        let actual = render(loaded.scene.as_ref().unwrap());
        let expected = Image::read(&root().join("pbrt-scenes").join(name).with_extension("exr")).unwrap();
        assert_eq!(actual.data_window, expected.data_window, "{name}");
        let (bias, block) = difference(&actual, &expected);
        println!("{name:24} mean {bias:+.4} %  blocks {block:.3} %");
        let bounds = if asked.is_some() { (0.2, 1.0) } else { (0.15, block_bound) };
        if bias.abs() > bounds.0 || block > bounds.1 {
            wrong.push(format!("{name}: mean {bias:+.3} %, blocks {block:.2} %"));
        }
    }
    assert!(wrong.is_empty(), "beyond noise:\n{}", wrong.join("\n"));
}
