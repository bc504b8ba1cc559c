//! Rays against spheres: S1 to S9.

mod distance;
mod form;

use super::quadric::{CutShape, tangent};
use crate::stability::prelude::*;

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("S1", distance::far),
    ("S2", distance::ground),
    ("S3", |effort| tangent(effort, 300, &[CutShape::sphere(1.0)])),
    ("S4", form::inside_and_on),
    ("S5", form::nested),
    ("S6", form::sizes),
    ("S7", distance::far_from_origin),
    ("S8", form::ellipsoids),
    ("S9", |_| refused("S9")),
];

/// A sphere around the origin of the world, seen from there: rays of a probe then start anywhere around it.
fn sphere_at_eye(radius: f64) -> Scene {
    scene(&around_eye(&format!("Shape \"sphere\" \"float radius\" {radius:e}")))
}

/// A ray from a distance, aimed at a disk of 1.2 times the radius around the center of the unit sphere.
fn aimed(random: &mut Pcg64Mcg, distance: f64) -> (DVec3, DVec3) {
    let o = direction(random) * distance;
    let across = direction(random).cross(o).normalize();
    let target = across * (1.2 * random.random::<f64>().sqrt());
    (o, (target - o).normalize())
}

#[cfg(test)]
mod tests {
    use super::super::quadric::QuadricTruth;
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
