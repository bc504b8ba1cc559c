//! Surfaces close to each other: V6.

use glam::{DMat3, DVec3};
use lookat_render::{Probe, Ray};
use lookat_scene::Scene;
use rand_pcg::Pcg64Mcg;

use super::offsets::origins;
use crate::stability::case::{Effort, Found, LOOKAT};
use crate::stability::methods::offset::{Body, HitPoint, normal};
use crate::stability::methods::{double, single};
use crate::stability::random::{between, direction, in_triangle};
use crate::stability::tally::{Tally, tally};
use crate::text_scene::scene;

/// Formulas that put the origin beyond the next surface fail; what is tried is the offset alone, on a surface that single
/// precision holds, so that the rounding of the gap is not counted.
const METHODS: [&str; 3] = ["pbrt-v3 f32", "Wächter and Binder f32", "Mitsuba f32"];

pub(super) fn thin(effort: &Effort) -> Found {
    let mut found = Found::default();
    for exponent in 3..=9 {
        let gap = 10_f64.powi(-exponent);
        let seed = (2800 + 10 * exponent) as u64;
        let frame = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        let own = [(quads(frame, gap), seed), (spheres(gap), seed + 1)].map(|(scene, seed)| {
            let probe = Probe::new(&scene);
            let [tally] =
                tally(effort.rays.div_ceil(2), seed, |random, [tally]| cross(random, &probe, frame, tally));
            tally
        });
        found.add(Some(gap), &[LOOKAT], &[own[0].join(own[1])]);
        let others =
            tally(effort.rays, seed + 2, |random, tallies: &mut [Tally; 3]| jumped(random, gap, tallies));
        found.add(Some(gap), &METHODS, &others);
    }
    found
}

const HEAD: &str = r#"Camera "perspective" Integrator "path" Sampler "sobol" Film "image" WorldBegin "#;

/// Two parallel quads, one and one plus the gap before the eye, which turns as they do.
fn quads(frame: DMat3, gap: f64) -> Scene {
    let quad = |z: f64| {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let corners =
            corners.map(|(x, y)| frame * DVec3::new(x, y, z)).map(|p| format!("{} {} {} ", p.x, p.y, p.z));
        format!(
            "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [{}]\n",
            corners.concat()
        )
    };
    scene(&format!("{HEAD}{}{} WorldEnd", quad(1.0), quad(1.0 + gap)))
}

/// Two spheres around a point near the eye, which is inside.
fn spheres(gap: f64) -> Scene {
    let outer = 1.0 + gap;
    scene(&format!(
        "{HEAD} Translate 0.2 -0.3 0.1 Shape \"sphere\" Shape \"sphere\" \"float radius\" {outer} WorldEnd"
    ))
}

/// From the eye to the first surface, through it, and on: the second must be met.
fn cross(random: &mut Pcg64Mcg, probe: &Probe, frame: DMat3, tally: &mut Tally) {
    let toward = DVec3::new(between(random, -0.5, 0.5), between(random, -0.5, 0.5), 1.0);
    let ray = Ray::new(DVec3::ZERO, (frame * toward).normalize());
    let first = probe.nearest(&ray).filter(|hit| hit.element.primitive == 0);
    let Some(first) = first else { return tally.answer(false) };
    let n = probe.point(&ray, &first).n;
    let n = if n.dot(ray.d) < 0.0 { -n } else { n };
    let d = steep(random, n);
    let on = probe.leave(&ray, &first, d);
    let second = probe.nearest(&on);
    tally.answer(second.is_some_and(|hit| hit.element.primitive == 1) && probe.occluded(&on));
}

/// A direction whose cosine with `n` is more than 0.3.
fn steep(random: &mut Pcg64Mcg, n: DVec3) -> DVec3 {
    loop {
        let d = direction(random);
        if d.dot(n) > 0.3 {
            return d;
        }
    }
}

/// Whether the formulas put the origin further than the gap from a triangle.
fn jumped(random: &mut Pcg64Mcg, gap: f64, tallies: &mut [Tally; 3]) {
    let n = direction(random);
    let along = n.any_orthonormal_vector();
    let corners =
        [(1.0, 0.0), (-0.5, 0.8), (-0.5, -0.8)].map(|(a, b)| single(n + along * a + n.cross(along) * b));
    let exact = corners.map(|p| p.map(f64::from));
    let mut n = DVec3::from(normal(exact));
    if n.dot(DVec3::from(exact[0])) < 0.0 {
        n = -n;
    }
    let weights = in_triangle(random);
    let target = (0..3).map(|k| DVec3::from(exact[k]) * weights[k]).sum::<DVec3>();
    let Some(hit): Option<HitPoint<f32>> = Body::Triangle(corners).hit([0.0; 3], single(target.normalize()))
    else {
        return;
    };
    for (tally, o) in tallies.iter_mut().zip(origins(&hit, n)) {
        let height = (double(o) - DVec3::from(exact[0])).dot(n);
        if height < gap { tally.error(height) } else { tally.answer(false) }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    /// A gap that all offsets fit in is no trouble to anybody.
    #[test]
    fn wide_gaps_are_crossed() {
        let mut random = Pcg64Mcg::seed_from_u64(5);
        let mut tallies = [Tally::default(); 3];
        for _ in 0..1000 {
            jumped(&mut random, 1e-2, &mut tallies);
        }
        assert!(tallies.iter().all(|tally| tally.tried > 900 && tally.failed == 0), "{tallies:?}");
    }
}
