//! Pictures have the same bits on every processor, at every level and on any number of threads: their hashes are in `bits/hashes.txt`.
//!
//! `UPDATE_EXPECTED=1 cargo test --release -p lookat-render --lib bits` rewrites the hashes, for `git diff` to judge.

use std::cell::RefCell;
use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use fearless_simd::Level;
use lookat_scene::schema::Kind;
use lookat_scene::{FilmOverride, LoadOptions, Scene, kinds, load};

use super::{Settings, Stop, TargetError};
use crate::prepare::Prepared;
use crate::testing::levels;

/// Folders of `pbrt-scenes` of which all scenes are tested.
const FOLDERS: [&str; 8] = ["", "cameras", "lights", "materials", "media", "motion", "shapes", "textures"];

/// Scenes with another directive: name, scene, what is replaced, by what.
const VARIANTS: [[&str; 4]; 13] = [
    ["whitted", "cornell-specular", "Integrator \"path\"", "Integrator \"whitted\""],
    ["ambient-occlusion", "meshes", "Integrator \"directlighting\"", "Integrator \"ambientocclusion\""],
    ["volpath", "cornell-matte", "Integrator \"path\"", "Integrator \"volpath\""],
    ["one-light", "delta-lights", "lighting\"", "lighting\" \"string strategy\" \"one\""],
    ["uniform-lights", "lights/spectra", "\"path\"", "\"path\" \"string lightsamplestrategy\" \"uniform\""],
    ["power-lights", "lights/spectra", "\"path\"", "\"path\" \"string lightsamplestrategy\" \"power\""],
    ["random", "cornell-glossy", "Sampler \"halton\"", "Sampler \"random\""],
    [
        "stratified",
        "cornell-matte",
        "Sampler \"halton\"",
        "Sampler \"stratified\" \"integer xsamples\" 2 \"integer ysamples\" 2",
    ],
    [
        "telecentric",
        "orthographic-thin-lens",
        "\"orthographic\"",
        "\"orthographic\" \"bool telecentric\" \"true\"",
    ],
    ["no-material", "materials/none", "\"none\"", "\"\""],
    ["exinfinite", "lights/infinite-map", "\"infinite\"", "\"exinfinite\""],
    ["area", "cornell-glossy", "AreaLightSource \"diffuse\"", "AreaLightSource \"area\""],
    ["subsurface", "materials/matte", "Material \"matte\"", "Material \"subsurface\""],
];

/// Other ways to render cornell-glossy.
fn stops() -> [(&'static str, Stop); 3] {
    let target = TargetError { relative: 0.3, confidence: 0.95 };
    let target_error = Stop::TargetError { target, max_samples: 256, limit: None, error_layers: true };
    let error_layers = Stop::Samples { error_layers: true };
    [("target-error", target_error), ("adaptive", Stop::Adaptive), ("error-layers", error_layers)]
}

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pbrt-scenes")
}

/// A small picture of a scene and few samples; `texts` collects its lines.
fn small(name: &str, [from, to]: [&str; 2], texts: &RefCell<String>) -> Scene {
    let path = scenes().join(name).with_extension("pbrt");
    let read = |file: &Path| {
        let bytes = std::fs::read(file)?;
        let Ok(mut text) = String::from_utf8(bytes.clone()) else { return Ok(bytes) };
        if file == path {
            assert!(text.contains(from), "{name} has no {from}");
            text = text.replace(from, to);
        }
        *texts.borrow_mut() += &text;
        Ok(text.into())
    };
    let film = FilmOverride { resolution: Some([24, 16]), ..FilmOverride::default() };
    let loaded = load(&path, &read, &LoadOptions { film, ..LoadOptions::default() });
    let mut scene = loaded.scene.unwrap_or_else(|| panic!("{name}: {:?}", loaded.diagnostics));
    let samples = &mut scene.view.sampler.samples_per_pixel;
    *samples = (*samples).min(4);
    scene
}

/// All scenes by name, and how they are rendered; and the text of all.
fn all() -> (Vec<(String, Scene, Stop)>, String) {
    let texts = RefCell::new(String::new());
    let mut all = Vec::new();
    for folder in FOLDERS {
        for entry in scenes().join(folder).read_dir().unwrap() {
            let file = entry.unwrap().file_name().into_string().unwrap();
            if let Some(name) = file.strip_suffix(".pbrt") {
                let name = if folder.is_empty() { name.into() } else { format!("{folder}/{name}") };
                all.push((name.clone(), small(&name, ["", ""], &texts), Stop::default()));
            }
        }
    }
    for [name, base, from, to] in VARIANTS {
        all.push((name.into(), small(base, [from, to], &texts), Stop::default()));
    }
    for (name, stop) in stops() {
        all.push((name.into(), small("cornell-glossy", ["", ""], &texts), stop));
    }
    all.sort_by(|a, b| a.0.cmp(&b.0));
    (all, texts.into_inner())
}

/// The hash (FNV-1a) of the numbers of a picture, with the layers of its error, and of its exact sums: so parts from unlike machines
/// add up.
fn hash(scene: &Scene, stop: Stop, level: Level, threads: usize) -> u64 {
    let mut prepared = Prepared::new(scene);
    prepared.traceable.level = level;
    let settings = Settings { seed: 7, threads, stop, keep_sums: true, ..Settings::default() };
    let rendered = prepared.render(&scene.view, &settings, &|_| ControlFlow::Continue(()));
    let (_, integers) = rendered.sums.unwrap().into_channels();
    let bytes =
        rendered.image.channels.iter().flat_map(|channel| &channel.samples).flat_map(|x| x.to_le_bytes());
    let sums = integers.iter().flat_map(|channel| &channel.samples).flat_map(|x| x.to_le_bytes());
    bytes
        .chain(sums)
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[test]
fn pictures_have_the_expected_bits_at_every_level_and_on_any_number_of_threads() {
    let mut found = String::new();
    for (name, scene, stop) in all().0 {
        let expected = hash(&scene, stop, Level::new(), 3);
        for level in levels() {
            assert_eq!(expected, hash(&scene, stop, level, 1), "{name}: {level:?}, 1 thread");
        }
        writeln!(found, "{expected:016x} {name}").unwrap();
    }
    if std::env::var("UPDATE_EXPECTED").is_ok_and(|value| value == "1") {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/render/bits/hashes.txt");
        std::fs::write(file, found).unwrap();
        panic!("rewritten; run again");
    }
    let expected: Vec<&str> = include_str!("bits/hashes.txt").lines().collect();
    let differ: Vec<&str> = found.lines().filter(|line| !expected.contains(line)).collect();
    assert!(differ.is_empty(), "other pictures on {:?}:\n{}", Level::new(), differ.join("\n"));
    assert_eq!(found.lines().count(), expected.len());
}

#[test]
fn scenes_have_everything_that_is_rendered() {
    let (_, text) = all();
    let wanted = [
        "Camera",
        "Film",
        "PixelFilter",
        "Sampler",
        "Integrator",
        "Shape",
        "Material",
        "LightSource",
        "AreaLightSource",
        "Texture",
    ];
    // Scenes without a directive have the default.
    let is_wanted =
        |kind: &&Kind| kind.instead.is_empty() && !kind.is_default && wanted.contains(&kind.directive);
    for kind in kinds().filter(is_wanted) {
        let name = format!("\"{}\"", kind.name);
        let is_valid =
            text.lines().any(|line| line.contains(&format!("{} ", kind.directive)) && line.contains(&name));
        assert!(is_valid, "no {} {name}", kind.directive);
    }
    for parameter in ["bumpmap", "texture alpha", "ObjectInstance", "shadowalpha"] {
        assert!(text.contains(parameter), "no {parameter}");
    }
}
