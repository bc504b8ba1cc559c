//! Lights are chosen as often as is said, and where they shine.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use fearless_simd::mask32x8;
use glam::{DVec2, DVec3, Vec3};
use lookat_image::{MipMap, Wrap};
use lookat_scene::{DirectStrategy, Integrator, Light, LoadOptions, Transform, load};

use super::*;
use crate::Prepared;
use crate::bsdf::Domain;
use crate::light::Lunes;
use crate::render::{Settings, render};
use crate::testing::{baseline, surfaces_at};

/// A lamp, one that is dark, a sphere and two skies; and the same with more lamps than "spatial" estimates.
const LAMPS: &str = r#"LightSource "infinite" "rgb L" [.5 .5 .5] LightSource "point" "rgb I" [9 9 9]
    LightSource "point" "rgb I" [0 0 0] LightSource "infinite" "rgb L" [.1 .1 .1]
    AttributeBegin AreaLightSource "diffuse" Translate 3 0 0 Shape "sphere" AttributeEnd"#;

/// Bytes of stack: without optimization, the frames of the code for eight points are larger than the stack of a test.
const STACK: usize = 64 << 20;

fn with(lamps: &str, with_sky: bool, check: impl Fn(&LightTable) + Sync) {
    let text = format!("Film \"image\" Camera \"perspective\" WorldBegin {lamps} Shape \"sphere\" WorldEnd");
    let loaded = load(Path::new("x"), &|_| Ok(text.clone().into()), &LoadOptions::default());
    let mut scene = loaded.scene.unwrap_or_else(|| panic!("{:?}", loaded.diagnostics));
    let mut texels = vec![Vec3::splat(0.1); 32];
    texels[9] = Vec3::splat(5.0);
    let map = Arc::new(MipMap::new(8, 4, texels, Wrap::Repeat));
    let world_from_light = Transform::IDENTITY;
    let sky = Light::Environment { map, scale: Vec3::ONE, world_from_light, samples: 1 };
    if with_sky {
        Arc::make_mut(&mut scene.world).lights.push(sky);
    }
    let check = || check(&Prepared::new(&scene).lights);
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, check).unwrap();
        thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    });
}

/// A point that looks for light: its normals, whether light comes through, and whether it is diffuse.
#[derive(Clone, Copy)]
struct At {
    p: DVec3,
    ns: DVec3,
    is_two_sided: bool,
    is_diffuse: bool,
}

/// A diffuse floor.
const FLOOR: At = At { p: DVec3::ZERO, ns: DVec3::Y, is_two_sided: false, is_diffuse: true };

impl At {
    /// Asks the lights of a table at this point.
    fn ask<S: Simd, T>(
        self,
        (simd, table, choice): (S, &LightTable, LightChoice),
        ask: impl FnOnce(&LightSampler<S>) -> T,
    ) -> T {
        let [n, ns] = [DVec3::Y, self.ns].map(|n| Vec3fx8::splat(simd, n.as_vec3()));
        let [is_two_sided, is_diffuse] =
            [self.is_two_sided, self.is_diffuse].map(|all| mask32x8::splat(simd, all));
        let domain = Domain { n, ns, is_two_sided, is_diffuse };
        let lunes = if table.has_skies() { Lunes::new(&domain, bits(simd, 0xff)) } else { None };
        let at = Receivers { surfaces: surfaces_at(simd, self.p), domain, lunes };
        ask(&LightSampler::new(simd, (table, choice), &at, &mut Estimates::new()))
    }

    /// The probabilities of all lights.
    fn probabilities(self, table: &LightTable, choice: LightChoice) -> Vec<f64> {
        baseline!(simd => self.ask((simd, table, choice), |sampler| {
            let of = |light: u32| sampler.probability((light.simd_into(simd), 0.simd_into(simd)), bits(simd, 1))[0];
            (0..table.len() as u32).map(of).map(f64::from).collect()
        }))
    }
}

/// Lights are chosen as often as they are said to be.
#[test]
fn probabilities_are_those_of_choices() {
    const NUMBERS: u32 = 1 << 14;
    let p = DVec3::new(0.5, 1.0, 2.0);
    let tilted = |degrees: f64| DVec2::from_angle((90.0 - degrees).to_radians()).extend(0.0);
    let (plain, lune) = (At { p, ..FLOOR }, At { p, ns: tilted(20.0), is_diffuse: false, ..FLOOR });
    let double = At { ns: tilted(60.0), is_two_sided: true, ..lune };
    let many = LAMPS.to_string() + &r#" LightSource "point" "rgb I" [.1 .1 .1]"#.repeat(MANY);
    for lamps in [LAMPS, &many, r#"LightSource "infinite""#, r#"LightSource "infinite" LightSource "point""#]
    {
        for with_sky in [false, true] {
            with(lamps, with_sky, |table| {
                for choice in [LightChoice::Uniform, LightChoice::Power, LightChoice::Spatial] {
                    for at in [plain, lune, double] {
                        let expected = at.probabilities(table, choice);
                        let mut found = vec![0_u32; table.len()];
                        for index in 0..NUMBERS {
                            let u = (f64::from(index) + 0.5) / f64::from(NUMBERS);
                            let chosen = baseline!(simd => at.ask((simd, table, choice), |sampler| {
                                let chosen = sampler.choose(u.simd_into(simd), bits(simd, 1));
                                chosen.is_valid.any_true().then(|| (chosen.light[0], f64::from(chosen.probability[0])))
                            }));
                            let Some((light, said)) = chosen else { continue };
                            let light = light as usize;
                            assert!(
                                (said / expected[light] - 1.0).abs() <= f64::from(f32::EPSILON),
                                "{choice:?} {light}"
                            );
                            found[light] += 1;
                        }
                        for (light, found) in found.into_iter().enumerate() {
                            let found = f64::from(found) / f64::from(NUMBERS);
                            let said = expected[light];
                            assert!((found - said).abs() < 3e-4, "{choice:?} {light}: {found} {said}");
                        }
                    }
                }
            });
        }
    }
}

/// Of a million lamps that are alike, each is chosen by the numbers of its share, with the probability that is said.
#[test]
fn each_of_a_million_lamps_has_its_share() {
    const LAMPS: usize = 1_000_000;
    let mut scene =
        crate::testing::scene("Film \"image\" Camera \"perspective\" WorldBegin Shape \"sphere\" WorldEnd");
    let lamp = Light::Point { position: DVec3::Y, intensity: Vec3::ONE };
    Arc::make_mut(&mut scene.world).lights = vec![lamp; LAMPS];
    let table = &Prepared::new(&scene).lights;
    baseline!(simd => FLOOR.ask((simd, table, LightChoice::Power), |sampler| {
        let all = bits(simd, 0xff);
        for first in (0..LAMPS).step_by(LANES) {
            let lamps: u32x8<_> = u32x8::from_fn(simd, |lane| (first + lane) as u32);
            let start: f64x8<_> = f64x8::from_fn(simd, |lane| f64::from(lamps[lane]));
            for part in [1e-4, 1.0 - 1e-4] {
                let chosen = sampler.choose((start + part) / LAMPS as f64, all);
                assert_eq!(chosen.light.to_array(), lamps.to_array());
                let probability = sampler.probability((lamps, lamps), all);
                assert_eq!(chosen.probability.to_array(), probability.to_array());
                assert!((probability * LAMPS as f32 - 1.0).abs().simd_le(f32::EPSILON).all_true());
            }
        }
    }));
    let ends = &table.power_cdf;
    let shares = ends.windows(2).map(|ends| (ends[1] - ends[0]) / table.power_of_others());
    assert!(shares.into_iter().all(|share| (share * LAMPS as f64 - 1.0).abs() < 1e-9));
}

/// A lamp above a floor, and others that do not light it: from below, from behind their backs, or past it.
const BESIDE: &str = r#"LightSource "point" "rgb I" [1 1 1] "point from" [1 2 0]
    LightSource "point" "rgb I" [9 9 9] "point from" [0 -1 0]
    LightSource "distant" "rgb L" [9 9 9] "point from" [0 -1 0] "point to" [0 0 0]
    LightSource "spot" "rgb I" [9 9 9] "point from" [3 1 0] "point to" [9 1 0]
    AttributeBegin Translate 3 1 0 Rotate 90 0 1 0 LightSource "projection" "rgb I" [9 9 9] AttributeEnd
    AttributeBegin AreaLightSource "diffuse" "rgb L" [9 9 9] Translate 0 3 0 Rotate -90 1 0 0
    Shape "disk" "float radius" .2 AttributeEnd
    AttributeBegin AreaLightSource "diffuse" "rgb L" [9 9 9] Shape "trianglemesh" "integer indices" [0 1 2]
    "point P" [0 3 0 1 3 0 0 3 -1] AttributeEnd
    AttributeBegin AreaLightSource "diffuse" "rgb L" [9 9 9] ReverseOrientation Translate 0 3 0 Rotate 90 1 0 0
    Shape "disk" "float radius" .2 AttributeEnd
    AttributeBegin AreaLightSource "diffuse" "rgb L" [9 9 9] ReverseOrientation Scale -1 1 1
    Shape "trianglemesh" "integer indices" [0 1 2] "point P" [0 3 0 0 3 -1 1 3 0] AttributeEnd
    AttributeBegin AreaLightSource "diffuse" "rgb L" [9 9 9] Shape "trianglemesh" "integer indices" [0 1 2]
    "point P" [0 3 0 0 3 -1 1 3 0] "normal N" [0 1 0 .6 .8 0 0 1 0] AttributeEnd"#;

/// Lamps that do light it: from both sides, by normals that differ, and above the horizon with their rim alone.
const AROUND: &str = r#"
    AttributeBegin AreaLightSource "diffuse" "bool twosided" "true" Translate 0 3 0 Rotate -90 1 0 0
    Shape "disk" "float radius" .2 AttributeEnd
    AttributeBegin AreaLightSource "diffuse" Shape "trianglemesh" "integer indices" [0 1 2]
    "point P" [0 3 0 1 3 0 0 3 -1] "normal N" [0 1 0 0 -1 0 0 1 0] AttributeEnd
    AttributeBegin AreaLightSource "diffuse" Translate 3 -.5 0 Shape "sphere" AttributeEnd"#;

#[test]
fn lights_that_shine_elsewhere_are_not_chosen() {
    with(BESIDE, false, |table| {
        let shares = |at: At| -> Vec<bool> {
            let shares = at.probabilities(table, LightChoice::Spatial);
            assert!((shares.iter().sum::<f64>() - 1.0).abs() <= f64::from(f32::EPSILON), "{shares:?}");
            shares.iter().map(|share| *share > 0.0).collect()
        };
        let (above, below) = ([true, false, false], [true; 3]);
        assert_eq!(shares(FLOOR), [above.as_slice(), &[false; 7]].concat());
        // Through what lets light through, two more shine.
        let through = At { is_two_sided: true, is_diffuse: false, ..FLOOR };
        assert_eq!(shares(through), [below.as_slice(), &[false; 7]].concat());
    });
    with(AROUND, false, |table| {
        // From a floor, and from the middle of each of the lamps.
        for p in [DVec3::ZERO, DVec3::Y * 3.0, DVec3::new(1.0, 9.0, -1.0) / 3.0, DVec3::new(3.0, -0.5, 0.0)] {
            let shares = At { p, ..FLOOR }.probabilities(table, LightChoice::Spatial);
            assert!((shares.iter().sum::<f64>() - 1.0).abs() <= f64::from(f32::EPSILON), "{p} {shares:?}");
            assert!(p != DVec3::ZERO || shares.iter().all(|share| *share > 0.0), "{shares:?}");
        }
    });
}

/// In grazing light a glossy surface has its highlight: that light is not to be chosen seldom.
#[test]
fn glossy_surfaces_do_not_ask_for_cosines() {
    let lamps = r#"LightSource "distant" "point from" [0 9 0] LightSource "distant" "point from" [9 .01 0]"#;
    with(lamps, false, |table| {
        let share = |is_diffuse| At { is_diffuse, ..FLOOR }.probabilities(table, LightChoice::Spatial)[1];
        assert_eq!(share(false), 0.5);
        assert!(share(true) < 0.1);
    });
}

/// Other integrators sample a light as often as it asks to be.
#[test]
fn whitted_samples_each_light_once() {
    for (integrator, samples) in [("whitted", 1), ("directlighting", 8), ("path", 8)] {
        let scene = crate::testing::scene(&format!(
            r#"Film "image" Camera "perspective" Integrator "{integrator}" WorldBegin
            AreaLightSource "diffuse" "integer nsamples" 8 Shape "sphere" WorldEnd"#
        ));
        let strategy = match scene.view.integrator {
            Integrator::DirectLighting { strategy, .. } => strategy,
            _ => DirectStrategy::All,
        };
        assert_eq!(Prepared::new(&scene).lights.samples(0, strategy), samples);
    }
}

/// Lights of all kinds that are estimated one by one.
const FEW: &str = r#"
    LightSource "point" "rgb I" [9 9 9] "point from" [-2 2 0] LightSource "point" "rgb I" [9 9 9] "point from" [0 .5 2]
    LightSource "spot" "rgb I" [40 40 40] "point from" [2 3 -1] "point to" [1 0 0] "float coneangle" 25
    AttributeBegin Translate -2 2 -1 Rotate 90 1 0 0 LightSource "projection" "rgb I" [9 9 9] AttributeEnd
    AttributeBegin AreaLightSource "diffuse" "rgb L" [5 5 5] Translate 2 1 1 Shape "sphere" "float radius" .3 AttributeEnd
    AttributeBegin AreaLightSource "diffuse" "rgb L" [9 9 9] Translate 0 3 0 Rotate 90 1 0 0
    Shape "disk" "float radius" .5 AttributeEnd
    AttributeBegin AreaLightSource "diffuse" "rgb L" [9 9 9] Shape "trianglemesh" "integer indices" [0 1 2]
    "point P" [-2 0 1 -2 1 1 -2 0 2] AttributeEnd"#;

/// And more of them, on a circle.
fn many() -> String {
    let more = |i: u32| {
        let [x, z] = (DVec2::from_angle(f64::from(i)) * 3.0).to_array();
        format!(
            r#"LightSource "point" "rgb I" [.1 .1 .1] "point from" [{x} .5 {z}]
            AttributeBegin Translate {x} 1 {z} AreaLightSource "diffuse" Shape "sphere" "float radius" .05
            AttributeEnd "#
        )
    };
    // A mesh of separate triangles, turned in all ways.
    let corners = |i: u32| {
        let [x, z] = (DVec2::from_angle(f64::from(i) * 2.0) * 2.5).to_array();
        let d = DVec3::new(f64::from(i).cos(), f64::from(i * i).sin(), 0.5) * 0.3;
        format!("{x} .7 {z} {} {} {} {} 1 {z} ", x + d.x, 0.7 + d.y, z + d.z, x + 0.2)
    };
    let (indices, p): (String, String) =
        ((0..60).map(|i| format!("{i} ")).collect(), (0..20).map(corners).collect());
    let mesh = format!(r#"Shape "trianglemesh" "integer indices" [{indices}] "point P" [{p}]"#);
    let mesh = format!(r#"AttributeBegin AreaLightSource "diffuse" "rgb L" [2 2 2] {mesh} AttributeEnd"#);
    let beside = r#"LightSource "distant" "rgb L" [.1 .1 .1] LightSource "infinite" "rgb L" [.05 .05 .05]"#;
    [FEW, beside, &mesh, &(0..40).map(more).collect::<String>()].join(" ")
}

/// A ball of triangles, more than are sampled each where all lights are sampled, close to what it lights; and a mesh of four.
fn ball() -> String {
    const AROUND: usize = 8;
    let at = |i: usize, j: usize| i * AROUND + j % AROUND;
    let (mut indices, mut p) = (String::new(), String::new());
    for (i, j) in (0..=AROUND).flat_map(|i| (0..AROUND).map(move |j| (i, j))) {
        let [out, up] = DVec2::from_angle(PI * i as f64 / AROUND as f64).to_array().map(|x| 0.4 * x);
        let [x, z] = (DVec2::from_angle(2.0 * PI * j as f64 / AROUND as f64) * up).to_array();
        p += &format!("{} {} {} ", x - 0.8, out + 0.5, z);
        if i < AROUND {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)];
            if i > 0 {
                indices += &format!("{a} {b} {d} ");
            }
            if i < AROUND - 1 {
                indices += &format!("{a} {d} {c} ");
            }
        }
    }
    format!(
        r#"AttributeBegin AreaLightSource "diffuse" "rgb L" [3 2 1] "bool twosided" "true"
        Shape "trianglemesh" "integer indices" [{indices}] "point P" [{p}]
        AreaLightSource "diffuse" "rgb L" [8 8 8] "integer nsamples" 2 "bool twosided" "true"
        Shape "trianglemesh" "integer indices" [0 1 2 1 2 3 4 5 6 5 6 7]
        "point P" [1 .1 -1 1 .1 1 1 1 -1 1 1 1 -.5 1 1 .5 1 1 -.5 2 1 .5 2 1] AttributeEnd"#
    )
}

/// The light in a picture is the same however lights are chosen, and whether all are sampled or one; and there is less noise where they are chosen by place.
#[test]
fn choices_change_no_mean() {
    compare_choices(FEW, 0.6);
    compare_choices(&many(), 0.6);
    // One of two meshes in view: choices between them matter less than edges.
    compare_choices(&ball(), 1.0);
}

/// `less`: the most noise of the better choices, over that of equal probabilities.
fn compare_choices(lights: &str, less: f64) {
    let mut scene = crate::testing::scene(&format!(
        r#"LookAt 0 1.5 -3 0 0 0 0 1 0 Camera "perspective" "float fov" 40 Film "image" "integer xresolution" 16 "integer yresolution" 12
        Sampler "random" "integer pixelsamples" 16 Integrator "path" WorldBegin
        {lights}
        Material "plastic" Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-4 0 -4 -4 0 4 4 0 4 4 0 -4]
        Material "translucent" Translate 0 .3 0 Shape "sphere" "float radius" .3 WorldEnd"#,
    ));
    const PICTURES: u64 = 16;
    let variance = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64
    };
    // The mean of all pictures, the variance of this mean, and the variance of pixels.
    let mut looked_at = |integrator: Integrator| -> (f64, f64, f64) {
        scene.view.integrator = integrator;
        let picture = |seed| -> Vec<f64> {
            let settings = Settings { seed, ..Settings::default() };
            let rendered = render(&scene, &settings, &|_| ControlFlow::Continue(()));
            rendered.image.rgb().unwrap().iter().map(|pixel| f64::from(pixel[0])).collect()
        };
        let pictures: Vec<Vec<f64>> = (0..PICTURES).map(picture).collect();
        let pixels = pictures[0].len();
        let means: Vec<f64> =
            pictures.iter().map(|picture| picture.iter().sum::<f64>() / pixels as f64).collect();
        let of_pixel = |at: usize| variance(&pictures.iter().map(|picture| picture[at]).collect::<Vec<_>>());
        let noise = (0..pixels).map(of_pixel).sum::<f64>() / pixels as f64;
        (means.iter().sum::<f64>() / PICTURES as f64, variance(&means) / PICTURES as f64, noise)
    };
    let path = |light_choice| Integrator::Path { max_depth: 1, roulette_threshold: 1.0, light_choice };
    let direct = |strategy| Integrator::DirectLighting { strategy, max_depth: 1 };
    let (expected, uniform, noise) = looked_at(path(LightChoice::Uniform));
    for (number, integrator) in [
        path(LightChoice::Power),
        path(LightChoice::Spatial),
        direct(DirectStrategy::One),
        direct(DirectStrategy::All),
        direct(DirectStrategy::EachOnce),
    ]
    .into_iter()
    .enumerate()
    {
        let what = format!("{integrator:?}");
        let (mean, variance, own) = looked_at(integrator);
        assert!((mean - expected).abs() < 4.0 * (variance + uniform).sqrt(), "{what}: {mean} {expected}");
        assert!(number == 0 || own < less * noise, "{what}: {own} {noise}");
    }
}
