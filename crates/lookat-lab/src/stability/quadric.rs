//! Rays against spheres and other quadrics: S1 to S12.

use lookat_render::Hit;

use super::double_double::Wide;
use super::quadric_truth::{CutShape, QuadricTruth, SHAPES, beyond};
use super::*;
use crate::text_scene::{at, sphere};

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("S1", far_sphere),
    ("S2", ground),
    ("S3", |trial| tangent(trial, &[CutShape::sphere(1.0)])),
    ("S4", inside_and_on),
    ("S5", nested),
    ("S6", sizes),
    ("S7", far_from_origin),
    ("S8", |trial| (trial.seed..).zip(&FORMS).map(|form| ellipsoid(form, trial.rays)).collect()),
    ("S10", far_quadric),
    ("S11", |trial| tangent(trial, &SHAPES)),
    ("S12", leaving_quadric),
];

/// Whether a ray hits, compared with the truth.
fn ask(tally: &mut Tally, shape: &CutShape, hits: bool, o: DVec3, d: DVec3) {
    if let Some(truth) = QuadricTruth::new(shape, o, d).hits {
        tally.answer(hits == truth);
    }
}

/// A sphere around the eye, so that rays may start anywhere around it.
fn sphere_at_eye(radius: f64) -> PreparedScene {
    prepared(&around_eye(&sphere(radius)))
}

/// A direction from `o` toward a disk of 1.2 times the radius around the center of the unit sphere.
fn toward_sphere(random: &mut Pcg64Mcg, o: DVec3) -> DVec3 {
    let across = direction(random).cross(o).normalize();
    (across * (1.2 * random.random::<f64>().sqrt()) - o).normalize()
}

/// A ray toward the unit sphere from this distance.
fn aimed(random: &mut Pcg64Mcg, distance: f64) -> Ray {
    let o = direction(random) * distance;
    Ray::new(o, toward_sphere(random, o))
}

fn far_sphere(trial: &Trial) -> Tally {
    let (prepared, sphere) = (sphere_at_eye(1.0), CutShape::sphere(1.0));
    let mut all = tally(trial.rays, trial.seed, |random, tally| {
        let ray = aimed(random, trial.at);
        ask(tally, &sphere, prepared.world.nearest(&ray).is_some(), ray.o, ray.d);
    });
    // Nearer, the distance is short compared with the coordinates.
    if trial.at >= 10.0 {
        let inexact = tally(trial.rays.min(100_000), 150, |random, inexact| {
            let ray = aimed(random, trial.at);
            let truth = QuadricTruth::new(&sphere, ray.o, ray.d);
            if let (Some(hit), Some(t)) = (prepared.world.nearest(&ray), truth.nearest) {
                inexact.answer((hit.t - t).abs() <= 2.0 * (t.next_up() - t));
            }
        });
        all.worsen(inexact.failed as f64 / inexact.tried as f64);
    }
    all
}

fn ground(trial: &Trial) -> Tally {
    /// The radius of a planet and the height of the eye above it, in meters.
    const PLANET: f64 = 6.4e6;
    const EYE: f64 = 1.7;
    let prepared = prepared(&seen_from(EYE * DVec3::Y, &at(DVec3::NEG_Y * PLANET, &sphere(PLANET))));
    let (sphere, up) = (CutShape::sphere(PLANET), PLANET + EYE);
    // Below the horizontal.
    let horizon = (PLANET / up).acos();
    let hits = tally(trial.rays, trial.seed, |random, tally| {
        let turn = std::f64::consts::TAU * random.random::<f64>();
        let away = 10_f64.powf(-12.0 * random.random::<f64>()) * if random.random() { 1.0 } else { -1.0 };
        let (sin, cos) = (horizon * (1.0 + away)).sin_cos();
        let d = DVec3::new(cos * turn.cos(), -sin, cos * turn.sin());
        // The subtraction of the eye is exact here.
        ask(
            tally,
            &sphere,
            prepared.world.nearest(&Ray::new(prepared.camera.eye, d)).is_some(),
            DVec3::Y * up,
            d,
        );
    });
    let exact = tally(trial.rays, trial.seed + 1, |random, exact| {
        let (sin, cos) = (horizon + 1e-6 + 0.5 * random.random::<f64>().powi(4)).sin_cos();
        let d = DVec3::new(cos, -sin, 0.0);
        if let Some(t) = QuadricTruth::new(&sphere, DVec3::Y * up, d).nearest {
            let error =
                prepared.world.nearest(&Ray::new(prepared.camera.eye, d)).map(|hit| (hit.t - t).abs() / t);
            exact.error(error.unwrap_or(f64::NAN));
        }
    });
    hits.join(exact)
}

fn far_from_origin(trial: &Trial) -> Tally {
    let far = if trial.at == 1.0 { 0.0 } else { trial.at };
    let center = DVec3::new(0.7 * far, -0.9 * far, 0.3 * far);
    let eye = center + DVec3::new(3.1, 3.9, 0.3);
    let prepared = prepared(&seen_from(eye, &format!("Translate {} Shape \"sphere\"", xyz(center))));
    let (sphere, o) = (CutShape::sphere(1.0), eye - center);
    tally(trial.rays, trial.seed, |random, tally| {
        let d = toward_sphere(random, o);
        ask(tally, &sphere, prepared.world.nearest(&Ray::new(prepared.camera.eye, d)).is_some(), o, d);
    })
}

fn inside_and_on(trial: &Trial) -> Tally {
    let radius = trial.at;
    let prepared = sphere_at_eye(radius);
    tally(trial.rays, trial.seed, |random, tally| {
        let inside = Ray::new(direction(random) * (0.9 * radius), direction(random));
        let Some(hit) = prepared.world.nearest(&inside) else { return tally.answer(false) };
        let outward = prepared.world.surface(&inside, &hit).p.normalize();
        let away = direction(random);
        let leaving = prepared.world.surface(&inside, &hit).spawn_ray(away);
        let cos = -away.dot(outward);
        let Some(far) = prepared.world.nearest(&leaving) else { return tally.answer(cos <= 1e-15) };
        // A chord, and then out. Along the surface, the offset of the origin decides more than the direction.
        let is_chord = (far.t - 2.0 * radius * cos).abs() * cos.abs() < 1e-11 * radius;
        let out = prepared.world.surface(&leaving, &far).spawn_ray(away);
        tally.answer(is_chord && prepared.world.nearest(&out).is_none());
    })
}

/// The ray goes straight on through the outer sphere.
fn nested(trial: &Trial) -> Tally {
    let radius = 1.0 - trial.at;
    let (prepared, inner) =
        (prepared(&around_eye(&(sphere(1.0) + &sphere(radius)))), CutShape::sphere(radius));
    tally(trial.rays, trial.seed, |random, tally| {
        let ray = aimed(random, 5.0);
        if QuadricTruth::new(&inner, ray.o, ray.d).hits != Some(true) {
            return;
        }
        let outer = prepared.world.nearest(&ray);
        let inner = outer
            .and_then(|hit| prepared.world.nearest(&prepared.world.surface(&ray, &hit).spawn_ray(ray.d)));
        let is = |hit: Option<Hit>, primitive| hit.is_some_and(|hit| hit.element.primitive == primitive);
        tally.answer(is(outer, 0) && is(inner, 1));
    })
}

fn sizes(trial: &Trial) -> Tally {
    let radius = trial.at;
    let prepared = sphere_at_eye(radius);
    tally(trial.rays, trial.seed, |random, tally| {
        // Toward the center, from 3 radii.
        let d = direction(random);
        let ray = Ray::new(d * (-3.0 * radius), d);
        match prepared.world.nearest(&ray) {
            Some(hit) if (prepared.world.surface(&ray, &hit).n.length() - 1.0).abs() < 1e-12 => {
                tally.error((hit.t / radius - 2.0).abs());
            }
            _ => tally.answer(false),
        }
    })
}

/// The columns of transformations whose inverses have no rounding errors.
const FORMS: [(&str, [f64; 9]); 4] = [
    ("flat", [1.0, 0.0, 0.0, 0.0, 1e-6, 0.0, 0.0, 0.0, 1.0]),
    ("mirrored", [-2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5]),
    ("sheared", [1.0, 0.0, 0.0, 0.75, 1.0, 0.0, -0.5, 0.25, 1.0]),
    ("long", [1024.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]),
];

fn ellipsoid((seed, (name, columns)): (u64, &(&str, [f64; 9])), rays: u64) -> Tally {
    let sphere = CutShape::sphere(1.0);
    let m = DMat3::from_cols_array(columns);
    let inverse = m.inverse();
    let prepared = prepared(&around_eye(&format!("{} Shape \"sphere\"", transform(&DMat4::from_mat3(m)))));
    let mut tally = tally(rays, seed, |random, tally| {
        let ray = aimed(random, 5.0);
        let ray = Ray::new(m * ray.o, (m * ray.d).normalize());
        let on_unit = [ray.o, ray.d].map(|v| product(&inverse, v));
        let truth = QuadricTruth::wide(&sphere, on_unit[0], on_unit[1]);
        let Some(hits) = truth.hits else { return };
        let hit = prepared.world.nearest(&ray);
        tally.answer(hit.is_some() == hits);
        let (Some(hit), Some(t)) = (hit, truth.nearest) else { return };
        let p = DVec3::from_array([0, 1, 2].map(|i| f64::from(on_unit[0].0[i] + on_unit[1].0[i] * t)));
        let chord = -2.0 * p.dot(inverse * ray.d) / (inverse * ray.d).length_squared();
        // Near the silhouette, the hit point depends on the last digits of the ray.
        if chord > 1e-2 * (t + chord) {
            let n = (inverse.transpose() * p).normalize();
            tally.worsen(prepared.world.surface(&ray, &hit).n.cross(n).length());
        }
    });
    if tally.failed > 0 {
        tally.remarks.push(format!("{name}: {} of {} rays", tally.failed, tally.tried));
    }
    tally
}

fn product(m: &DMat3, v: DVec3) -> Wide {
    let rows = m.transpose();
    let [x, y, z] = [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| Wide::new(row).dot(Wide::new(v)));
    Wide([x, y, z])
}

/// The same number of rays for each shape.
fn at_each(
    trial: &Trial,
    shapes: &[CutShape],
    size: f64,
    attempt: impl Fn(&PreparedScene, &CutShape, &mut Pcg64Mcg, &mut Tally) + Sync,
) -> Tally {
    let of = |(seed, shape): (u64, &CutShape)| {
        let prepared = shape.prepared(size);
        tally(trial.rays.div_ceil(shapes.len() as u64), seed, |random, tally| {
            attempt(&prepared, shape, random, tally)
        })
    };
    (trial.seed..).step_by(100).zip(shapes).map(of).collect()
}

fn far_quadric(trial: &Trial) -> Tally {
    let distance = trial.at;
    at_each(trial, &SHAPES, 1.0, |prepared, shape, random, tally| {
        let o = direction(random) * distance;
        let ray = Ray::new(o, (in_cube(random) * 1.2 - o).normalize());
        let hit = prepared.world.nearest(&ray);
        ask(tally, shape, hit.is_some(), o, ray.d);
        if let (true, Some(hit), Some(t)) =
            (distance <= 100.0, hit, QuadricTruth::new(shape, o, ray.d).nearest)
        {
            // For a grazing ray, the distance depends on the last digits of the ray.
            let p = prepared.world.surface(&ray, &hit);
            let cos = p.n.dot(ray.d).abs();
            tally.error((hit.t - t).abs() / distance * cos + p.p.distance(ray.at(t)) / distance * cos);
        }
    })
}

/// Rays that pass a shape, and rays that do not, by a trillionth of its size.
fn tangent(trial: &Trial, shapes: &[CutShape]) -> Tally {
    at_each(trial, shapes, 1.0, |prepared, shape, random, tally| {
        let (p, n) = shape.point(random);
        let d = if shape.is_disk() { direction(random) } else { direction(random).cross(n).normalize() };
        let beside = if chance(random, 0.5) { 1e-12 } else { -1e-12 };
        let o = p + n * beside - d * trial.at;
        ask(tally, shape, prepared.world.nearest(&Ray::new(o, d)).is_some(), o, d);
    })
}

fn leaving_quadric(trial: &Trial) -> Tally {
    let size = trial.at;
    at_each(trial, &SHAPES, size, |prepared, shape, random, tally| {
        let o = direction(random) * 3.0;
        let ray = Ray::new(o * size, (shape.point(random).0 - o).normalize());
        let Some(hit) = prepared.world.nearest(&ray) else { return };
        let point = prepared.world.surface(&ray, &hit);
        let d = direction(random);
        let found = prepared.world.nearest(&prepared.world.surface(&ray, &hit).spawn_ray(d));
        let Some(expected) = beyond(shape, point.p / size, d, point.n.dot(d)) else { return };
        tally.answer(found.is_some() == expected.is_some());
        if let (Some(hit), Some(t)) = (found, expected) {
            tally.error((hit.t / size - t).abs() * point.n.dot(d).abs());
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_truth_solves_the_quadratic_equation() {
        let (o, d) = (DVec3::new(1.0, 2.0, -4.0), DVec3::new(-0.25, -0.375, 1.0));
        let truth = |d| QuadricTruth::new(&CutShape::sphere(1.5), o, d);
        let nearest = truth(d).nearest.unwrap();
        // By hand: 1.203125 t^2 - 10 t + 18.75 = 0.
        assert!((nearest - (10.0 - 9.765625_f64.sqrt()) / 2.40625).abs() < 1e-14, "{nearest}");
        assert_eq!(truth(DVec3::X).hits, Some(false));
    }

    #[test]
    fn inverses_are_exact() {
        let inverses = [
            [1.0, 0.0, 0.0, 0.0, 1e6, 0.0, 0.0, 0.0, 1.0],
            [-0.5, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0],
            [1.0, 0.0, 0.0, -0.75, 1.0, 0.0, 0.6875, -0.25, 1.0],
            [0.0009765625, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        ];
        for ((name, columns), inverse) in FORMS.into_iter().zip(inverses) {
            let found = DMat3::from_cols_array(&columns).inverse();
            assert_eq!(found, DMat3::from_cols_array(&inverse), "{name}");
        }
    }
}
