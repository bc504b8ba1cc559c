//! Where the time of a rendering goes: its stages on one thread, and its rays with nothing in between.

use std::sync::Arc;
use std::time::Duration;

use lookat_render::{Settings, StageProfile};
use lookat_scene::{Scene, Shape};

use super::bench_table::{BenchTable, Column, in_turn};
use super::meshes::body;
use super::rendering::{load, render};
use crate::timed;

const LAMP: &str = r#"AttributeBegin AreaLightSource "diffuse" "rgb L" [30 28 24] Material "matte" "rgb Kd" [0 0 0]
    Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-1 4 -1  1 4 -1  1 4 1  -1 4 1] AttributeEnd"#;
const SKY: &str = r#"LightSource "infinite" "string mapname" "sky.pfm""#;
const MATTE: &str = r#"Material "matte" "rgb Kd" [.5 .5 .5]"#;
const TEXTURED: &str = r#"Texture "t" "spectrum" "imagemap" "string filename" "picture.pfm" "string mapping" "spherical"
    Material "matte" "texture Kd" "t""#;

/// The light of a scene, and the material of its mesh.
const SCENES: [(&str, &str, &str); 5] = [
    ("matte", LAMP, MATTE),
    ("glossy", LAMP, r#"Material "metal" "float roughness" .2 "bool remaproughness" "false""#),
    ("glass", LAMP, r#"Material "glass""#),
    ("textured", LAMP, TEXTURED),
    ("environment-lit", SKY, MATTE),
];

/// A stage, the time of all stages in seconds, and the camera samples.
type Line = (StageProfile, f64, f64);

const COLUMNS: [Column<Line>; 7] = [
    ("ns/sample", |(stage, _, samples), _| ratio(1e9 * stage.time.as_secs_f64(), *samples)),
    ("% of time", |(stage, whole, _), _| ratio(100.0 * stage.time.as_secs_f64(), *whole)),
    ("lanes/sample", |(stage, _, samples), _| ratio(stage.lanes as f64, *samples)),
    ("% of lanes in use", |(stage, ..), _| ratio(100.0 * stage.lanes as f64, 8.0 * stage.batches as f64)),
    ("M/s", |(stage, ..), _| ratio(1e-6 * stage.lanes as f64, stage.time.as_secs_f64())),
    ("M/s alone", |(stage, ..), _| ratio(1e-6 * stage.lanes as f64, stage.alone.as_secs_f64())),
    ("% of time alone", |(stage, whole, _), _| ratio(100.0 * stage.alone.as_secs_f64(), *whole)),
];

/// Not a number where a stage does not have one of the quantities.
fn ratio(of: f64, to: f64) -> f64 {
    if of == 0.0 || to == 0.0 { f64::NAN } else { of / to }
}

/// A table for each scene, a line for each stage.
pub(super) fn tables(rounds: usize) -> Vec<BenchTable> {
    let scenes = SCENES.map(|(_, light, material)| scene(light, material));
    let measured = in_turn(rounds, scenes.len(), |at| measure(&scenes[at]));
    SCENES.iter().zip(measured).map(|((name, ..), rounds)| table(name, &rounds)).collect()
}

/// A mesh above a ground, with a picture that takes a fraction of a second.
fn scene(light: &str, material: &str) -> Scene {
    let text = format!(
        r#"LookAt 0 1.4 -6 0 0 0 0 1 0 Camera "perspective" "float fov" 40 PixelFilter "box"
        Film "image" "integer xresolution" 200 "integer yresolution" 150 Sampler "sobol" "integer pixelsamples" 4
        Integrator "path" "integer maxdepth" 5 WorldBegin {light} {MATTE} Shape "trianglemesh"
        "integer indices" [0 1 2 0 2 3] "point P" [-4 -1.2 -4  -4 -1.2 5  4 -1.2 5  4 -1.2 -4]
        {material} Shape "sphere" WorldEnd"#
    );
    let mut scene = load("profile", &text, false);
    if let Some(last) = Arc::make_mut(&mut scene.world).primitives.last_mut() {
        last.shape = Shape::TriangleMesh(Arc::new(body()));
    }
    scene
}

/// The stages of one rendering, then the sum of the stages that trace rays, then a second rendering without the clock.
fn measure(scene: &Scene) -> Vec<Line> {
    let (seconds, rendered) = timed(|| render(scene, &Settings { threads: 1, ..Settings::default() }));
    let mut stages = lookat_render::profile(scene);
    stages.retain(|stage| !stage.time.is_zero());
    let whole = stages.iter().map(|stage| stage.time.as_secs_f64()).sum();
    let rays = StageProfile { name: "all rays", ..StageProfile::default() };
    let rays = stages.iter().filter(|stage| !stage.alone.is_zero()).fold(rays, StageProfile::with);
    let time = Duration::from_secs_f64(seconds).saturating_sub(rendered.preparation);
    stages.extend([rays, StageProfile { name: "all, without clock", time, ..rays }]);
    let samples = rendered.statistics.samples as f64;
    stages.into_iter().map(|stage| (stage, whole, samples)).collect()
}

fn table(name: &str, rounds: &[Vec<Line>]) -> BenchTable {
    let stage = |(at, (stage, ..)): (usize, &Line)| {
        (stage.name.into(), rounds.iter().map(|lines| lines[at]).collect())
    };
    let title = format!("{name} scene, on one thread");
    BenchTable::of(("profile", title), &COLUMNS, rounds[0].iter().enumerate().map(stage).collect())
}
