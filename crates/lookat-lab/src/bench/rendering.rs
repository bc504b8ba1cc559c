//! Whole pictures: scenes of the project, which are in the program.

use std::ops::ControlFlow;
use std::path::Path;

use lookat_render::{Rendered, Settings};
use lookat_scene::{FilmOverride, LoadOptions, Scene};

use super::bench_table::{BenchTable, Column};
use crate::timed;

/// A scene, and the samples per pixel that it is rendered at; none for a draft.
type Entry = (&'static str, &'static str, Option<u32>);

const SCENES: [Entry; 5] = [
    ("first", include_str!("scenes/first.pbrt"), None),
    ("seed-perspective", include_str!("scenes/seed-perspective.pbrt"), Some(16)),
    ("seed-thin-lens", include_str!("scenes/seed-thin-lens.pbrt"), Some(16)),
    ("cornell-matte", include_str!("scenes/cornell-matte.pbrt"), Some(8)),
    ("cornell-glossy", include_str!("scenes/cornell-glossy.pbrt"), Some(8)),
];

/// What the first one includes.
const TORUS: &str = include_str!("scenes/torus.pbrt");

/// One thread and all of them; the draft with reading.
pub(super) fn table(rounds: usize) -> BenchTable {
    // Seconds and rays, on one thread and on all.
    let columns: [Column<[(f64, u64); 2]>; 5] = [
        ("s, one thread", |[one, _], _| one.0),
        ("s, all", |[_, all], _| all.0),
        ("times as fast", |[one, all], _| one.0 / all.0),
        ("Mray/s, one thread", |[one, _], _| one.1 as f64 / one.0 / 1e6),
        ("Mray/s, all", |[_, all], _| all.1 as f64 / all.0 / 1e6),
    ];
    let how = |samples: u32| format!("{samples} samples");
    let name = |(name, _, samples): Entry| {
        format!("{name}, {}", samples.map_or("--quick, with reading".into(), how))
    };
    let title = "built-in scenes; Mray/s counts all kinds of rays".into();
    BenchTable::measured(("rendering", title), &columns, SCENES.map(name).into(), rounds, |scene| {
        [1, 0].map(|threads| measure(&SCENES[scene], threads))
    })
}

/// How long a scene takes, in seconds, and its rays.
fn measure((name, text, samples): &Entry, threads: usize) -> (f64, u64) {
    let (reading, mut scene) = timed(|| load(name, text, samples.is_none()));
    scene.view.sampler = scene.view.sampler.with_samples(samples.unwrap_or(1));
    let (rendering, rendered) = timed(|| render(&scene, &Settings { threads, ..Settings::default() }));
    let reading = if samples.is_none() { reading } else { 0.0 };
    (reading + rendering, rendered.statistics.rays)
}

pub(super) fn render(scene: &Scene, settings: &Settings) -> Rendered {
    lookat_render::render(scene, settings, &|_| ControlFlow::Continue(()))
}

/// The scene of a text, with a quarter of its width and height for `quarter`. It may include the torus, and all pictures in it are
/// the same.
///
/// # Panics
///
/// If it has errors.
pub(super) fn load(name: &str, text: &str, quarter: bool) -> Scene {
    let read = |path: &Path| match path.file_name().and_then(|file| file.to_str()) {
        Some("scene") => Ok(text.into()),
        Some("torus.pbrt") => Ok(TORUS.into()),
        _ => Ok(picture()),
    };
    let film = FilmOverride { quarter, ..FilmOverride::default() };
    let options = LoadOptions { film, ..LoadOptions::default() };
    let loaded = lookat_scene::load(Path::new("scene"), &read, &options);
    loaded.scene.unwrap_or_else(|| panic!("{name}: {:?}", loaded.diagnostics))
}

/// Colors, 256 by 256.
fn picture() -> Vec<u8> {
    let mut bytes = b"PF\n256 256\n-1.0\n".to_vec();
    for at in 0..256 * 256_u32 {
        for channel in 0..3 {
            let value = (at.wrapping_mul(2_654_435_761) >> (8 * channel) & 255) as f32 / 255.0;
            bytes.extend(value.to_le_bytes());
        }
    }
    bytes
}
