//! T3 and T4: large triangles up to the horizon, and small ones far away.

use glam::DVec3;
use lookat_render::{Probe, Ray};
use lookat_scene::Scene;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use twofloat::TwoFloat;

use super::truth::{cosine, crossing};
use super::{COUNT, ask_double, ask_single, direction, inside, mesh_text, names, rounded, text};
use crate::stability::case::{Effort, Found};
use crate::stability::methods::{double, single};
use crate::stability::tally::{Tally, tally};
use crate::stability::truth::quotient;
use crate::text_scene::scene;

/// A square on the ground, its middle below an eye at height 1.
pub(super) fn horizon(effort: &Effort) -> Found {
    let mut found = Found::default();
    for exponent in 2..10 {
        let half = 10_f64.powi(exponent);
        let corner = |x: f64, z: f64| DVec3::new(x * half, 0.0, z * half);
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let faces = [[0, 1, 2], [0, 2, 3]];
        let scene = scene(&text(DVec3::Y, &mesh_text(&corners, &faces)));
        let probe = Probe::new(&scene);
        let triangles = faces.map(|face| face.map(|i| corners[i].to_array()));
        let rounded = faces.map(|face| face.map(|i| single(corners[i])));
        let attempt = |random: &mut Pcg64Mcg, tallies: &mut [Tally; COUNT]| {
            let (o, d) = downward(random, half);
            if on_ground(o, d, half) {
                // Positions for lookat are relative to the eye.
                tallies[0].answer(probe.nearest(&Ray::new(probe.eye() + (o - DVec3::Y), d)).is_some());
                let ray = [o.to_array(), d.to_array()];
                ask_double(tallies, ray, &triangles, |tally, t| tally.answer(t.is_some()));
            }
            let ray = [single(o), single(d)];
            if on_ground(double(ray[0]), double(ray[1]), half) {
                ask_single(tallies, ray, &rounded, |tally, t| tally.answer(t.is_some()));
            }
        };
        found.add(Some(half), &names(), &tally(effort.rays, 3300 + exponent as u64, attempt));
    }
    found
}

/// Two triangles whose common edge is a side of the boxes of both, and whose corners are far beyond the hits: rays close to that
/// edge.
pub(super) fn seam(effort: &Effort) -> Found {
    let mut found = Found::default();
    for exponent in 2..10 {
        let half = 10_f64.powi(exponent);
        let [a, b] = [-half, half].map(|z| DVec3::new(0.5, 0.0, z));
        let corners = [a, b, DVec3::new(-half, 0.0, 0.0), DVec3::new(half, 0.0, 0.0)];
        let faces = [[0, 1, 2], [0, 3, 1]];
        let scene = scene(&text(DVec3::Y, &mesh_text(&corners, &faces)));
        let probe = Probe::new(&scene);
        let triangles = faces.map(|face| face.map(|i| corners[i].to_array()));
        let attempt = |random: &mut Pcg64Mcg, tallies: &mut [Tally; COUNT]| {
            let mut number = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
            let o = DVec3::new(number(-1.0, 1.0), 1.0, number(-1.0, 1.0));
            let beside = 10_f64.powf(number(-17.0, -5.0)).copysign(number(-1.0, 1.0));
            let d = (DVec3::new(0.5 + beside, 0.0, number(2.0, 50.0)) - o).normalize();
            tallies[0].answer(probe.nearest(&Ray::new(probe.eye() + (o - DVec3::Y), d)).is_some());
            let ray = [o.to_array(), d.to_array()];
            ask_double(tallies, ray, &triangles, |tally, t| tally.answer(t.is_some()));
        };
        let tallies = tally(effort.rays, 3400 + exponent as u64, attempt);
        // Single precision cannot hold how far beside the edge these rays are.
        let asked = names().into_iter().zip(tallies).filter(|(_, tally)| tally.tried > 0);
        let (names, tallies): (Vec<_>, Vec<_>) = asked.unzip();
        found.add(Some(half), &names, &tallies);
    }
    found
}

/// A ray from height 1, somewhere near the middle, to a place on the ground; all powers of distance are as likely.
fn downward(random: &mut Pcg64Mcg, half: f64) -> (DVec3, DVec3) {
    let mut near = || (random.random::<f64>() - 0.5) * 0.1 * half;
    let o = DVec3::new(near(), 1.0, near());
    let (sin, cos) = (std::f64::consts::TAU * random.random::<f64>()).sin_cos();
    let distance = half.powf(random.random::<f64>());
    (o, DVec3::new(distance * cos, -1.0, distance * sin).normalize())
}

/// Whether the ray crosses the ground on the square, not at its rim.
fn on_ground(o: DVec3, d: DVec3, half: f64) -> bool {
    let t = quotient(o.y.into(), (-d.y).into());
    let across = |o: f64, d: f64| f64::from(t * TwoFloat::from(d) + TwoFloat::from(o)).abs();
    d.y < 0.0 && across(o.x, d.x).max(across(o.z, d.z)) < half * 0.999
}

/// Poses of the far triangle, each a scene of its own.
const POSES: usize = 64;

/// A triangle of size 1, seen at no less than 3 degrees; rays that keep off its edges by a thousandth of it must hit.
/// Formulas in single precision are judged by the triangle that is left of it there.
pub(super) fn small(effort: &Effort) -> Found {
    let mut found = Found::default();
    for exponent in 2..10 {
        let distance = 10_f64.powi(exponent);
        let poses = poses(3400 + exponent as u64, |random| any_triangle(random, distance));
        let scenes: Vec<Scene> = poses.iter().map(alone).collect();
        let probes: Vec<Probe> = scenes.iter().map(Probe::new).collect();
        let attempt = |random: &mut Pcg64Mcg, tallies: &mut [Tally; COUNT]| {
            let pose = random.random_range(0..POSES);
            let triangle = poses[pose];
            let d = inside(random, triangle).normalize();
            if is_clear(d, triangle) {
                tallies[0].answer(probes[pose].nearest(&Ray::new(probes[pose].eye(), d)).is_some());
                let corners = [triangle.map(|corner| corner.to_array())];
                ask_double(tallies, [[0.0; 3], d.to_array()], &corners, |tally, t| tally.answer(t.is_some()));
            }
            let triangle = rounded(triangle);
            let d = single(inside(random, triangle).normalize());
            if is_clear(double(d), triangle) {
                let corners = [triangle.map(single)];
                ask_single(tallies, [[0.0; 3], d], &corners, |tally, t| tally.answer(t.is_some()));
            }
        };
        found.add(Some(distance), &names(), &tally(effort.rays, 3450 + exponent as u64, attempt));
    }
    // In single precision nothing is left of the farthest.
    found.rows.retain(|row| row.tried > 0);
    found
}

/// Triangles from random numbers.
pub(super) fn poses(seed: u64, make: impl Fn(&mut Pcg64Mcg) -> [DVec3; 3]) -> Vec<[DVec3; 3]> {
    let mut random: Pcg64Mcg = rand::SeedableRng::seed_from_u64(seed);
    (0..POSES).map(|_| make(&mut random)).collect()
}

/// The scene of one triangle, with the eye in the origin.
pub(super) fn alone(triangle: &[DVec3; 3]) -> Scene {
    scene(&text(DVec3::ZERO, &mesh_text(triangle, &[[0, 1, 2]])))
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
pub(super) fn is_clear(d: DVec3, triangle: [DVec3; 3]) -> bool {
    let clear = crossing(DVec3::ZERO, d, triangle).is_some_and(|crossing| crossing.inside > 1e-3);
    clear && cosine(d, triangle) > 0.05
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

    #[test]
    fn nobody_loses_what_is_near() {
        let effort = Effort { rays: 2000 };
        for found in [horizon(&effort), small(&effort)] {
            let near: Vec<_> = found.rows.iter().filter(|row| row.at == Some(100.0)).collect();
            assert_eq!(near.len(), COUNT);
            assert!(near.iter().all(|row| row.tried > 1000), "{near:?}");
            // The transformation of Baldwin and Weber loses some even there.
            assert!(near.iter().all(|row| row.failed == 0 || row.method == "Baldwin-Weber f32"), "{near:?}");
        }
    }
}
