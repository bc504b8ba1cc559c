//! Rays against disks, cylinders, cones, paraboloids and hyperboloids: S10 to S12.

mod truth;

use glam::{DVec2, DVec3};
use lookat_render::{Probe, Ray};
use lookat_scene::Scene;
use rand_pcg::Pcg64Mcg;

use super::case::{Axis, Case, Effort, Family, Found, LOOKAT};
use super::methods::quadric::{Round, pbrt_v3, pbrt_v3_disk};
use super::methods::{double, single};
use super::random::{between, chance, direction, in_cube};
use super::tally::{Tally, tally};
use crate::text_scene::scene;
use truth::Truth;

#[rustfmt::skip]
pub(super) fn cases() -> Vec<Case> {
    let case = |id, name, claim, axis, error, limit, run| {
        Case { id, name, family: Family::Sphere, claim, axis, error, limit, run }
    };
    vec![
        case("S10", "far-quadrics", "rays aimed at and beside partial disks, cylinders, cones and other quadrics hit or miss correctly",
            Axis::Of("distance / size"), "error of the hit point, in sizes, up to a distance of 100", 1e-12, far),
        case("S11", "tangent-quadrics", "rays that pass such shapes, or the edge of a disk, 1e-12 sizes inside and outside hit and miss them",
            Axis::Of("distance / size"), "", 0.0, tangent),
        case("S12", "leaving-quadrics", "a ray that leaves such a shape hits its other side, not its own start",
            Axis::Of("size"), "error of the distance, in sizes", 1e-8, leaving),
    ]
}

/// A shape of about size one, with the middle of its height at the origin.
pub(super) struct Form {
    /// In a scene.
    text: &'static str,
    /// What it is; nothing for the disk.
    round: Option<Round>,
    method: &'static str,
}

const FORMS: [Form; 5] = [
    Form {
        text: r#"Shape "disk" "float innerradius" 0.25 "float phimax" 270"#,
        round: None,
        method: "pbrt-v3 disk",
    },
    Form {
        text: r#"Shape "cylinder" "float phimax" 270"#,
        round: Some(Round { profile: [0.0, 0.0, 0.0, 1.0], heights: [-1.0, 1.0], start: [1.0, 0.0] }),
        method: "pbrt-v3 cylinder",
    },
    Form {
        text: r#"Translate 0 0 -1 Shape "cone" "float height" 2 "float phimax" 270"#,
        round: Some(Round { profile: [0.25, 1.0, 0.0, 0.0], heights: [-1.0, 1.0], start: [1.0, 0.0] }),
        method: "pbrt-v3 cone",
    },
    Form {
        text: r#"Translate 0 0 -0.625 Shape "paraboloid" "float zmin" 0.25 "float phimax" 270"#,
        round: Some(Round { profile: [0.0, 0.0, 1.0, 0.625], heights: [-0.375, 0.375], start: [1.0, 0.0] }),
        method: "pbrt-v3 paraboloid",
    },
    Form {
        text: r#"Shape "hyperboloid" "point p1" [0.5 0.5 -1] "point p2" [0.5 -0.5 1] "float phimax" 270"#,
        round: Some(Round { profile: [0.25, 0.0, 0.0, 0.25], heights: [-1.0, 1.0], start: [0.5, -0.5] }),
        method: "pbrt-v3 hyperboloid",
    },
];

impl Form {
    /// The form alone, around the eye, so that rays of a probe may start anywhere around it.
    fn scene(&self, size: f64) -> Scene {
        scene(&format!(
            r#"Camera "perspective" Integrator "path" Sampler "sobol" Film "image"
               WorldBegin LightSource "infinite" Scale {size:e} {size:e} {size:e} {} WorldEnd"#,
            self.text
        ))
    }

    /// By pbrt-v3's formula.
    fn pbrt_v3(&self, o: DVec3, d: DVec3) -> bool {
        let (o, d) = (single(o), single(d));
        match &self.round {
            Some(round) => pbrt_v3(round, o, d).is_some(),
            None => pbrt_v3_disk(o, d).is_some(),
        }
    }

    /// A point of the surface, away from where it is cut, and a normal; of the disk one of its edge, and outward.
    fn point(&self, random: &mut Pcg64Mcg) -> (DVec3, DVec3) {
        let angle = between(random, 0.1, 4.6);
        let Some(Round { profile: [a, s, b, c], heights: [low, high], start }) = self.round else {
            let p = DVec2::from_angle(angle).extend(0.0);
            return (p, p);
        };
        let z = between(random, 0.9 * low, 0.9 * high);
        let r = (a * (z - s) * (z - s) + b * z + c).sqrt();
        let at = DVec2::from_angle(angle).rotate(DVec2::new(start[0], start[1] * z).normalize()) * r;
        (at.extend(z), at.extend(-a * (z - s) - 0.5 * b).normalize())
    }
}

const METHODS: [&str; 6] =
    [LOOKAT, FORMS[0].method, FORMS[1].method, FORMS[2].method, FORMS[3].method, FORMS[4].method];

/// What lookat and pbrt-v3's formula say of a ray. The latter gets it rounded, with the truth of that.
fn ask(tallies: &mut [Tally; 6], form: usize, own: bool, o: DVec3, d: DVec3) {
    if let Some(hits) = Truth::new(&FORMS[form], o, d).hits {
        tallies[0].answer(own == hits);
    }
    let (o, d) = (double(single(o)), double(single(d)));
    if let Some(hits) = Truth::new(&FORMS[form], o, d).hits {
        tallies[1 + form].answer(FORMS[form].pbrt_v3(o, d) == hits);
    }
}

/// Rays of [`FORMS`] in turn, so many of each.
fn of_all_forms(
    effort: &Effort,
    seed: u64,
    size: f64,
    attempt: impl Fn(&Probe, usize, &mut Pcg64Mcg, &mut [Tally; 6]) + Sync,
) -> [Tally; 6] {
    let mut all = [Tally::default(); 6];
    for (number, form) in FORMS.iter().enumerate() {
        let scene = form.scene(size);
        let probe = Probe::new(&scene);
        let found = tally(effort.rays.div_ceil(5), seed + 100 * number as u64, |random, tallies| {
            attempt(&probe, number, random, tallies);
        });
        all = std::array::from_fn(|i| all[i].join(found[i]));
    }
    all
}

fn far(effort: &Effort) -> Found {
    let mut found = Found::default();
    for exponent in 0..10 {
        let distance = if exponent == 0 { 1.5 } else { 10_f64.powi(exponent) };
        let tallies = of_all_forms(effort, 11_000 + exponent as u64, 1.0, |probe, form, random, tallies| {
            let o = direction(random) * distance;
            let d = (in_cube(random) * 1.2 - o).normalize();
            let hit = probe.nearest(&Ray::new(o, d));
            ask(tallies, form, hit.is_some(), o, d);
            if let (true, Some(hit), Some(t)) =
                (distance <= 100.0, hit, Truth::new(&FORMS[form], o, d).nearest)
            {
                // Where a ray grazes, its distance depends on the last digits of it.
                let p = probe.point(&Ray::new(o, d), &hit);
                let cos = p.n.dot(d).abs();
                tallies[0]
                    .error((hit.t - t).abs() / distance * cos + p.p.distance(o + d * t) / distance * cos);
            }
        });
        found.add(Some(distance), &METHODS, &tallies);
    }
    found
}

fn tangent(effort: &Effort) -> Found {
    let mut found = Found::default();
    for exponent in 0..4 {
        let distance = 10_f64.powi(exponent);
        let tallies = of_all_forms(effort, 12_000 + exponent as u64, 1.0, |probe, form, random, tallies| {
            let (p, n) = FORMS[form].point(random);
            let d = match FORMS[form].round {
                Some(_) => direction(random).cross(n).normalize(),
                None => direction(random),
            };
            let beside = if chance(random, 0.5) { 1e-12 } else { -1e-12 };
            let o = p + n * beside - d * distance;
            ask(tallies, form, probe.nearest(&Ray::new(o, d)).is_some(), o, d);
        });
        found.add(Some(distance), &METHODS, &tallies);
    }
    found
}

/// Another way starts a little along the ray, and asks the exact truth from there.
fn leaving(effort: &Effort) -> Found {
    const METHODS: [&str; 2] = [LOOKAT, "start 1e-4 along the ray"];
    let mut found = Found::default();
    for (index, size) in [1e-30, 1e-12, 1e-3, 1.0, 1e3, 1e12, 1e30].into_iter().enumerate() {
        let tallies = of_all_forms(effort, 13_000 + index as u64, size, |probe, form, random, tallies| {
            let o = direction(random) * 3.0;
            let ray = Ray::new(o * size, (FORMS[form].point(random).0 - o).normalize());
            let Some(hit) = probe.nearest(&ray) else { return };
            let point = probe.point(&ray, &hit);
            let d = direction(random);
            let found = probe.nearest(&probe.leave(&ray, &hit, d));
            let p = point.p / size;
            let Some(expected) = truth::beyond(&FORMS[form], p, d, point.n.dot(d)) else { return };
            tallies[0].answer(found.is_some() == expected.is_some());
            if let (Some(hit), Some(t)) = (found, expected) {
                tallies[0].error((hit.t / size - t).abs() * point.n.dot(d).abs());
            }
            let start = (point.p + d * 1e-4) / size;
            if let Some(hits) = Truth::new(&FORMS[form], start, d).hits {
                tallies[1].answer(hits == expected.is_some());
            }
        });
        found.add(Some(size), &METHODS, &[tallies[0], tallies[1]]);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_truth_is_that_of_simple_rays() {
        // From +y and above, downward: each form stands in the way, and its cut away quarter does not.
        let down = |form: &Form, y: f64| Truth::new(form, DVec3::new(-0.5, y, 3.0), -DVec3::Z).hits;
        assert_eq!([down(&FORMS[0], 0.0), down(&FORMS[0], 1.0)], [Some(true), Some(false)]);
        let across = |form: &Form, x: f64, y: f64| {
            let o = DVec3::new(x, y, 0.1);
            Truth::new(form, o * 5.0 + DVec3::Z * -0.4, -DVec3::new(x, y, 0.0)).nearest
        };
        for form in &FORMS[1..] {
            let near = across(form, -1.0, 1.0).unwrap();
            let through_the_gap = across(form, 1.0, -1.0).unwrap();
            assert!((near + through_the_gap - 10.0).abs() < 1.5 && near < 5.0 && through_the_gap > 5.0);
        }
        assert!((across(&FORMS[1], -0.6, 0.8).unwrap() - 4.0).abs() < 1e-15);
        assert!(FORMS[1].pbrt_v3(DVec3::new(-3.0, 4.0, 0.1), DVec3::new(0.6, -0.8, 0.0)));
        assert!(!FORMS[1].pbrt_v3(DVec3::new(-3.0, 4.0, 1.1), DVec3::new(0.6, -0.8, 0.0)));
    }
}
