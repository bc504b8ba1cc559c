//! Surfaces close to each other: V6.

use crate::stability::prelude::*;

pub(super) fn thin(effort: &Effort) -> Found {
    let frame = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    Found::sweep(2800, decades((3..=9).map(|exponent| -exponent)), |seed, gap| {
        let surfaces = [(parallel(frame, gap), seed), (spheres(gap), seed + 10)];
        let tallies = surfaces.map(|(scene, seed)| {
            let probe = Probe::new(&scene);
            tally(effort.rays.div_ceil(2), seed, |random, tally| cross(random, &probe, frame, tally))
        });
        tallies[0].join(tallies[1])
    })
}

/// Two parallel quads, one and one plus the gap before the eye, which turns as they do.
fn parallel(frame: DMat3, gap: f64) -> Scene {
    let quad = |z: f64| quads(&square(frame.z_axis * z, frame.x_axis, frame.y_axis));
    scene(&around_eye(&(quad(1.0) + &quad(1.0 + gap))))
}

/// Two spheres around a point near the eye, which is inside.
fn spheres(gap: f64) -> Scene {
    let outer = 1.0 + gap;
    let spheres = format!("Shape \"sphere\" Shape \"sphere\" \"float radius\" {outer}");
    scene(&around_eye(&format!("Translate 0.2 -0.3 0.1 {spheres}")))
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
