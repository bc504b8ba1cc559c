//! Spheres that are far away or large.

use super::{aimed, sphere_at_eye};
use crate::stability::prelude::*;
use crate::stability::quadric::{CutShape, QuadricTruth, ask};

pub(super) fn far(effort: &Effort) -> Found {
    let scene = sphere_at_eye(1.0);
    let probe = Probe::new(&scene);
    let sphere = CutShape::sphere(1.0);
    Found::sweep(100, std::iter::once(1.5).chain(decades(1..10)), |seed, distance| {
        let mut tally = tally(effort.rays, seed, |random, tally| {
            let (o, d) = aimed(random, distance);
            ask(tally, &sphere, probe.nearest(&Ray::new(o, d)).is_some(), o, d);
        });
        // Nearer, the distance is short against the coordinates that it comes from.
        if distance >= 10.0 {
            tally.worst = Some(share_off(&probe, &sphere, effort, distance));
        }
        tally
    })
}

/// The share of hits whose distance is off by more than 2 units in the last place.
fn share_off(probe: &Probe, sphere: &CutShape, effort: &Effort, distance: f64) -> f64 {
    let off = tally(effort.rays.min(100_000), 150, |random, off| {
        let (o, d) = aimed(random, distance);
        if let (Some(hit), Some(t)) =
            (probe.nearest(&Ray::new(o, d)), QuadricTruth::new(sphere, o, d).nearest)
        {
            off.answer((hit.t - t).abs() <= 2.0 * (t.next_up() - t));
        }
    });
    off.failed as f64 / off.tried as f64
}

/// The radius of a planet and the height of the eye above it, in meters.
const PLANET: f64 = 6.4e6;
const EYE: f64 = 1.7;

pub(super) fn ground(effort: &Effort) -> Found {
    let world = format!("Translate 0 {} 0 Shape \"sphere\" \"float radius\" {PLANET}", -PLANET);
    let scene = scene(&seen_from(EYE * DVec3::Y, &world));
    let probe = Probe::new(&scene);
    let (sphere, up) = (CutShape::sphere(PLANET), PLANET + EYE);
    // Below the horizontal.
    let horizon = (PLANET / up).acos();
    let hits = tally(effort.rays, 200, |random, tally| {
        let turn = std::f64::consts::TAU * random.random::<f64>();
        let away = 10_f64.powf(-12.0 * random.random::<f64>()) * if random.random() { 1.0 } else { -1.0 };
        let (sin, cos) = (horizon * (1.0 + away)).sin_cos();
        let d = DVec3::new(cos * turn.cos(), -sin, cos * turn.sin());
        // The subtraction of the eye is exact here.
        ask(tally, &sphere, probe.nearest(&Ray::new(probe.eye(), d)).is_some(), DVec3::Y * up, d);
    });
    let exact = tally(effort.rays, 201, |random, exact| {
        let (sin, cos) = (horizon + 1e-6 + 0.5 * random.random::<f64>().powi(4)).sin_cos();
        let d = DVec3::new(cos, -sin, 0.0);
        if let Some(t) = QuadricTruth::new(&sphere, DVec3::Y * up, d).nearest {
            let error = probe.nearest(&Ray::new(probe.eye(), d)).map(|hit| (hit.t - t).abs() / t);
            exact.error(error.unwrap_or(f64::NAN));
        }
    });
    Found::own(None, hits.join(exact))
}

pub(super) fn far_from_origin(effort: &Effort) -> Found {
    Found::sweep(700, decades(0..9), |seed, distance| {
        let far = if distance == 1.0 { 0.0 } else { distance };
        let center = DVec3::new(0.7 * far, -0.9 * far, 0.3 * far);
        let eye = center + DVec3::new(3.1, 3.9, 0.3);
        let world = format!("Translate {} Shape \"sphere\"", xyz(center));
        let scene = scene(&seen_from(eye, &world));
        let probe = Probe::new(&scene);
        let (sphere, o) = (CutShape::sphere(1.0), eye - center);
        tally(effort.rays, seed, |random, tally| {
            let across = direction(random).cross(o).normalize();
            let d = (across * (1.2 * random.random::<f64>().sqrt()) - o).normalize();
            ask(tally, &sphere, probe.nearest(&Ray::new(probe.eye(), d)).is_some(), o, d);
        })
    })
}
