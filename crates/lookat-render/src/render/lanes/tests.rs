//! Samples side by side are those one by one.

use std::ops::ControlFlow;
use std::sync::Arc;

use fearless_simd::Level;
use lookat_image::{MipMap, Wrap};
use lookat_scene::{Integrator, Light, Scene, Transform};

use super::*;
use crate::Progress;
use crate::film::{Errors, Film};
use crate::lanes::level;
use crate::prepare::Prepared;
use crate::render::control::Control;
use crate::render::sample::{Pattern, Samples};
use crate::testing::{noise, scene};
use crate::trace::lanes::MOST;

/// What some pixels of a scene get, and the number of rays: one by one, or side by side on a processor of some level.
fn pixels(scene: &Scene, level: Option<Level>) -> (Vec<String>, u64) {
    let prepared = Prepared::new(scene);
    let progress = |_: Progress| ControlFlow::Continue(());
    let filter = FilterSampler::new(&scene.view.filter);
    let film = Film::new(&scene.view.film, &filter, Errors::None);
    let control = Control::new(&progress, None, &film);
    let li = |tracer: &mut Tracer, first: &FirstHit, stream: &mut SampleStream| match scene.view.integrator {
        Integrator::DirectLighting { strategy, max_depth } => {
            direct::li(tracer, first, stream, strategy, max_depth)
        }
        Integrator::Path { max_depth, roulette_threshold, light_choice } => {
            let settings = path::Settings { max_depth, roulette_threshold, light_choice };
            path::li(tracer, first, stream, &settings)
        }
        Integrator::AmbientOcclusion { .. } => panic!(),
    };
    let mut context = Context::new(&prepared, &scene.view, 16, (&filter, &film, &control), li);
    match (&mut context.lanes, level) {
        (Some(lanes), Some(level)) => lanes.level = level,
        (lanes, _) => {
            assert!(lanes.take().is_some() || level.is_none(), "the scene is not for lanes");
        }
    }
    let (mut tracer, mut meter) = (context.tracer(), Meter::new(&control));
    let pattern = Pattern { sampler: scene.view.sampler, seed: 5, is_watched: true };
    let job = |at: u32| Job {
        pattern: Pattern { seed: u64::from(at % 2), ..pattern },
        place: [at % 8 * 4, at / 8 * 4],
        // All, none, or from the middle on.
        indices: at % 8 * 4..scene.view.sampler.samples_per_pixel,
        samples: Samples::default(),
    };
    let mut jobs: Vec<Job> = (0..48).map(job).collect();
    context.sample_all(&mut tracer, &mut meter, &mut jobs);
    let sums = jobs.iter().map(|job| format!("{:?}", job.samples)).collect();
    (sums, tracer.rays)
}

/// One of several texts, by a number from -1 to 1.
fn pick(number: f64, of: &[&str]) -> String {
    of[(number.abs() * of.len() as f64) as usize].to_owned()
}

/// All before the world, in a case.
fn head(case: usize, integrator: &str) -> String {
    let pick = |k: f64, of: &[&str]| pick(noise(case, k), of);
    let camera = pick(
        1.1,
        &[
            "\"perspective\" \"float fov\" 60",
            "\"perspective\" \"float lensradius\" .1 \"float focaldistance\" 3",
            "\"perspective\" \"float lensradius\" .1 \"float focaldistance\" .05",
            "\"orthographic\" \"float screenwindow\" [-2 2 -2 2]",
            "\"orthographic\" \"float screenwindow\" [-2 2 -2 2] \"float lensradius\" .1 \"float focaldistance\" 3",
            "\"orthographic\" \"bool telecentric\" \"true\" \"float lensradius\" .1 \"float focaldistance\" 3",
        ],
    );
    let sampler = pick(
        1.2,
        &[
            "\"halton\"",
            "\"halton\" \"bool samplepixelcenter\" \"true\"",
            "\"sobol\"",
            "\"random\"",
            "\"stratified\" \"integer xsamples\" 5 \"integer ysamples\" 5",
        ],
    );
    let limit = pick(1.7, &["", "\"float maxsampleluminance\" .5"]);
    let filter = pick(1.3, &["box", "triangle", "gaussian", "mitchell", "sinc"]);
    // The last eye is in the plane of some of the shapes.
    let look_at = pick(
        1.4,
        &[
            "LookAt 0 0 -4 0 0 0 0 1 0",
            "Scale -1 1 1 LookAt -3 1.5 -2 0 0 0 .1 1 0",
            "LookAt .3 -.2 0 -1 1 2 0 1 0",
        ],
    );
    format!(
        "{look_at} Camera {camera} Film \"image\" \"integer xresolution\" 32 \"integer yresolution\" 24 {limit}
         Sampler {sampler} \"integer pixelsamples\" 25 PixelFilter \"{filter}\" Integrator {integrator}
         WorldBegin Texture \"t\" \"color\" \"checkerboard\" \"float uscale\" 5 \"float vscale\" 5
         Texture \"s\" \"float\" \"wrinkled\"
         AttributeBegin Material \"matte\" \"texture Kd\" \"t\" Shape \"trianglemesh\"
         \"point P\" [-9 -2 5 9 -2 5 9 9 5 -9 9 5] \"integer indices\" [0 1 2 0 2 3] AttributeEnd "
    )
}

/// Lights of no extent, and skies.
fn lights(case: usize) -> String {
    pick(
        noise(case, 1.5),
        &[
            "LightSource \"distant\" LightSource \"infinite\" \"rgb L\" [.2 .3 .4]",
            "LightSource \"point\" \"point from\" [2 2 -3] \"rgb I\" [9 8 7] LightSource \"spot\"
             \"point from\" [1 3 -2] \"point to\" [0 0 0] \"float coneangle\" 40 \"rgb I\" [20 20 20]",
            "LightSource \"infinite\" LightSource \"infinite\" \"rgb L\" [.1 0 0]",
            "LightSource \"spot\" \"float coneangle\" 50 \"float conedeltaangle\" 0 \"rgb I\" [20 20 20]
             \"point from\" [1 3 -2] LightSource \"infinite\"",
            "LightSource \"distant\" \"point from\" [0 1 0] LightSource \"point\" \"point from\" [0 0 0]",
            "",
        ],
    )
}

/// A shape in its place, with a material.
fn shape(case: usize, number: usize, shapes: &[&str]) -> String {
    let number = |k: f64| noise(case * 16 + number, k);
    let [x, y, z] = [number(2.1), number(2.2), number(2.3)].map(|x| x * 1.5);
    let size = [number(3.1), number(3.2), number(3.3)].map(|x| 0.4 + x.abs());
    let [across, up, along] = if case.is_multiple_of(2) { [size[0]; 3] } else { size };
    let [r, g, b] = [number(4.1), number(4.2), number(4.3)].map(|x| (x + 0.5).max(0.0));
    let material = match (number(8.1).abs() * 7.0) as u32 {
        0 | 1 => "",
        5 => "\"texture Kd\" \"t\" \"texture sigma\" \"s\"",
        6 => "\"texture Kd\" \"t\" \"texture roughness\" \"s\" \"texture bumpmap\" \"s\"",
        2 => "\"float sigma\" 30",
        3 => "\"float roughness\" .2 \"rgb Ks\" [.3 .4 .5]",
        _ => "\"float roughness\" .01 \"bool remaproughness\" \"false\" \"rgb Ks\" [1 1 1]",
    };
    // In half of the scenes all are diffuse.
    let material = if (case / 2).is_multiple_of(2) { "" } else { material };
    let kind = if material.contains("rough") { "plastic" } else { "matte" };
    let color = if material.contains("Kd") { String::new() } else { format!("\"rgb Kd\" [{r} {g} {b}]") };
    let turn = 180.0 * number(5.1);
    let shape = pick(number(6.1), shapes);
    let (orientation, turned) =
        (if number(7.1) > 0.0 { "ReverseOrientation" } else { "" }, number(7.2) > 0.0);
    let turn = if turned { format!("Rotate {turn} 1 .4 .2") } else { String::new() };
    format!(
        "AttributeBegin Translate {x} {y} {z} {turn} Scale {across} {up} {along} {orientation}
         Material \"{kind}\" {color} {material} {shape} AttributeEnd "
    )
}

const SPHERE: &str = "Shape \"sphere\"";
const PARTIAL: &str = "Shape \"sphere\" \"float zmin\" -.5 \"float phimax\" 200";
/// On pixels and edges of others.
const SQUARE: &str = "Shape \"trianglemesh\" \"point P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0]
    \"integer indices\" [0 1 2 0 2 3]";
const TRIANGLE: &str = "Shape \"trianglemesh\" \"point P\" [-1 0 0 1 0 0 0 1 .5] \"integer indices\" [0 1 2]";
const CORNER: &str = "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0 0 0 1]
    \"integer indices\" [0 1 2 0 2 3 0 3 1]";
const SMOOTH: &str = "Shape \"trianglemesh\" \"point P\" [-1 0 0 1 0 0 0 1 .5] \"integer indices\" [0 1 2]
    \"normal N\" [-.5 0 1 .5 .2 1 0 -.1 -1]";
const TANGENTS: &str = "Shape \"trianglemesh\" \"point P\" [-1 0 0 1 0 0 0 1 .5] \"integer indices\" [0 1 2]
    \"vector S\" [1 0 0 1 0 0 1 0 0]";
const DISK: &str = "Shape \"disk\"";
const CURVE: &str = "Shape \"curve\" \"float width\" .2 \"point P\" [0 0 0 .2 .5 0 .4 -.5 0 .6 0 0]";
const FIELD: &str = "Shape \"heightfield\" \"integer nu\" 6 \"integer nv\" 6 \"float Pz\"
    [0 .1 0 .2 0 .1  .3 0 .2 .1 0 .1  0 .2 0 .1 .3 0  .1 0 .2 0 .1 0  0 .1 .2 0 .3 .1  0 .2 0 .1 .1 0]";

/// What small worlds may have; what needs a tree; and what has shading normals of its own.
const SMALL: [&str; 6] = [SPHERE, SPHERE, PARTIAL, SQUARE, TRIANGLE, CORNER];
const LARGE: [&str; 8] = [SPHERE, SQUARE, CORNER, FIELD, TANGENTS, DISK, CURVE, PARTIAL];
const WITH_NORMALS: [&str; 8] = [SPHERE, SQUARE, SMOOTH, SMOOTH, FIELD, DISK, CURVE, TANGENTS];

/// A scene for direct lighting: small, or with a tree.
fn direct_scene(case: usize) -> String {
    let integrator = pick(noise(case, 1.6), &["\"directlighting\"", "\"whitted\""]);
    let lights = lights(case);
    let mut text = head(case, &integrator) + &lights;
    // Where normals differ, there are no skies.
    let shapes = match case % 5 {
        0 | 1 => &SMALL[..],
        2 | 3 => &LARGE[..],
        _ if lights.contains("infinite") => &LARGE[..],
        _ => &WITH_NORMALS[..],
    };
    for number in 0..1 + case % 12 {
        text += &shape(case, number, shapes);
    }
    without_bumps_under_skies(text + "WorldEnd")
}

/// Where normals are bent, there are no skies.
fn without_bumps_under_skies(text: String) -> String {
    if text.contains("infinite") { text.replace("\"texture bumpmap\" \"s\"", "") } else { text }
}

/// A picture as a sky: equally bright everywhere, but not of one color; or with a sun.
fn picture_sky(is_even: bool) -> Light {
    let color = |at: usize| match at % 2 {
        _ if !is_even && at == 9 => Vec3::splat(50.0),
        0 => Vec3::X,
        _ => Vec3::new(0.0, 0.0, 0.212_671 / 0.072_169),
    };
    let map = Arc::new(MipMap::new(8, 4, (0..32).map(color).collect(), Wrap::Repeat));
    Light::Environment { map, scale: Vec3::ONE, world_from_light: Transform::IDENTITY, samples: 1 }
}

/// A scene for paths: small, or with a tree; with lights of all kinds.
fn path_scene(case: usize) -> String {
    let depth = case % 8;
    let choice = pick(noise(case, 1.6), &["spatial", "power", "uniform"]);
    let threshold = pick(noise(case, 1.8), &["1", ".5"]);
    let integrator = format!(
        "\"path\" \"integer maxdepth\" {depth} \"string lightsamplestrategy\" \"{choice}\"
         \"float rrthreshold\" {threshold}"
    );
    // Where normals differ, there are no skies.
    let has_normals = noise(case, 1.9) > 0.0;
    let mut text = head(case, &integrator);
    if !has_normals || !lights(case).contains("infinite") {
        text += &lights(case);
    }
    if case.is_multiple_of(7) {
        text +=
            "LightSource \"projection\" \"rgb I\" [30 30 30] LightSource \"goniometric\" \"rgb I\" [3 3 3] ";
    }
    // More than "spatial" estimates.
    if case.is_multiple_of(11) {
        text += &"LightSource \"point\" \"rgb I\" [.1 .1 .1] ".repeat(40);
    }
    for number in 0..1 + case % 9 {
        let shapes = if has_normals {
            &WITH_NORMALS[..]
        } else if case % 5 < 2 {
            &SMALL[..]
        } else {
            &LARGE[..]
        };
        let shape = shape(case, number, shapes);
        let glow = pick(
            noise(case * 16 + number, 9.1),
            &[
                "AreaLightSource \"diffuse\" \"rgb L\" [4 3 2]",
                "AreaLightSource \"diffuse\" \"rgb L\" [1 2 1] \"bool twosided\" \"true\"",
                "",
                "",
            ],
        );
        text += &format!("AttributeBegin {glow} {shape} AttributeEnd ");
    }
    without_bumps_under_skies(text + "WorldEnd")
}

/// Of a scene that is served: whether it has a tree, and whether all is diffuse.
fn kind(text: &str) -> Option<[bool; 2]> {
    let scene = scene(text);
    let Prepared { traceable, lights, .. } = &Prepared::new(&scene);
    Lanes::new(&scene.view, traceable, lights).map(|lanes| [lanes.asks_tree(), lanes.is_lambert()])
}

/// Of a scene with these in its world.
fn is_served(before: &str, world: &str) -> bool {
    kind(&format!(
        "Film \"image\" Camera \"perspective\" Integrator \"directlighting\" {before} WorldBegin {world} WorldEnd"
    ))
    .is_some()
}

/// The scenes of a test are of all kinds.
#[test]
fn scenes_have_trees_and_materials_of_all_kinds() {
    if level().is_none() {
        return;
    }
    for scenes in [direct_scene, path_scene] {
        let kinds: Vec<_> = (0..200).map(|case| kind(&scenes(case)).unwrap()).collect();
        for asked in [[false, false], [false, true], [true, false], [true, true]] {
            let count = kinds.iter().filter(|kind| **kind == asked).count();
            assert!(count >= 15, "{asked:?}: {count}");
        }
    }
}

#[test]
fn only_plain_worlds_are_served() {
    if level().is_none() {
        return;
    }
    let path = "Integrator \"path\"";
    let many = TRIANGLE.repeat(MOST + 1);
    let lamp = "AreaLightSource \"diffuse\" Shape \"sphere\"";
    let picture =
        "Texture \"t\" \"color\" \"checkerboard\" Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\"";
    let bump =
        "Texture \"b\" \"float\" \"fbm\" Material \"plastic\" \"texture bumpmap\" \"b\" Shape \"sphere\"";
    let holes = format!("Texture \"t\" \"float\" \"checkerboard\" {TRIANGLE} \"texture alpha\" \"t\"");
    let copy = "ObjectBegin \"o\" Shape \"sphere\" ObjectEnd ObjectInstance \"o\"";
    for (before, world) in [
        ("", ""),
        ("Camera \"orthographic\" \"float lensradius\" 1", TRIANGLE),
        ("Integrator \"whitted\"", "LightSource \"infinite\" \"integer nsamples\" 2"),
        ("", "ObjectBegin \"o\" Shape \"sphere\" ObjectEnd LightSource \"spot\" Shape \"sphere\""),
        ("", "Material \"matte\" \"float sigma\" 20 Shape \"sphere\""),
        ("", "Material \"plastic\" Shape \"sphere\""),
        ("", picture),
        ("", bump),
        ("", &TRIANGLE.repeat(MOST)),
        ("", &many),
        ("", &format!("LightSource \"infinite\" {CURVE} {DISK} {FIELD}")),
        ("", &format!("LightSource \"point\" {SMOOTH}")),
        (path, TRIANGLE),
        (path, &format!("{bump} {picture} {many}")),
        (path, &format!("LightSource \"infinite\" LightSource \"projection\" {DISK} {lamp} {many}")),
        (path, &format!("LightSource \"point\" {CURVE} {SMOOTH} {lamp}")),
    ] {
        assert!(is_served(before, world), "{before} {world}");
    }
    for (before, world) in [
        ("Camera \"environment\"", TRIANGLE),
        ("Integrator \"ambientocclusion\"", TRIANGLE),
        ("Integrator \"directlighting\" \"string strategy\" \"one\"", TRIANGLE),
        ("", "LightSource \"infinite\" \"integer nsamples\" 2"),
        ("", "LightSource \"projection\""),
        ("", lamp),
        ("", copy),
        ("", "Material \"none\" Shape \"sphere\""),
        ("", "Material \"mirror\" Shape \"sphere\""),
        ("", "Material \"metal\" Shape \"sphere\""),
        ("", &format!("{picture} Material \"glass\" \"texture Kr\" \"t\" Shape \"sphere\"")),
        ("", &format!("LightSource \"infinite\" {bump}")),
        ("", &holes),
        ("", &format!("LightSource \"infinite\" {SMOOTH}")),
        (path, "Material \"none\" Shape \"sphere\""),
        (path, "Material \"glass\" Shape \"sphere\""),
        (path, &format!("LightSource \"infinite\" {bump}")),
        (path, &holes),
        (path, copy),
        (path, &format!("LightSource \"infinite\" {SMOOTH}")),
    ] {
        assert!(!is_served(before, world), "{before} {world}");
    }
}

/// To the bit, with all that processors may have; returns how many rays there were.
fn check(text: &str, sky: Option<Light>) -> u64 {
    let Some(level) = level() else { return u64::MAX };
    let mut levels = vec![level];
    #[cfg(target_arch = "x86_64")]
    levels.extend(level.as_avx2().map(Level::Avx2));
    let mut scene = scene(text);
    Arc::make_mut(&mut scene.world).lights.extend(sky);
    let (sums, rays) = pixels(&scene, None);
    for level in &levels {
        let (own, own_rays) = pixels(&scene, Some(*level));
        assert_eq!(sums, own, "{level:?} {text}");
        assert_eq!(rays, own_rays, "{level:?} {text}");
    }
    rays
}

/// Of these rays, 110,000 are of the camera.
#[test]
fn direct_light_of_samples_side_by_side_is_that_of_samples_one_by_one() {
    let seen = (0..200).map(|case| check(&direct_scene(case), None)).fold(0, u64::saturating_add);
    assert!(seen > 180_000, "{seen}");
}

/// Of these rays, 220,000 are of the camera.
#[test]
fn paths_side_by_side_are_those_one_by_one() {
    let seen = (0..400).map(|case| {
        let text = path_scene(case);
        let has_normals = text.contains("normal N") || text.contains("bumpmap");
        check(&text, (case % 3 == 0 && !has_normals).then(|| picture_sky(case % 2 == 0)))
    });
    let seen = seen.fold(0, u64::saturating_add);
    assert!(seen > 300_000, "{seen}");
}
