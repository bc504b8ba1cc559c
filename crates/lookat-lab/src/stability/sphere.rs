//! Rays against spheres: S1 to S9.

mod distance;
mod form;

use twofloat::TwoFloat;

use super::truth::{Wide, quotient};
use crate::stability::prelude::*;

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("S1", distance::far),
    ("S2", distance::ground),
    ("S3", distance::tangent),
    ("S4", form::inside_and_on),
    ("S5", form::nested),
    ("S6", form::sizes),
    ("S7", distance::far_from_origin),
    ("S8", form::ellipsoids),
    ("S9", form::no_spheres),
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

/// What a line has to do with a sphere around the origin, exactly enough.
struct SphereTruth {
    /// Whether it meets the sphere; `None` where that is too close to tell.
    hits: Option<bool>,
    /// The distances along the ray, in lengths of its direction, if it does.
    roots: [f64; 2],
}

impl SphereTruth {
    fn new(o: DVec3, d: DVec3, radius: f64) -> SphereTruth {
        SphereTruth::wide(Wide::new(o), Wide::new(d), radius)
    }

    fn wide(o: Wide, d: Wide, radius: f64) -> SphereTruth {
        let (moment, dd) = (o.cross(d), d.dot(d));
        // Of double-double numbers, the terms of the cross product may cancel.
        let doubt = 1e-30 * f64::from(o.dot(o)) * f64::from(dd);
        let margin = TwoFloat::new_mul(radius, radius) * dd - moment.dot(moment);
        let hits = (margin.abs() > TwoFloat::from(doubt)).then(|| margin > TwoFloat::from(0.0));
        let (middle, half) = (quotient(-o.dot(d), dd), quotient(margin.max(TwoFloat::from(0.0)).sqrt(), dd));
        SphereTruth { hits, roots: [middle - half, middle + half].map(f64::from) }
    }

    /// The nearest distance of a hit that is not behind.
    fn nearest(&self) -> Option<f64> {
        let hits = self.hits == Some(true);
        self.roots.into_iter().find(|t| hits && *t > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_truth_is_that_of_the_quadratic_equation() {
        let (o, d) = (DVec3::new(1.0, 2.0, -4.0), DVec3::new(-0.25, -0.375, 1.0));
        let truth = SphereTruth::new(o, d, 1.5).nearest().unwrap();
        // By hand: 1.203125 t^2 - 10 t + 18.75 = 0.
        assert!((truth - (10.0 - 9.765625_f64.sqrt()) / 2.40625).abs() < 1e-14, "{truth}");
        assert_eq!(SphereTruth::new(o, DVec3::X, 1.5).hits, Some(false));
    }
}
