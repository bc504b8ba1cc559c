//! Spheres that are far away, large, or touched.

use glam::DVec3;
use lookat_render::{Probe, Ray};
use rand::RngExt;

use super::{Truth, aimed, direction, sphere_at_eye};
use crate::stability::case::{Effort, Found, LOOKAT};
use crate::stability::methods::{double, single, sphere as by};
use crate::stability::tally::{Tally, tally};
use crate::text_scene::scene;

const METHODS: [&str; 9] = [
    LOOKAT,
    "naive f32",
    "naive f64",
    "stable quadratic f32",
    "stable quadratic f64",
    "Haines f32",
    "Haines f64",
    "pbrt-v3",
    "pbrt-v4",
];

/// What all methods say of a ray relative to the center. Those in single precision get the ray rounded, and its truth.
fn ask(tallies: &mut [Tally; 9], own: Option<f64>, o: DVec3, d: DVec3, radius: f64) {
    let mut count = |method: usize, truth: &Truth, answer: bool| {
        if let Some(hits) = truth.hits {
            tallies[method].answer(answer == hits);
        }
    };
    let truth = Truth::new(o, d, radius);
    count(0, &truth, own.is_some());
    let (a, b) = (o.to_array(), d.to_array());
    count(2, &truth, by::naive(a, b, radius).is_some());
    count(4, &truth, by::stable(a, b, radius).is_some());
    count(6, &truth, by::haines(a, b, radius).is_some());
    let (a, b, radius) = (single(o), single(d), radius as f32);
    let truth = Truth::new(double(a), double(b), f64::from(radius));
    count(1, &truth, by::naive(a, b, radius).is_some());
    count(3, &truth, by::stable(a, b, radius).is_some());
    count(5, &truth, by::haines(a, b, radius).is_some());
    count(7, &truth, by::pbrt_v3(a, b, radius).is_some());
    count(8, &truth, by::pbrt_v4(a, b, radius).is_some());
}

pub(super) fn far(effort: &Effort) -> Found {
    let scene = sphere_at_eye(1.0);
    let probe = Probe::new(&scene);
    let mut found = Found::default();
    for exponent in 0..10 {
        let distance = if exponent == 0 { 1.5 } else { 10_f64.powi(exponent) };
        let mut tallies = tally(effort.rays, 100 + exponent as u64, |random, tallies| {
            let (o, d) = aimed(random, distance);
            ask(tallies, probe.nearest(&Ray::new(o, d)).map(|hit| hit.t), o, d, 1.0);
        });
        // Nearer, the distance is short against the coordinates that it comes from.
        if distance >= 10.0 {
            tallies[0].worst = Some(share_off(&probe, effort, distance));
        }
        found.add(Some(distance), &METHODS, &tallies);
    }
    found
}

/// The share of hits whose distance is off by more than 2 units in the last place.
fn share_off(probe: &Probe, effort: &Effort, distance: f64) -> f64 {
    let [off] = tally(effort.rays.min(100_000), 150, |random, [off]: &mut [Tally; 1]| {
        let (o, d) = aimed(random, distance);
        if let (Some(hit), Some(t)) = (probe.nearest(&Ray::new(o, d)), Truth::new(o, d, 1.0).nearest()) {
            off.answer((hit.t - t).abs() <= 2.0 * (t.next_up() - t));
        }
    });
    off.failed as f64 / off.tried as f64
}

/// The radius of a planet and the height of the eye above it, in meters.
const PLANET: f64 = 6.4e6;
const EYE: f64 = 1.7;

pub(super) fn ground(effort: &Effort) -> Found {
    let scene = scene(&format!(
        r#"LookAt 0 {EYE} 0  0 {EYE} 1  0 1 0 Camera "perspective" Integrator "path" Sampler "sobol" Film "image"
           WorldBegin LightSource "infinite" Translate 0 {} 0 Shape "sphere" "float radius" [{PLANET}] WorldEnd"#,
        -PLANET
    ));
    let probe = Probe::new(&scene);
    let up = PLANET + EYE;
    // Below the horizontal.
    let horizon = (PLANET / up).acos();
    let mut tallies = tally(effort.rays, 200, |random, tallies| {
        let turn = std::f64::consts::TAU * random.random::<f64>();
        let away = 10_f64.powf(-12.0 * random.random::<f64>()) * if random.random() { 1.0 } else { -1.0 };
        let (sin, cos) = (horizon * (1.0 + away)).sin_cos();
        let d = DVec3::new(cos * turn.cos(), -sin, cos * turn.sin());
        // The subtraction of the eye is exact here.
        ask(tallies, probe.nearest(&Ray::new(probe.eye(), d)).map(|hit| hit.t), DVec3::Y * up, d, PLANET);
    });
    let [exact] = tally(effort.rays, 201, |random, [exact]: &mut [Tally; 1]| {
        let (sin, cos) = (horizon + 1e-6 + 0.5 * random.random::<f64>().powi(4)).sin_cos();
        let d = DVec3::new(cos, -sin, 0.0);
        let truth = Truth::new(DVec3::Y * up, d, PLANET).nearest();
        if let Some(t) = truth {
            let error = probe.nearest(&Ray::new(probe.eye(), d)).map(|hit| (hit.t - t).abs() / t);
            exact.error(error.unwrap_or(f64::NAN));
        }
    });
    tallies[0] = tallies[0].join(exact);
    let mut found = Found::default();
    found.add(None, &METHODS, &tallies);
    found
}

pub(super) fn tangent(effort: &Effort) -> Found {
    let scene = sphere_at_eye(1.0);
    let probe = Probe::new(&scene);
    let mut found = Found::default();
    for exponent in 0..4 {
        let distance = 10_f64.powi(exponent);
        let tallies = tally(effort.rays, 300 + exponent as u64, |random, tallies| {
            let d = direction(random);
            let across = direction(random).cross(d).normalize();
            let beside = 1.0 + if random.random() { 1e-12 } else { -1e-12 };
            let o = across * beside - d * distance;
            ask(tallies, probe.nearest(&Ray::new(o, d)).map(|hit| hit.t), o, d, 1.0);
        });
        found.add(Some(distance), &METHODS, &tallies);
    }
    found
}

/// The other methods subtract coordinates of the world that were rounded to single precision: that is their defect here.
pub(super) fn far_from_origin(effort: &Effort) -> Found {
    const METHODS: [&str; 4] = [LOOKAT, "naive f32", "Haines f32", "pbrt-v3"];
    let mut found = Found::default();
    for exponent in 0..9 {
        let far = if exponent == 0 { 0.0 } else { 10_f64.powi(exponent) };
        let center = DVec3::new(0.7 * far, -0.9 * far, 0.3 * far);
        let eye = center + DVec3::new(3.1, 3.9, 0.3);
        let scene = scene(&format!(
            r#"LookAt {} {} {}  {} {} {}  0 0 1 Camera "perspective" Integrator "path" Sampler "sobol" Film "image"
               WorldBegin LightSource "infinite" Translate {} {} {} Shape "sphere" WorldEnd"#,
            eye.x, eye.y, eye.z, center.x, center.y, center.z, center.x, center.y, center.z
        ));
        let probe = Probe::new(&scene);
        let o = eye - center;
        let tallies = tally(effort.rays, 700 + exponent as u64, |random, tallies: &mut [Tally; 4]| {
            let across = direction(random).cross(o).normalize();
            let d = (across * (1.2 * random.random::<f64>().sqrt()) - o).normalize();
            let Some(hits) = Truth::new(o, d, 1.0).hits else { return };
            tallies[0].answer(probe.nearest(&Ray::new(probe.eye(), d)).is_some() == hits);
            let rounded = (eye.as_vec3() - center.as_vec3()).to_array();
            let d = single(d);
            let answers =
                [by::naive(rounded, d, 1.0), by::haines(rounded, d, 1.0), by::pbrt_v3(rounded, d, 1.0)];
            tallies[1..].iter_mut().zip(answers).for_each(|(tally, t)| tally.answer(t.is_some() == hits));
        });
        found.add(Some(far.max(1.0)), &METHODS, &tallies);
    }
    found
}
