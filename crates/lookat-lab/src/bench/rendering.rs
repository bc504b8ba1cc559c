//! Whole pictures: scenes of the project, which are in the program.

use std::io::{Error, ErrorKind};
use std::ops::ControlFlow;
use std::path::Path;

use lookat_render::{Rendered, Settings};
use lookat_scene::{FilmOverride, LoadOptions, Scene};

use super::table::{BenchRow, BenchTable, Cell, in_turn, timed};

/// A scene, and the samples per pixel that it is rendered at; none for a draft.
type Entry = (&'static str, &'static str, Option<u32>);

const SCENES: [Entry; 5] = [
    ("first", FIRST, None),
    ("seed-perspective", include_str!("scenes/seed-perspective.pbrt"), Some(16)),
    ("seed-thin-lens", include_str!("scenes/seed-thin-lens.pbrt"), Some(16)),
    ("cornell-matte", include_str!("scenes/cornell-matte.pbrt"), Some(8)),
    ("cornell-glossy", include_str!("scenes/cornell-glossy.pbrt"), Some(8)),
];

const FIRST: &str = include_str!("scenes/first.pbrt");
/// What it includes.
const TORUS: &str = include_str!("scenes/torus.pbrt");

/// How long a picture takes, in seconds, and its rays: on one thread, and on all.
type Pair = [(f64, u64); 2];

/// One thread and all of them; the draft with reading.
pub(super) fn table(rounds: usize) -> BenchTable {
    let seconds =
        in_turn(rounds, SCENES.len(), |scene| [1, 0].map(|threads| measure(&SCENES[scene], threads)));
    let row = |((name, _, samples), rounds): (&Entry, &Vec<Pair>)| {
        let of = |value: &dyn Fn(&Pair) -> f64| Cell::of(rounds.iter().map(value));
        let rate = |(seconds, rays): (f64, u64)| rays as f64 / seconds / 1e6;
        let cells = vec![
            of(&|[one, _]| one.0),
            of(&|[_, all]| all.0),
            of(&|[one, all]| one.0 / all.0),
            of(&|[one, _]| rate(*one)),
            of(&|[_, all]| rate(*all)),
        ];
        let how = samples.map_or("--quick, with reading".into(), |samples| format!("{samples} samples"));
        BenchRow { name: format!("{name}, {how}"), cells }
    };
    BenchTable {
        name: "rendering",
        title: "built-in scenes; Mray/s counts all kinds of rays".into(),
        columns: vec!["s, one thread", "s, all", "times as fast", "Mray/s, one thread", "Mray/s, all"],
        rows: SCENES.iter().zip(&seconds).map(row).collect(),
    }
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

/// # Panics
///
/// If the scene has errors.
fn load(name: &str, text: &str, quarter: bool) -> Scene {
    let read = |path: &Path| match path.file_name().and_then(|file| file.to_str()) {
        Some("torus.pbrt") => Ok(TORUS.into()),
        Some("scene.pbrt") => Ok(text.into()),
        _ => Err(Error::from(ErrorKind::NotFound)),
    };
    let film = FilmOverride { quarter, ..FilmOverride::default() };
    let options = LoadOptions { film, ..LoadOptions::default() };
    let loaded = lookat_scene::load(Path::new("scene.pbrt"), &read, &options);
    loaded.scene.unwrap_or_else(|| panic!("{name}: {:?}", loaded.diagnostics))
}
