//! Rays against disks, cylinders, cones, paraboloids and hyperboloids: S10 to S12.

mod truth;

use twofloat::TwoFloat;

use crate::stability::prelude::*;
pub(super) use truth::QuadricTruth;

pub(super) const MEASURES: &[(&str, Measure)] =
    &[("S10", far), ("S11", |effort| tangent(effort, 12_000, &SHAPES)), ("S12", leaving)];

/// A surface x² + y² = a (z - s)² + b z + c, cut.
#[derive(Debug, Clone, Copy)]
struct Round {
    /// a, s, b.
    profile: [f64; 3],
    /// c.
    constant: TwoFloat,
    /// Lowest and highest z.
    heights: [f64; 2],
    /// A sweep of 270 degrees starts at x = `start[0]`, y = `start[1]` z; `None` for a whole turn.
    start: Option<[f64; 2]>,
}

/// A shape of about size one, with the middle of its height at the origin.
pub(super) struct CutShape {
    /// In a scene.
    text: &'static str,
    /// What it is; nothing for the disk.
    round: Option<Round>,
}

const SHAPES: [CutShape; 5] = [
    CutShape { text: r#"Shape "disk" "float innerradius" 0.25"#, round: None },
    cut(r#"Shape "cylinder""#, [0.0; 3], 1.0, 1.0, [1.0, 0.0]),
    cut(r#"Translate 0 0 -1 Shape "cone" "float height" 2"#, [0.25, 1.0, 0.0], 0.0, 1.0, [1.0, 0.0]),
    cut(
        r#"Translate 0 0 -0.625 Shape "paraboloid" "float zmin" 0.25"#,
        [0.0, 0.0, 1.0],
        0.625,
        0.375,
        [1.0, 0.0],
    ),
    cut(HYPERBOLOID, [0.25, 0.0, 0.0], 0.25, 1.0, [0.5, -0.5]),
];

const HYPERBOLOID: &str = r#"Shape "hyperboloid" "point p1" [0.5 0.5 -1] "point p2" [0.5 -0.5 1]"#;

/// A surface of revolution up to that height above and below the origin.
const fn cut(text: &'static str, profile: [f64; 3], constant: f64, height: f64, start: [f64; 2]) -> CutShape {
    let (constant, heights) = (TwoFloat::from_f64(constant), [-height, height]);
    CutShape { text, round: Some(Round { profile, constant, heights, start: Some(start) }) }
}

impl CutShape {
    /// The whole sphere of this radius.
    pub fn sphere(radius: f64) -> CutShape {
        let constant = TwoFloat::new_mul(radius, radius);
        let round = Round { profile: [-1.0, 0.0, 0.0], constant, heights: [-radius, radius], start: None };
        CutShape { text: "Shape \"sphere\"", round: Some(round) }
    }

    /// The shape alone, around the eye, so that rays of a probe may start anywhere around it.
    fn probe(&self, size: f64) -> Probe {
        let is_whole = self.round.is_some_and(|round| round.start.is_none());
        let sweep = if is_whole { 360 } else { 270 };
        let shape = format!("{} \"float phimax\" {sweep}", self.text);
        probe(&around_eye(&format!("Scale {size:e} {size:e} {size:e} {shape}")))
    }

    /// A point of the surface, away from where it is cut, and a normal; of the disk one of its edge, and outward.
    fn point(&self, random: &mut Pcg64Mcg) -> (DVec3, DVec3) {
        let angle = between(random, 0.1, 4.6);
        let Some(Round { profile: [a, s, b], constant, heights: [low, high], start }) = self.round else {
            let p = DVec2::from_angle(angle).extend(0.0);
            return (p, p);
        };
        let z = between(random, 0.9 * low, 0.9 * high);
        let r = (a * (z - s) * (z - s) + b * z + f64::from(constant)).sqrt();
        let [x, y] = start.unwrap_or([1.0, 0.0]);
        let at = DVec2::from_angle(angle).rotate(DVec2::new(x, y * z).normalize()) * r;
        (at.extend(z), at.extend(-a * (z - s) - 0.5 * b).normalize())
    }
}

/// Whether a ray hits, against the truth.
pub(super) fn ask(tally: &mut Tally, shape: &CutShape, hits: bool, o: DVec3, d: DVec3) {
    if let Some(truth) = QuadricTruth::new(shape, o, d).hits {
        tally.answer(hits == truth);
    }
}

/// Rays at shapes, as many at each.
fn at_each(
    effort: &Effort,
    seed: u64,
    shapes: &[CutShape],
    size: f64,
    attempt: impl Fn(&Probe, &CutShape, &mut Pcg64Mcg, &mut Tally) + Sync,
) -> Tally {
    let of = |(seed, shape): (u64, &CutShape)| {
        let probe = shape.probe(size);
        tally(effort.rays.div_ceil(shapes.len() as u64), seed, |random, tally| {
            attempt(&probe, shape, random, tally)
        })
    };
    (seed..).step_by(100).zip(shapes).map(of).fold(Tally::default(), Tally::join)
}

fn far(effort: &Effort) -> Found {
    Found::sweep(11_000, std::iter::once(1.5).chain(decades(1..10)), |seed, distance| {
        at_each(effort, seed, &SHAPES, 1.0, |probe, shape, random, tally| {
            let o = direction(random) * distance;
            let d = (in_cube(random) * 1.2 - o).normalize();
            let hit = probe.nearest(&Ray::new(o, d));
            ask(tally, shape, hit.is_some(), o, d);
            if let (true, Some(hit), Some(t)) =
                (distance <= 100.0, hit, QuadricTruth::new(shape, o, d).nearest)
            {
                // Where a ray grazes, its distance depends on the last digits of it.
                let p = probe.point(&Ray::new(o, d), &hit);
                let cos = p.n.dot(d).abs();
                tally.error((hit.t - t).abs() / distance * cos + p.p.distance(o + d * t) / distance * cos);
            }
        })
    })
}

/// Rays that pass by, and some that do not, by a trillionth of the size.
pub(super) fn tangent(effort: &Effort, seed: u64, shapes: &[CutShape]) -> Found {
    Found::sweep(seed, decades(0..4), |seed, distance| {
        at_each(effort, seed, shapes, 1.0, |probe, shape, random, tally| {
            let (p, n) = shape.point(random);
            let d = match shape.round {
                Some(_) => direction(random).cross(n).normalize(),
                None => direction(random),
            };
            let beside = if chance(random, 0.5) { 1e-12 } else { -1e-12 };
            let o = p + n * beside - d * distance;
            ask(tally, shape, probe.nearest(&Ray::new(o, d)).is_some(), o, d);
        })
    })
}

fn leaving(effort: &Effort) -> Found {
    Found::sweep(13_000, [1e-30, 1e-12, 1e-3, 1.0, 1e3, 1e12, 1e30], |seed, size| {
        at_each(effort, seed, &SHAPES, size, |probe, shape, random, tally| {
            let o = direction(random) * 3.0;
            let ray = Ray::new(o * size, (shape.point(random).0 - o).normalize());
            let Some(hit) = probe.nearest(&ray) else { return };
            let point = probe.point(&ray, &hit);
            let d = direction(random);
            let found = probe.nearest(&probe.leave(&ray, &hit, d));
            let Some(expected) = truth::beyond(shape, point.p / size, d, point.n.dot(d)) else { return };
            tally.answer(found.is_some() == expected.is_some());
            if let (Some(hit), Some(t)) = (found, expected) {
                tally.error((hit.t / size - t).abs() * point.n.dot(d).abs());
            }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_truth_is_that_of_simple_rays() {
        // From +y and above, downward: each shape stands in the way, and its cut away quarter does not.
        let down =
            |shape: &CutShape, y: f64| QuadricTruth::new(shape, DVec3::new(-0.5, y, 3.0), -DVec3::Z).hits;
        assert_eq!([down(&SHAPES[0], 0.0), down(&SHAPES[0], 1.0)], [Some(true), Some(false)]);
        let across = |shape: &CutShape, x: f64, y: f64| {
            let o = DVec3::new(x, y, 0.1);
            QuadricTruth::new(shape, o * 5.0 + DVec3::Z * -0.4, -DVec3::new(x, y, 0.0)).nearest
        };
        for shape in &SHAPES[1..] {
            let near = across(shape, -1.0, 1.0).unwrap();
            let through_the_gap = across(shape, 1.0, -1.0).unwrap();
            assert!((near + through_the_gap - 10.0).abs() < 1.5 && near < 5.0 && through_the_gap > 5.0);
        }
        assert!((across(&SHAPES[1], -0.6, 0.8).unwrap() - 4.0).abs() < 1e-15);
    }
}
