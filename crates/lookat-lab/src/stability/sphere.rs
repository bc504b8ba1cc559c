//! Rays against spheres: S1 to S9.

mod form;

use super::quadric::{CutShape, QuadricTruth, ask, tangent};
use crate::stability::prelude::*;

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("S1", far),
    ("S2", ground),
    ("S3", |effort| tangent(effort, 300, &[CutShape::sphere(1.0)])),
    ("S4", form::inside_and_on),
    ("S5", form::nested),
    ("S6", form::sizes),
    ("S7", far_from_origin),
    ("S8", form::ellipsoids),
    ("S9", |_| refused("S9")),
];

/// A sphere around the origin of the world, seen from there: rays of a probe then start anywhere around it.
fn sphere_at_eye(radius: f64) -> Probe {
    probe(&around_eye(&format!("Shape \"sphere\" \"float radius\" {radius:e}")))
}

/// A ray from a distance, aimed at a disk of 1.2 times the radius around the center of the unit sphere.
fn aimed(random: &mut Pcg64Mcg, distance: f64) -> (DVec3, DVec3) {
    let o = direction(random) * distance;
    let across = direction(random).cross(o).normalize();
    let target = across * (1.2 * random.random::<f64>().sqrt());
    (o, (target - o).normalize())
}

fn far(effort: &Effort) -> Found {
    let probe = sphere_at_eye(1.0);
    let sphere = CutShape::sphere(1.0);
    Found::sweep(100, std::iter::once(1.5).chain(decades(1..10)), |seed, distance| {
        let mut all = tally(effort.rays, seed, |random, tally| {
            let (o, d) = aimed(random, distance);
            ask(tally, &sphere, probe.nearest(&Ray::new(o, d)).is_some(), o, d);
        });
        // Nearer, the distance is short against the coordinates that it comes from.
        if distance >= 10.0 {
            // Off by more than 2 units in the last place.
            let off = tally(effort.rays.min(100_000), 150, |random, off| {
                let (o, d) = aimed(random, distance);
                let (hit, truth) = (probe.nearest(&Ray::new(o, d)), QuadricTruth::new(&sphere, o, d));
                if let (Some(hit), Some(t)) = (hit, truth.nearest) {
                    off.answer((hit.t - t).abs() <= 2.0 * (t.next_up() - t));
                }
            });
            all.worst = Some(off.failed as f64 / off.tried as f64);
        }
        all
    })
}

/// The radius of a planet and the height of the eye above it, in meters.
const PLANET: f64 = 6.4e6;
const EYE: f64 = 1.7;

fn ground(effort: &Effort) -> Found {
    let world = format!("Translate 0 {} 0 Shape \"sphere\" \"float radius\" {PLANET}", -PLANET);
    let probe = probe(&seen_from(EYE * DVec3::Y, &world));
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

fn far_from_origin(effort: &Effort) -> Found {
    Found::sweep(700, decades(0..9), |seed, distance| {
        let far = if distance == 1.0 { 0.0 } else { distance };
        let center = DVec3::new(0.7 * far, -0.9 * far, 0.3 * far);
        let eye = center + DVec3::new(3.1, 3.9, 0.3);
        let world = format!("Translate {} Shape \"sphere\"", xyz(center));
        let probe = probe(&seen_from(eye, &world));
        let (sphere, o) = (CutShape::sphere(1.0), eye - center);
        tally(effort.rays, seed, |random, tally| {
            let across = direction(random).cross(o).normalize();
            let d = (across * (1.2 * random.random::<f64>().sqrt()) - o).normalize();
            ask(tally, &sphere, probe.nearest(&Ray::new(probe.eye(), d)).is_some(), o, d);
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_truth_is_that_of_the_quadratic_equation() {
        let (o, d) = (DVec3::new(1.0, 2.0, -4.0), DVec3::new(-0.25, -0.375, 1.0));
        let truth = |d| QuadricTruth::new(&CutShape::sphere(1.5), o, d);
        let nearest = truth(d).nearest.unwrap();
        // By hand: 1.203125 t^2 - 10 t + 18.75 = 0.
        assert!((nearest - (10.0 - 9.765625_f64.sqrt()) / 2.40625).abs() < 1e-14, "{nearest}");
        assert_eq!(truth(DVec3::X).hits, Some(false));
    }
}
