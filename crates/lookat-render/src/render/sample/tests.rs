//! Pictures have the same bits at every level.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use fearless_simd::Level;
use glam::Vec3;
use lookat_image::{MipMap, Wrap};
use lookat_scene::{Light, Scene, Transform};

use super::*;
use crate::Progress;
use crate::film::{Film, Keeps};
use crate::inspect::inspect;
use crate::prepare::Prepared;
use crate::render::control::Control;
use crate::render::sample::{Pattern, Samples};
use crate::testing::{levels, noise, scene};

/// More pixels than any test renders: all of them go together.
const ALL: usize = 1000;

/// What some pixels of a scene get, and the number of rays, on a processor of some level, with so many pixels together.
fn pixels(scene: &Scene, level: Level, together: usize) -> (Vec<String>, u64) {
    let mut prepared = Prepared::new(scene);
    prepared.traceable.level = level;
    let progress = |_: Progress| ControlFlow::Continue(());
    let film = Film::new(&scene.view, Keeps::Sums, false);
    let control = Control::new(&progress, &film);
    let context = Context::new(&prepared, &scene.view, &Settings::default(), (&film, &control));
    let (mut worker, mut meter) = (Worker::new(&context), Meter::new(&control));
    let job = |at: u32| Job {
        pattern: Pattern { seed: u64::from(at % 2), ..watched(scene) },
        pixel: [at % 8 * 4, at / 8 * 4].map(u32::cast_signed),
        // All, none, or from the middle on.
        indices: at % 8 * 4..scene.view.sampler.samples_per_pixel,
        weight: 1.0,
        samples: Samples::default(),
    };
    let mut jobs: Vec<Job> = (0..48).map(job).collect();
    for jobs in jobs.chunks_mut(together) {
        context.sample_all(&mut worker, &mut meter, jobs);
    }
    let sums = jobs.iter().map(|job| format!("{:?}", job.samples)).collect();
    (sums, worker.tracer.rays)
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
            "\"environment\"",
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
    let glow = "AreaLightSource \"diffuse\"";
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
         MakeNamedMaterial \"m\" \"string type\" \"matte\" MakeNamedMaterial \"g\" \"string type\" \"glass\"
         Texture \"h\" \"float\" \"checkerboard\" \"float uscale\" 4 \"float vscale\" 4
         ObjectBegin \"o\" {CORNER} {SPHERE} {CURVE} AttributeBegin {glow} Translate .5 1 0 {SQUARE}
         AttributeEnd Material \"matte\" \"texture Kd\" \"t\" Scale 1 .5 1 {FIELD} ObjectEnd
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

/// Materials with other lobes than matte and plastic have, and none.
const OTHERS: [&str; 12] = [
    "\"glass\"",
    "\"mirror\" \"rgb Kr\" [.9 .8 .9]",
    "\"glass\" \"float uroughness\" .2 \"float vroughness\" .1",
    "\"metal\" \"texture roughness\" \"s\"",
    "\"uber\" \"rgb Kr\" [.2 .2 .2] \"rgb opacity\" [.5 .5 .5] \"texture Kd\" \"t\"",
    "\"translucent\" \"texture Kd\" \"t\"",
    "\"substrate\" \"texture bumpmap\" \"s\"",
    "\"none\"",
    "\"\"",
    "\"metal\" \"float roughness\" .3",
    "\"mirror\" \"texture bumpmap\" \"s\"",
    "\"mix\" \"string namedmaterial1\" \"m\" \"string namedmaterial2\" \"g\" \"texture amount\" \"t\"",
];

/// A shape in its pixel, with a material.
fn shape(case: usize, number: usize, shapes: &[&str], others: &[&str]) -> String {
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
    let mut material = format!("\"{kind}\" {color} {material}");
    if !others.is_empty() && number(8.2) > 0.2 {
        material = pick(number(8.3), others);
    }
    let turn = 180.0 * number(5.1);
    let shape = pick(number(6.1), shapes);
    let (orientation, turned) =
        (if number(7.1) > 0.0 { "ReverseOrientation" } else { "" }, number(7.2) > 0.0);
    let turn = if turned { format!("Rotate {turn} 1 .4 .2") } else { String::new() };
    format!(
        "AttributeBegin Translate {x} {y} {z} {turn} Scale {across} {up} {along} {orientation}
         Material {material} {shape} AttributeEnd "
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
const HOLES: &str = "Shape \"trianglemesh\" \"point P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] \"texture alpha\" \"h\"
    \"float shadowalpha\" 1 \"integer indices\" [0 1 2 0 2 3] \"float uv\" [0 0 1 0 1 1 0 1]";
const COPY: &str = "ObjectInstance \"o\"";
const FIELD: &str = "Shape \"heightfield\" \"integer nu\" 6 \"integer nv\" 6 \"float Pz\"
    [0 .1 0 .2 0 .1  .3 0 .2 .1 0 .1  0 .2 0 .1 .3 0  .1 0 .2 0 .1 0  0 .1 .2 0 .3 .1  0 .2 0 .1 .1 0]";

/// What small worlds may have; what needs a tree; and what has shading normals of its own.
const SMALL: [&str; 7] = [SPHERE, SPHERE, PARTIAL, SQUARE, TRIANGLE, CORNER, HOLES];
const LARGE: [&str; 10] = [SPHERE, SQUARE, CORNER, FIELD, TANGENTS, DISK, CURVE, PARTIAL, HOLES, COPY];
const WITH_NORMALS: [&str; 10] = [SPHERE, SQUARE, SMOOTH, SMOOTH, FIELD, DISK, CURVE, TANGENTS, HOLES, COPY];

/// A scene for direct lighting or ambient occlusion: small, or with a tree.
fn direct_scene(case: usize) -> String {
    let depth = case % 4;
    let integrator = pick(
        noise(case, 1.6),
        &[
            "\"directlighting\"",
            "\"directlighting\" \"string strategy\" \"one\"",
            "\"whitted\"",
            "\"ambientocclusion\" \"integer nsamples\" 3",
            "\"ambientocclusion\" \"integer nsamples\" 1 \"bool cossample\" \"false\"",
        ],
    );
    let depth =
        if integrator.contains("ambient") { String::new() } else { format!("\"integer maxdepth\" {depth}") };
    let text = head(case, &format!("{integrator} {depth}")) + &lights(case);
    shapes(
        case,
        text.replace("\"infinite\"", &format!("\"infinite\" \"integer nsamples\" {} ", 1 + case % 3)),
    )
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
    let mut text = head(case, &integrator) + &lights(case);
    if case.is_multiple_of(7) {
        text +=
            "LightSource \"projection\" \"rgb I\" [30 30 30] LightSource \"goniometric\" \"rgb I\" [3 3 3] ";
    }
    // More than "spatial" estimates.
    if case.is_multiple_of(11) {
        text += &"LightSource \"point\" \"rgb I\" [.1 .1 .1] ".repeat(40);
    }
    shapes(case, text)
}

/// Shapes of all kinds, some of which glow.
fn shapes(case: usize, mut text: String) -> String {
    let has_normals = noise(case, 1.9) > 0.0;
    let others = if case % 4 == 3 { &OTHERS[..] } else { &[] };
    for number in 0..1 + case % 9 {
        let shapes = if has_normals {
            &WITH_NORMALS[..]
        } else if case % 5 < 2 {
            &SMALL[..]
        } else {
            &LARGE[..]
        };
        let shape = shape(case, number, shapes, others);
        let glow = pick(
            noise(case * 16 + number, 9.1),
            &[
                "AreaLightSource \"diffuse\" \"rgb L\" [4 3 2]",
                "AreaLightSource \"diffuse\" \"rgb L\" [1 2 1] \"bool twosided\" \"true\" \"integer samples\" 2",
                "",
                "",
            ],
        );
        text += &format!("AttributeBegin {glow} {shape} AttributeEnd ");
    }
    text + "WorldEnd"
}

/// True if a scene has a tree, and whether any material is more than matte.
fn kind(text: &str) -> [bool; 2] {
    let scene = scene(text);
    let found = inspect(&Prepared::new(&scene), &scene.view);
    [
        found.uses_bvh,
        found.surfaces.is_some_and(|surfaces| surfaces.kinds.iter().any(|kind| *kind != "matte")),
    ]
}

/// The scenes of a test are of all kinds.
#[test]
fn scenes_have_trees_and_materials_of_all_kinds() {
    for scenes in [direct_scene, path_scene] {
        let kinds: Vec<_> = (0..300).map(|case| kind(&scenes(case))).collect();
        for asked in [[false, false], [false, true], [true, false], [true, true]] {
            let count = kinds.iter().filter(|kind| **kind == asked).count();
            assert!(count >= 15, "{asked:?}: {count}");
        }
    }
}

/// To the bit, with all that processors may have; returns how many rays there were.
fn check(text: &str, sky: Option<Light>) -> u64 {
    let mut scene = scene(text);
    Arc::make_mut(&mut scene.world).lights.extend(sky);
    let (sums, rays) = pixels(&scene, Level::new(), ALL);
    for level in levels() {
        let (own, own_rays) = pixels(&scene, level, ALL);
        assert_eq!(sums, own, "{level:?} {text}");
        assert_eq!(rays, own_rays, "{level:?} {text}");
    }
    // Nor do samples depend on those beside them.
    assert_eq!((sums, rays), pixels(&scene, Level::new(), 1), "{text}");
    rays
}

#[test]
fn direct_light_has_the_same_bits_at_every_level() {
    let seen = (0..200)
        .map(|case| check(&direct_scene(case), (case % 5 == 0).then(|| picture_sky(case % 2 == 0))))
        .fold(0, u64::saturating_add);
    assert!(seen > 180_000, "{seen}");
}

#[test]
fn paths_have_the_same_bits_at_every_level() {
    let seen =
        (0..400).map(|case| check(&path_scene(case), (case % 3 == 0).then(|| picture_sky(case % 2 == 0))));
    let seen = seen.fold(0, u64::saturating_add);
    assert!(seen > 300_000, "{seen}");
}

/// What became of jobs that were broken off.
struct Broken {
    calls: u64,
    rays: u64,
    is_stopped: bool,
}

/// Does jobs, and breaks off at so many calls of the callback.
fn broken_off(most: u64, (scene, prepared): (&Scene, &Prepared), jobs: &mut [Job]) -> Broken {
    let film = Film::new(&scene.view, Keeps::Sums, false);
    let calls = AtomicU64::new(0);
    let progress = |_: Progress| match calls.fetch_add(1, Ordering::Relaxed) + 1 < most {
        true => ControlFlow::Continue(()),
        false => ControlFlow::Break(()),
    };
    let control = Control::new(&progress, &film);
    let context = Context::new(prepared, &scene.view, &Settings::default(), (&film, &control));
    let (mut worker, mut meter) = (Worker::new(&context), Meter::new(&control));
    context.sample_all(&mut worker, &mut meter, jobs);
    let calls = calls.load(Ordering::Relaxed);
    Broken { calls, rays: worker.tracer.rays, is_stopped: worker.tracer.is_stopped }
}

/// The pattern of the scene, watched.
fn watched(scene: &Scene) -> Pattern {
    Pattern { sampler: scene.view.sampler, seed: 5, is_watched: true }
}

/// However many rays a sample takes, the callback is called soon, and may end the rendering. Once samples are known to be slow, few
/// are taken together.
#[test]
fn samples_of_many_rays_are_interrupted() {
    for integrator in [
        "\"ambientocclusion\" \"integer nsamples\" 65536",
        "\"directlighting\"",
        "\"path\" \"integer maxdepth\" 20000 \"float rrthreshold\" 0",
    ] {
        let scene = scene(&format!(
            "Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator {integrator} WorldBegin
            AreaLightSource \"diffuse\" \"integer samples\" 65536 Material \"matte\" \"rgb Kd\" [1 1 1]
            ReverseOrientation Shape \"sphere\" \"float radius\" 9 WorldEnd"
        ));
        let prepared = Prepared::new(&scene);
        for most in [1, 10] {
            let mut jobs: Vec<Job> = (0..256).map(|x| Job::new(watched(&scene), [x, 9], 0..1)).collect();
            let Broken { calls, rays, .. } = broken_off(most, (&scene, &prepared), &mut jobs);
            assert_eq!(calls, most, "{integrator}");
            assert!(rays > 0 && rays <= most << 15, "{integrator}: {rays} rays in {most} calls");
            // Samples that are not complete do not count.
            assert!(jobs.iter().all(|job| job.samples.count == 0));
        }
    }
}

/// Of a batch that is broken off, no fast sample is kept without the slow ones beside it: pixels have the first samples of a complete
/// rendering, one pixel after the other.
#[test]
fn fast_samples_of_a_broken_batch_do_not_count() {
    const SAMPLES: u32 = 3;
    let scene = scene(
        "Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator \"ambientocclusion\" \"integer nsamples\" 4096
        WorldBegin Translate 0 0 5 Shape \"sphere\" \"float radius\" 2 Translate 0 3 0 Shape \"sphere\" WorldEnd",
    );
    let prepared = Prepared::new(&scene);
    // Samples of every second pixel hit a sphere, and take many rays.
    let render = |most: u64, counts: [u32; 48]| {
        let pixel = |at: i32| if at % 2 == 0 { [640 + at, 360] } else { [9, at] };
        let job = |at: i32| Job::new(watched(&scene), pixel(at), 0..counts[at as usize]);
        let mut jobs: Vec<Job> = (0..48).map(job).collect();
        let broken = broken_off(most, (&scene, &prepared), &mut jobs);
        let samples: Vec<String> = jobs.iter().map(|job| format!("{:?}", job.samples)).collect();
        let counts: [u32; 48] = std::array::from_fn(|at| jobs[at].samples.count);
        (samples, counts, broken.is_stopped)
    };
    let mut broken = 0;
    for most in 2..8 {
        let (samples, counts, is_broken) = render(most, [SAMPLES; 48]);
        broken += u32::from(is_broken);
        let whole = counts.iter().take_while(|count| **count == SAMPLES).count();
        assert!(whole < 48 && counts.iter().skip(whole + 1).all(|count| *count == 0), "{counts:?}");
        assert_eq!(samples, render(u64::MAX, counts).0, "{counts:?}");
    }
    assert!(broken > 1, "{broken}");
}

/// A tile that begins where samples are slow begins with few of them.
#[test]
fn meters_remember_slow_samples() {
    let scene = scene("Film \"image\" Camera \"perspective\" WorldBegin Shape \"sphere\" WorldEnd");
    let film = Film::new(&scene.view, Keeps::Sums, false);
    let control = Control::new(&|_| ControlFlow::Continue(()), &film);
    let batch = |samples: u32, rays: u64| {
        let mut meter = Meter::new(&control);
        meter.add(samples, rays);
        Meter::new(&control).batch()
    };
    assert_eq!(Meter::new(&control).batch(), LANES, "nothing is known");
    assert_eq!([batch(8, 80), batch(64, 640)], [PATHS; 2]);
    assert_eq!(batch(64, 64 << 16), LANES);
    assert_eq!(batch(8, 8), LANES, "one fast batch is not enough");
    assert_eq!((0..50).map(|_| batch(8, 8)).max(), Some(PATHS));
}

/// Where no light is sampled, surfaces look for it twice, and a batch more often than it can keep rays. The light of those that were traced
/// on the way counts, although black surfaces come last.
#[test]
fn rays_that_look_for_emission_are_counted_however_many_there_are() {
    let square = |kd: f64, x: [f64; 2]| {
        let [from, to] = x;
        format!(
            "Material \"matte\" \"rgb Kd\" [{kd} {kd} {kd}] Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]
             \"point P\" [{from} -9 5 {from} 9 5 {to} 9 5 {to} -9 5] "
        )
    };
    // The first pixel of a batch is white, with half of its samples.
    let squares = square(0.5, [-9.0, -0.8]) + &square(0.0, [-0.8, 9.0]);
    for integrator in ["\"path\" \"integer maxdepth\" 1", "\"directlighting\""] {
        let text = format!(
            "Camera \"orthographic\" \"float screenwindow\" [-1 1 -1 1] PixelFilter \"box\"
             Film \"image\" \"integer xresolution\" 32 \"integer yresolution\" 24
             Sampler \"sobol\" \"integer pixelsamples\" 32 Integrator {integrator} WorldBegin
             LightSource \"infinite\" \"rgb L\" [1 1 1] {squares} WorldEnd"
        );
        check(&text, None);
    }
}
