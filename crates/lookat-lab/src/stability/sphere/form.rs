//! Spheres from inside, nested, of all sizes, and no longer spheres.

use lookat_render::Hit;

use super::{aimed, sphere_at_eye};
use crate::stability::prelude::*;
use crate::stability::quadric::{CutShape, QuadricTruth};
use crate::stability::truth::Wide;

const SIZES: [f64; 7] = [1e-30, 1e-12, 1e-3, 1.0, 1e3, 1e12, 1e30];

pub(super) fn inside_and_on(effort: &Effort) -> Found {
    Found::sweep(400, SIZES, |seed, radius| {
        let probe = sphere_at_eye(radius);
        tally(effort.rays, seed, |random, tally| {
            let inside = Ray::new(direction(random) * (0.9 * radius), direction(random));
            let Some(hit) = probe.nearest(&inside) else { return tally.answer(false) };
            let outward = probe.point(&inside, &hit).p.normalize();
            let away = direction(random);
            let leaving = probe.leave(&inside, &hit, away);
            let cos = -away.dot(outward);
            let Some(far) = probe.nearest(&leaving) else { return tally.answer(cos <= 1e-15) };
            // A chord, and then out. Along the surface, where the ray starts has more to say than its direction.
            let is_chord = (far.t - 2.0 * radius * cos).abs() * cos.abs() < 1e-11 * radius;
            let out = probe.leave(&leaving, &far, away);
            tally.answer(is_chord && probe.nearest(&out).is_none());
        })
    })
}

/// After the first hit, a ray goes on from there.
pub(super) fn nested(effort: &Effort) -> Found {
    Found::sweep(500, [1e-2, 4e-5, 1e-7, 1e-9], |seed, gap| {
        let inner = format!("Shape \"sphere\" \"float radius\" {}", 1.0 - gap);
        let (probe, sphere) =
            (probe(&around_eye(&format!("Shape \"sphere\" {inner}"))), CutShape::sphere(1.0 - gap));
        tally(effort.rays, seed, |random, tally| {
            let (o, d) = aimed(random, 5.0);
            if QuadricTruth::new(&sphere, o, d).hits != Some(true) {
                return;
            }
            let ray = Ray::new(o, d);
            let outer = probe.nearest(&ray);
            let inner = outer.and_then(|hit| probe.nearest(&probe.leave(&ray, &hit, d)));
            let is = |hit: Option<Hit>, primitive| hit.is_some_and(|hit| hit.element.primitive == primitive);
            tally.answer(is(outer, 0) && is(inner, 1));
        })
    })
}

pub(super) fn sizes(effort: &Effort) -> Found {
    Found::sweep(600, SIZES, |seed, radius| {
        let probe = sphere_at_eye(radius);
        tally(effort.rays, seed, |random, tally| {
            // Towards the center, from 3 radii.
            let d = direction(random);
            let ray = Ray::new(d * (-3.0 * radius), d);
            match probe.nearest(&ray) {
                Some(hit) if (probe.point(&ray, &hit).n.length() - 1.0).abs() < 1e-12 => {
                    tally.error((hit.t / radius - 2.0).abs());
                }
                _ => tally.answer(false),
            }
        })
    })
}

/// The columns of transformations whose inverses are computed without rounding.
const FORMS: [(&str, [f64; 9]); 4] = [
    ("flat", [1.0, 0.0, 0.0, 0.0, 1e-6, 0.0, 0.0, 0.0, 1.0]),
    ("mirrored", [-2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5]),
    ("sheared", [1.0, 0.0, 0.0, 0.75, 1.0, 0.0, -0.5, 0.25, 1.0]),
    ("long", [1024.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]),
];

pub(super) fn ellipsoids(effort: &Effort) -> Found {
    let mut remarks = Vec::new();
    let (mut all, sphere) = (Tally::default(), CutShape::sphere(1.0));
    for (index, (name, columns)) in FORMS.iter().enumerate() {
        let m = DMat3::from_cols_array(columns);
        let inverse = m.inverse();
        let text = format!("{} Shape \"sphere\"", transform(&DMat4::from_mat3(m)));
        let probe = probe(&around_eye(&text));
        let tally = tally(effort.rays, 800 + index as u64, |random, tally| {
            let (o, d) = aimed(random, 5.0);
            let (o, d) = (m * o, (m * d).normalize());
            let on_unit = [o, d].map(|v| product(&inverse, v));
            let truth = QuadricTruth::wide(&sphere, on_unit[0], on_unit[1]);
            let (Some(hits), ray) = (truth.hits, Ray::new(o, d)) else { return };
            let hit = probe.nearest(&ray);
            tally.answer(hit.is_some() == hits);
            let (Some(hit), Some(t)) = (hit, truth.nearest) else { return };
            let p = DVec3::from_array([0, 1, 2].map(|i| f64::from(on_unit[0].0[i] + on_unit[1].0[i] * t)));
            let chord = -2.0 * p.dot(inverse * d) / (inverse * d).length_squared();
            // Near the edge, the place of the hit hangs on the last digits of the ray.
            if chord > 1e-2 * (t + chord) {
                let n = (inverse.transpose() * p).normalize();
                tally.worsen(probe.point(&ray, &hit).n.cross(n).length());
            }
        });
        if tally.failed > 0 {
            remarks.push(format!("{name}: {} of {} rays", tally.failed, tally.tried));
        }
        all = all.join(tally);
    }
    Found { remarks, ..Found::own(None, all) }
}

fn product(m: &DMat3, v: DVec3) -> Wide {
    let rows = m.transpose();
    let [x, y, z] = [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| Wide::new(row).dot(Wide::new(v)));
    Wide([x, y, z])
}

#[cfg(test)]
mod tests {
    use super::*;

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
