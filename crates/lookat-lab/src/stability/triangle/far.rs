//! T3 to T5: large triangles up to the horizon, small ones far away, and triangles of almost no height.

use crate::stability::prelude::*;
use crate::stability::truth::{cosine, crossing};

/// A square on the ground, its middle below an eye at height 1.
pub(super) fn horizon(effort: &Effort) -> Found {
    Found::sweep(3300, decades(2..10), |seed, half| {
        let ground = quads(&square(DVec3::ZERO, DVec3::X * half, DVec3::Z * half));
        let probe = probe(&seen_from(DVec3::Y, &ground));
        tally(effort.rays, seed, |random, tally| {
            let (o, d) = downward(random, half);
            if on_ground(o, d, half) {
                // Positions are relative to the eye.
                tally.answer(probe.nearest(&Ray::new(probe.eye() + (o - DVec3::Y), d)).is_some());
            }
        })
    })
}

/// Two triangles whose common edge is a side of the boxes of both, and whose corners are far beyond the hits: rays close to that
/// edge.
pub(super) fn seam(effort: &Effort) -> Found {
    Found::sweep(3400, decades(2..10), |seed, half| {
        let [a, b] = [-half, half].map(|z| DVec3::new(0.5, 0.0, z));
        let corners = [a, b, DVec3::new(-half, 0.0, 0.0), DVec3::new(half, 0.0, 0.0)];
        let probe = probe(&seen_from(DVec3::Y, &mesh(&corners, &[[0, 1, 2], [0, 3, 1]])));
        tally(effort.rays, seed, |random, tally| {
            let mut number = |low, high| between(random, low, high);
            let o = DVec3::new(number(-1.0, 1.0), 1.0, number(-1.0, 1.0));
            let beside = 10_f64.powf(number(-17.0, -5.0)).copysign(number(-1.0, 1.0));
            let d = (DVec3::new(0.5 + beside, 0.0, number(2.0, 50.0)) - o).normalize();
            tally.answer(probe.nearest(&Ray::new(probe.eye() + (o - DVec3::Y), d)).is_some());
        })
    })
}

/// A ray from height 1, somewhere near the middle, to a place on the ground; all powers of distance are as likely.
fn downward(random: &mut Pcg64Mcg, half: f64) -> (DVec3, DVec3) {
    let mut near = || (random.random::<f64>() - 0.5) * 0.1 * half;
    let o = DVec3::new(near(), 1.0, near());
    let (sin, cos) = (std::f64::consts::TAU * random.random::<f64>()).sin_cos();
    let distance = half.powf(random.random::<f64>());
    (o, DVec3::new(distance * cos, -1.0, distance * sin).normalize())
}

/// Whether the ray crosses the ground on the square, not at its rim. The rim is far wider than rounding reaches.
fn on_ground(o: DVec3, d: DVec3, half: f64) -> bool {
    let p = o - d * (o.y / d.y);
    d.y < 0.0 && p.x.abs().max(p.z.abs()) < half * 0.999
}

/// Poses of the far triangle, each a scene of its own.
const POSES: usize = 64;

/// A triangle of size 1, seen at no less than 3 degrees; rays that keep off its edges by a thousandth of it must hit.
pub(super) fn small(effort: &Effort) -> Found {
    Found::sweep(3450, decades(2..10), |seed, distance| {
        let triangle = |random: &mut _| any_triangle(random, distance);
        at_poses(effort, seed, triangle, |tally, t, _, _| tally.answer(t.is_some()))
    })
}

/// Sends rays from the origin at triangles that each stand alone. `judge` gets the distance that lookat finds, the direction and
/// the triangle.
fn at_poses(
    effort: &Effort,
    seed: u64,
    make: impl Fn(&mut Pcg64Mcg) -> [DVec3; 3],
    judge: impl Fn(&mut Tally, Option<f64>, DVec3, [DVec3; 3]) + Sync,
) -> Tally {
    let poses = poses(seed + 100, make);
    let probes: Vec<Probe> = poses.iter().map(|pose| probe(&around_eye(&triangles(pose)))).collect();
    tally(effort.rays, seed, |random, tally| {
        let pose = random.random_range(0..POSES);
        let triangle = poses[pose];
        let d = in_triangle(random, triangle).normalize();
        if is_clear(d, triangle) {
            let hit = probes[pose].nearest(&Ray::new(probes[pose].eye(), d));
            judge(tally, hit.map(|hit| hit.t), d, triangle);
        }
    })
}

/// Triangles from random numbers.
pub(super) fn poses(seed: u64, make: impl Fn(&mut Pcg64Mcg) -> [DVec3; 3]) -> Vec<[DVec3; 3]> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    (0..POSES).map(|_| make(&mut random)).collect()
}

fn any_triangle(random: &mut Pcg64Mcg, distance: f64) -> [DVec3; 3] {
    let middle = direction(random) * distance;
    loop {
        let triangle = [0; 3].map(|_| middle + direction(random) * 0.5);
        let [a, b, c] = triangle;
        if (b - a).cross(c - a).length() > 0.2 && cosine(middle / distance, triangle) > 0.1 {
            return triangle;
        }
    }
}

/// Whether a ray from the origin hits for certain, and not at a grazing angle.
fn is_clear(d: DVec3, triangle: [DVec3; 3]) -> bool {
    let clear = crossing(DVec3::ZERO, d, triangle).is_some_and(|crossing| crossing.inside > 1e-3);
    clear && cosine(d, triangle) > 0.05
}

/// The distance of the needles, whose length is 1.
const NEEDLE_DISTANCE: f64 = 5.0;

/// A miss is wrong; a hit has the relative error of its distance.
///
/// The limit is what rounding may do to the thinnest, seen at 3 degrees: 2e-16 of its distance is 2e-6 of its height, and
/// along its height and length the distance changes by no more than a fifth.
pub(super) fn needles(effort: &Effort) -> Found {
    Found::sweep(3550, decades(3..9), |seed, slenderness| {
        let needle = |random: &mut Pcg64Mcg| needle(random, 1.0 / slenderness);
        at_poses(effort, seed, needle, |tally, t, d, triangle| {
            let truth = crossing(DVec3::ZERO, d, triangle).map_or(f64::NAN, |crossing| crossing.t);
            match t {
                Some(t) => tally.error(((t - truth) / truth).abs()),
                None => tally.answer(false),
            }
        })
    })
}

/// A needle in any pose.
fn needle(random: &mut Pcg64Mcg, height: f64) -> [DVec3; 3] {
    let middle = direction(random) * NEEDLE_DISTANCE;
    loop {
        let along = direction(random);
        let up = along.cross(direction(random)).normalize();
        // Seen from the side, so that none is hidden by its own edge.
        if along.cross(up).dot(middle / NEEDLE_DISTANCE).abs() > 0.1 {
            return [middle - along * 0.5, middle + along * 0.5, middle + along * 0.1 + up * height];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ground_ends_where_it_should() {
        let o = DVec3::new(1.0, 1.0, 2.0);
        let to = |x: f64, z: f64| DVec3::new(x, 0.0, z) - o;
        assert!(on_ground(o, to(99.0, -99.0), 100.0));
        assert!(!on_ground(o, to(100.0, 0.0), 100.0));
        assert!(!on_ground(o, to(0.0, -101.0), 100.0));
        assert!(!on_ground(o, -to(0.0, 0.0), 100.0));
    }
}
