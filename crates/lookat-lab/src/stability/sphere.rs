//! Rays against spheres: S1 to S9.

mod distance;
mod form;

use glam::DVec3;
use lookat_scene::Scene;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use twofloat::TwoFloat;

use super::case::{Axis, Case, Family};
use super::random::direction;
use super::truth::{Wide, quotient};
use crate::text_scene::scene;

const DISTANCE: Axis = Axis::Of("distance / radius");
const RADIUS: Axis = Axis::Of("radius");
const EYE: Axis = Axis::Of("distance from the origin / radius");

#[rustfmt::skip]
pub(super) fn cases() -> Vec<Case> {
    let case = |id, name, claim, axis, error, limit, run| {
        Case { id, name, family: Family::Sphere, claim, axis, error, limit, run }
    };
    vec![
        case("S1", "far-sphere", "rays aimed at and beside a sphere hit or miss correctly, at any distance",
            DISTANCE, "fraction of distances with an error above 2 ulp, from 10 radii on", 0.01, distance::far),
        case("S2", "sphere-as-ground", "rays near the horizon of a planet, seen from eye height, hit or miss correctly",
            Axis::None, "relative error of the distance, 1e-6 rad and more below the horizon", 1e-7, distance::ground),
        case("S3", "tangent-rays", "rays that pass a sphere at 1 +- 1e-12 radii miss and hit it",
            DISTANCE, "", 0.0, distance::tangent),
        case("S4", "inside-and-on", "a ray from inside or from the surface hits a sphere the right number of times",
            RADIUS, "", 0.0, form::inside_and_on),
        case("S5", "nested-spheres", "a ray hits a sphere that lies closely inside another",
            Axis::Of("gap / radius"), "", 0.0, form::nested),
        case("S6", "sizes", "spheres of any size are hit, with a finite normal",
            RADIUS, "error of the distance, in radii", 1e-14, form::sizes),
        case("S7", "far-from-the-origin", "a sphere and an eye far from the origin give the same picture as at the origin",
            EYE, "", 0.0, distance::far_from_origin),
        case("S8", "ellipsoids", "rays hit or miss scaled, sheared and mirrored spheres correctly, with the right normals",
            Axis::None, "error of the normal, in rad", 1e-8, form::ellipsoids),
        case("S9", "no-spheres", "an invalid radius is an error that names its line",
            Axis::None, "", 0.0, form::no_spheres),
    ]
}

/// A sphere around the origin of the world, seen from there: rays of a probe then start anywhere around it.
fn sphere_at_eye(radius: f64) -> Scene {
    scene(&format!(
        r#"Camera "perspective" Integrator "path" Sampler "sobol" Film "image"
           WorldBegin LightSource "infinite" Shape "sphere" "float radius" [{radius:e}] WorldEnd"#
    ))
}

/// A ray from a distance, aimed at a disk of 1.2 times the radius around the center of the unit sphere.
fn aimed(random: &mut Pcg64Mcg, distance: f64) -> (DVec3, DVec3) {
    let o = direction(random) * distance;
    let across = direction(random).cross(o).normalize();
    let target = across * (1.2 * random.random::<f64>().sqrt());
    (o, (target - o).normalize())
}

/// What a line has to do with a sphere around the origin, exactly enough.
struct Truth {
    /// Whether it meets the sphere; `None` where that is too close to tell.
    hits: Option<bool>,
    /// The distances along the ray, in lengths of its direction, if it does.
    roots: [f64; 2],
}

impl Truth {
    fn new(o: DVec3, d: DVec3, radius: f64) -> Truth {
        Truth::wide(Wide::new(o), Wide::new(d), radius)
    }

    fn wide(o: Wide, d: Wide, radius: f64) -> Truth {
        let (moment, dd) = (o.cross(d), d.dot(d));
        // Of double-double numbers, the terms of the cross product may cancel.
        let doubt = 1e-30 * f64::from(o.dot(o)) * f64::from(dd);
        let margin = TwoFloat::new_mul(radius, radius) * dd - moment.dot(moment);
        let hits = (margin.abs() > TwoFloat::from(doubt)).then(|| margin > TwoFloat::from(0.0));
        let (middle, half) = (quotient(-o.dot(d), dd), quotient(margin.max(TwoFloat::from(0.0)).sqrt(), dd));
        Truth { hits, roots: [middle - half, middle + half].map(f64::from) }
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
    use crate::stability::methods::sphere as by;

    #[test]
    fn all_methods_agree_where_it_is_easy() {
        let (o, d) = (DVec3::new(1.0, 2.0, -4.0), DVec3::new(-0.25, -0.375, 1.0));
        let truth = Truth::new(o, d, 1.5).nearest().unwrap();
        let (a, b) = (o.as_vec3().to_array(), d.as_vec3().to_array());
        let single = [
            by::naive(a, b, 1.5),
            by::stable(a, b, 1.5),
            by::haines(a, b, 1.5),
            by::pbrt_v3(a, b, 1.5),
            by::pbrt_v4(a, b, 1.5),
        ];
        assert!(single.iter().all(|t| (f64::from(t.unwrap()) - truth).abs() < 1e-5), "{single:?} {truth}");
        let (a, b) = (o.to_array(), d.to_array());
        let double = [by::naive(a, b, 1.5), by::stable(a, b, 1.5), by::haines(a, b, 1.5)];
        assert!(double.iter().all(|t| (t.unwrap() - truth).abs() < 1e-14), "{double:?} {truth}");
        // From the quadratic equation, by hand: 1.203125 t^2 - 10 t + 18.75 = 0.
        assert!((truth - (10.0 - 9.765625_f64.sqrt()) / 2.40625).abs() < 1e-14, "{truth}");
        assert_eq!(Truth::new(o, DVec3::X, 1.5).hits, Some(false));
    }
}
