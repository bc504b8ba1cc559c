//! Trees against asking everything: V2.

mod world;

use lookat_render::Hit;
use rayon::prelude::*;

use crate::stability::prelude::*;
use world::World;

/// Rays for each scene.
const BATCH: u64 = 1000;

/// Rays that went wrong and are told about.
const TOLD: usize = 10;

pub(super) fn agreement(effort: &Effort) -> Found {
    let scenes = effort.rays.div_ceil(BATCH);
    let found: Vec<(Tally, Option<String>)> = (0..scenes)
        .into_par_iter()
        .map(|number| one_scene(2200 << 32 | number, BATCH.min(effort.rays - number * BATCH)))
        .collect();
    let tally = found.iter().fold(Tally::default(), |all, (tally, _)| all.join(*tally));
    let remarks = found.into_iter().filter_map(|(_, told)| told).take(TOLD).collect();
    Found { remarks, ..Found::own(None, tally) }
}

/// Rays in a random scene, and the first that went wrong.
fn one_scene(seed: u64, rays: u64) -> (Tally, Option<String>) {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let world = World::new(&mut random);
    let probe = Probe::new(&world.scene);
    let (mut tally, mut told) = (Tally::default(), None);
    while tally.tried < rays {
        let mut ray = world.aimed(&mut random, probe.origin());
        for _ in 0..3 {
            let problem = disagreement(&probe, &ray);
            tally.answer(problem.is_none());
            told = told.or(problem.map(|what| format!("scene {seed}, o {}, d {}: {what}", ray.o, ray.d)));
            // The next one leaves where this one has hit.
            match probe.nearest_by_all(&ray) {
                Some(hit) if chance(&mut random, 0.3) => {
                    ray = probe.leave(&ray, &hit, direction(&mut random))
                }
                _ => break,
            }
        }
    }
    (tally, told)
}

/// How trees and all elements differ about a ray.
pub(super) fn disagreement(probe: &Probe, ray: &Ray) -> Option<String> {
    let (tree, all) = (probe.nearest(ray), probe.nearest_by_all(ray));
    let name = |hit: &Hit| (hit.element, hit.t.to_bits(), hit.barycentric.map(f64::to_bits));
    if tree.as_ref().map(name) != all.as_ref().map(name) {
        return Some(format!("nearest: tree {tree:?}, all {all:?}"));
    }
    let ends_at = |t_max: f64| probe.occluded(&Ray { t_max, ..*ray });
    if probe.occluded(ray) != all.is_some() {
        return Some(format!("occluded: all {all:?}"));
    }
    let all = all?;
    match (ends_at(all.t), ends_at(all.t.next_down())) {
        (false, _) => Some(format!("not occluded to the hit itself: {all:?}")),
        (_, true) => Some(format!("occluded before the hit: {all:?}")),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Most aimed rays meet something, so that there is something to compare.
    #[test]
    fn rays_hit() {
        let (mut hits, mut tried) = (0, 0);
        for seed in 0..20 {
            let mut random = Pcg64Mcg::seed_from_u64(seed);
            let world = World::new(&mut random);
            let probe = Probe::new(&world.scene);
            for _ in 0..100 {
                hits +=
                    usize::from(probe.nearest_by_all(&world.aimed(&mut random, probe.origin())).is_some());
                tried += 1;
            }
        }
        assert!(hits * 2 > tried, "{hits} of {tried}");
    }
}
