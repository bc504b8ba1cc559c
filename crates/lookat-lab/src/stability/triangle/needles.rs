//! T5: triangles of almost no height.

use super::far::at_poses;
use super::truth::crossing;
use crate::stability::prelude::*;

/// The distance of the needles, whose length is 1.
const DISTANCE: f64 = 5.0;

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
