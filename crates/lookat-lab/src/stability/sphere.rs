//! Rays against spheres: S1 to S9.

use glam::DVec3;
use lookat_render::{Probe, Ray};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use twofloat::TwoFloat;

use super::case::{Axis, Case, Effort, Family, Found, LOOKAT};
use super::methods::{double, single, sphere as by};
use super::scenes::scene;
use super::tally::{Tally, tally};
use super::truth::Wide;

pub(super) fn cases() -> Vec<Case> {
    let case = |id, name, claim, axis, error, limit, run| Case {
        id,
        name,
        family: Family::Sphere,
        claim,
        axis,
        error,
        limit,
        run,
    };
    vec![case(
        "S1",
        "far-sphere",
        "rays aimed at and beside a sphere hit it or not as they should, at any distance",
        Axis::Of("distance / radius"),
        "",
        0.0,
        far_sphere,
    )]
}

const METHODS: [&str; 10] = [
    LOOKAT,
    "naive f32",
    "naive f64",
    "stable quadratic f32",
    "stable quadratic f64",
    "pbrt-v3",
    "pbrt-v4",
    "Haines f32",
    "Haines f64",
    "closest approach f32",
];

fn far_sphere(effort: &Effort) -> Found {
    // The eye is in the centre, so that rays start anywhere around it.
    let scene = scene(
        r#"Camera "perspective" Integrator "path" Sampler "sobol" Film "image"
           WorldBegin LightSource "infinite" Shape "sphere" WorldEnd"#,
    );
    let probe = Probe::new(&scene);
    let mut found = Found::default();
    for exponent in 0..10 {
        let distance = if exponent == 0 { 1.5 } else { 10_f64.powi(exponent) };
        let tallies = tally(effort.rays, 100 + exponent as u64, |random, tallies: &mut [Tally; 10]| {
            let (o, d) = aimed(random, distance);
            let mut count = |method: usize, truth: Option<bool>, answer: bool| {
                // A ray that touches the sphere within 1e-30 may go either way.
                if let Some(truth) = truth {
                    tallies[method].answer(answer == truth);
                }
            };
            let truth = hits(o, d);
            count(0, truth, probe.nearest(&Ray::new(o, d)).is_some());
            let (a, b) = (o.to_array(), d.to_array());
            count(2, truth, by::naive(a, b, 1.0).is_some());
            count(4, truth, by::stable(a, b, 1.0).is_some());
            count(8, truth, by::haines(a, b, 1.0).is_some());
            // The truth for the ray that single precision holds.
            let (a, b) = (single(o), single(d));
            let truth = hits(double(a), double(b));
            count(1, truth, by::naive(a, b, 1.0).is_some());
            count(3, truth, by::stable(a, b, 1.0).is_some());
            count(5, truth, by::pbrt_v3(a, b, 1.0).is_some());
            count(6, truth, by::pbrt_v4(a, b, 1.0).is_some());
            count(7, truth, by::haines(a, b, 1.0).is_some());
        });
        found.add(Some(distance), &METHODS[..9], &tallies);
    }
    found
}

/// A ray from a distance, aimed at a disk of 1.2 times the radius around the centre.
fn aimed(random: &mut Pcg64Mcg, distance: f64) -> (DVec3, DVec3) {
    let o = direction(random) * distance;
    let across = direction(random).cross(o).normalize();
    let target = across * (1.2 * random.random::<f64>().sqrt());
    (o, (target - o).normalize())
}

fn direction(random: &mut Pcg64Mcg) -> DVec3 {
    let z = 2.0 * random.random::<f64>() - 1.0;
    let (sin, cos) = (std::f64::consts::TAU * random.random::<f64>()).sin_cos();
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * cos, r * sin, z)
}

/// Whether the line through `o` meets the unit sphere; `None` where that is too close to tell.
fn hits(o: DVec3, d: DVec3) -> Option<bool> {
    let (o, d) = (Wide::new(o), Wide::new(d));
    let (moment, dd) = (o.cross(d), d.dot(d));
    let margin = dd - moment.dot(moment);
    let doubt = 1e-28 * f64::from(moment.dot(moment));
    if margin.abs() <= TwoFloat::from(doubt) { None } else { Some(margin > TwoFloat::from(0.0)) }
}
