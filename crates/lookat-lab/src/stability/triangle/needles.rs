//! T5: triangles of almost no height.

use glam::DVec3;
use lookat_render::{Probe, Ray};
use lookat_scene::Scene;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::far::{alone, is_clear, poses};
use super::truth::crossing;
use super::{COUNT, ask_double, ask_single, direction, inside, names, rounded};
use crate::stability::case::{Effort, Found};
use crate::stability::methods::{double, single};
use crate::stability::tally::{Tally, tally};

/// The distance of the needles, whose length is 1.
const DISTANCE: f64 = 5.0;

/// Formulas in single precision are judged by the needle that is left there: from a height of 1e-6 on it is another one.
///
/// The limit is what rounding may do to the thinnest, seen at 3 degrees: 2e-16 of its distance is 2e-6 of its height, and
/// along its height and length the distance changes by no more than a fifth.
pub(super) fn needles(effort: &Effort) -> Found {
    let mut found = Found::default();
    for exponent in 3..9 {
        let height = 10_f64.powi(-exponent);
        let poses = poses(3500 + exponent as u64, |random| needle(random, height));
        let scenes: Vec<Scene> = poses.iter().map(alone).collect();
        let probes: Vec<Probe> = scenes.iter().map(Probe::new).collect();
        let attempt = |random: &mut Pcg64Mcg, tallies: &mut [Tally; COUNT]| {
            let pose = random.random_range(0..poses.len());
            let triangle = poses[pose];
            let d = inside(random, triangle).normalize();
            if is_clear(d, triangle) {
                let judge = judge(d, triangle);
                judge(
                    &mut tallies[0],
                    probes[pose].nearest(&Ray::new(probes[pose].eye(), d)).map(|hit| hit.t),
                );
                let corners = [triangle.map(|corner| corner.to_array())];
                ask_double(tallies, [[0.0; 3], d.to_array()], &corners, judge);
            }
            let triangle = rounded(triangle);
            let d = single(inside(random, triangle).normalize());
            if is_clear(double(d), triangle) {
                let corners = [triangle.map(single)];
                ask_single(tallies, [[0.0; 3], d], &corners, judge(double(d), triangle));
            }
        };
        found.add(Some(1.0 / height), &names(), &tally(effort.rays, 3550 + exponent as u64, attempt));
    }
    // In single precision nothing is left of the thinnest.
    found.rows.retain(|row| row.tried > 0);
    found
}

/// A miss is wrong; a hit has the relative error of its distance.
fn judge(d: DVec3, triangle: [DVec3; 3]) -> impl Fn(&mut Tally, Option<f64>) + Copy {
    let truth = crossing(DVec3::ZERO, d, triangle).map_or(f64::NAN, |crossing| crossing.t);
    move |tally, t| match t {
        Some(t) => tally.error(((t - truth) / truth).abs()),
        None => tally.answer(false),
    }
}

/// A needle in any pose.
fn needle(random: &mut Pcg64Mcg, height: f64) -> [DVec3; 3] {
    let middle = direction(random) * DISTANCE;
    loop {
        let along = direction(random);
        let up = along.cross(direction(random)).normalize();
        // Seen from the side, so that none is hidden by its own edge.
        if along.cross(up).dot(middle / DISTANCE).abs() > 0.1 {
            return [middle - along * 0.5, middle + along * 0.5, middle + along * 0.1 + up * height];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::case::LOOKAT;

    #[test]
    fn nobody_loses_what_is_not_thin() {
        let found = needles(&Effort { rays: 2000 });
        for row in found.rows.iter().filter(|row| row.at == Some(1e3)) {
            assert!(row.failed < row.tried / 10, "{row:?}");
            assert!(row.worst.unwrap() < if row.method.contains("f64") { 1e-9 } else { 0.1 }, "{row:?}");
        }
        assert!(found.rows.iter().any(|row| row.method == LOOKAT));
    }
}
