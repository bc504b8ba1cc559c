//! Trees against asking everything: V2.

use lookat_render::{Hit, Probe, Ray};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use twofloat::TwoFloat;

use crate::stability::case::{Effort, Found, LOOKAT};
use crate::stability::methods::slab::{self, Box32};
use crate::stability::methods::{double, single};
use crate::stability::random::{below, chance, direction};
use crate::stability::tally::{Tally, tally};
use crate::stability::truth::Wide;
use crate::text_scene::scene;

mod world;

use world::World;

/// Rays for each scene.
const BATCH: u64 = 1000;

/// Rays that went wrong and are told about.
const TOLD: usize = 10;

/// How trees and asking everything may differ.
#[derive(Clone, Copy)]
enum Kind {
    /// Another element, distance or place on it.
    Nearest,
    /// A shadow ray is not stopped by what is hit, or by nothing.
    Occluded,
    /// A shadow ray that ends exactly at what is hit.
    EndsAtHit,
    /// One that ends before it is stopped.
    EndsBefore,
}

const KINDS: [&str; 4] = ["nearest", "occluded", "occluded to the hit itself", "occluded before the hit"];

/// The counts and words of some scenes.
#[derive(Default)]
struct Report {
    tally: Tally,
    kinds: [u64; 4],
    told: Vec<String>,
}

impl Report {
    fn join(mut self, other: Report) -> Report {
        self.told.extend(other.told);
        let kinds = std::array::from_fn(|i| self.kinds[i] + other.kinds[i]);
        Report { tally: self.tally.join(other.tally), kinds, told: self.told }
    }
}

pub(super) fn agreement(effort: &Effort) -> Found {
    let scenes = effort.rays.div_ceil(BATCH);
    let report = (0..scenes)
        .into_par_iter()
        .map(|number| one_scene(2200 << 32 | number, BATCH.min(effort.rays - number * BATCH)))
        .reduce(Report::default, Report::join);
    let mut found = Found::default();
    let kinds = KINDS.iter().zip(report.kinds).filter(|(_, count)| *count > 0);
    found.remarks.extend(kinds.map(|(kind, count)| format!("{kind}: {count} times")));
    found.remarks.extend(report.told.into_iter().take(TOLD));
    found.add(None, &[LOOKAT], &[report.tally]);
    found.add(None, &BOXES, &at_vertices(effort));
    found
}

/// A random scene, and what went wrong with rays in it.
fn one_scene(seed: u64, rays: u64) -> Report {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let world = World::new(&mut random);
    let scene = scene(&world.text);
    let probe = Probe::new(&scene);
    let mut report = Report::default();
    while report.tally.tried < rays {
        let mut ray = world.aimed(&mut random);
        for _ in 0..3 {
            let problem = disagreement(&probe, &ray);
            report.tally.answer(problem.is_none());
            if let Some((kind, told)) = problem {
                report.kinds[kind as usize] += 1;
                if report.told.is_empty() {
                    report.told.push(format!("scene {seed}, o {}, d {}: {told}", ray.o, ray.d));
                }
            }
            // The next one leaves where this one has hit.
            match probe.nearest_by_all(&ray) {
                Some(hit) if chance(&mut random, 0.3) => {
                    ray = probe.leave(&ray, &hit, direction(&mut random))
                }
                _ => break,
            }
        }
    }
    report
}

/// How trees and all elements differ about a ray.
fn disagreement(probe: &Probe, ray: &Ray) -> Option<(Kind, String)> {
    let (tree, all) = (probe.nearest(ray), probe.nearest_by_all(ray));
    let name = |hit: &Hit| (hit.element, hit.t.to_bits(), hit.barycentric.map(f64::to_bits));
    if tree.as_ref().map(name) != all.as_ref().map(name) {
        return Some((Kind::Nearest, format!("tree {tree:?}, all {all:?}")));
    }
    if probe.occluded(ray) != all.is_some() {
        return Some((Kind::Occluded, format!("all {all:?}")));
    }
    let all = all?;
    if !probe.occluded(&Ray { t_max: all.t, ..*ray }) {
        return Some((Kind::EndsAtHit, format!("{all:?}")));
    }
    let before = probe.occluded(&Ray { t_max: all.t.next_down(), ..*ray });
    before.then(|| (Kind::EndsBefore, format!("{all:?}")))
}

const BOXES: [&str; 5] = [
    "min and max f32",
    "min and max f32, box grown",
    "pbrt-v3 padding f32",
    "Ize padding f32",
    "min and max f32, flat boxes",
];

/// Rays at vertices of triangles that they truly meet, against the boxes of these.
fn at_vertices(effort: &Effort) -> [Tally; 5] {
    tally(effort.rays, 2201, |random, tallies: &mut [Tally; 5]| {
        let far = if chance(random, 0.5) { 1e3 } else { 0.0 };
        let place = direction(random) * far;
        let mut triangle: [[f32; 3]; 3] = std::array::from_fn(|_| single(place + direction(random)));
        let flat = chance(random, 0.5);
        if flat {
            let (axis, level) = (below(random, 3), triangle[0]);
            triangle.iter_mut().for_each(|p| p[axis] = level[axis]);
        }
        let o = single(place + direction(random) * 3.0);
        let d = single((double(triangle[below(random, 3)]) - double(o)).normalize());
        if !pierces(o, d, &triangle) {
            return;
        }
        let bounds = bounds(&triangle);
        let plain = slab::min_max(bounds, o, d, 1.0);
        tallies[0].answer(plain);
        tallies[1].answer(slab::min_max(slab::grown(bounds), o, d, 1.0));
        tallies[2].answer(slab::min_max(bounds, o, d, slab::pbrt_pad()));
        tallies[3].answer(slab::min_max(bounds, o, d, slab::IZE_PAD));
        if flat {
            tallies[4].answer(plain);
        }
    })
}

fn bounds(triangle: &[[f32; 3]; 3]) -> Box32 {
    let fold = |pick: fn(f32, f32) -> f32| {
        std::array::from_fn(|axis| triangle.iter().map(|p| p[axis]).reduce(pick).unwrap_or(f32::NAN))
    };
    [fold(f32::min), fold(f32::max)]
}

/// Whether the line through `o` truly passes inside the triangle, in front of `o`.
fn pierces(o: [f32; 3], d: [f32; 3], triangle: &[[f32; 3]; 3]) -> bool {
    let (o, d) = (Wide::new(double(o)), Wide::new(double(d)));
    let [a, b, c] = triangle.map(|p| Wide::new(double(p)).minus(o));
    let zero = TwoFloat::from(0.0);
    let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| p.cross(q).dot(d));
    let normal = b.minus(a).cross(c.minus(a));
    let ahead = normal.dot(a) * normal.dot(d) > zero;
    ahead && (sides.iter().all(|side| *side > zero) || sides.iter().all(|side| *side < zero))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_knows_inside_from_outside_and_front_from_back() {
        let triangle = [[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [0.0, 1.0, 2.0]];
        assert!(pierces([0.0; 3], [0.0, 0.0, 1.0], &triangle));
        assert!(pierces([0.0, 0.0, 4.0], [0.0, 0.0, -1.0], &triangle));
        assert!(!pierces([0.0; 3], [0.0, 0.0, -1.0], &triangle));
        assert!(!pierces([0.0; 3], [0.6, 0.0, 1.0], &triangle));
        assert_eq!(bounds(&triangle), [[-1.0, -1.0, 2.0], [1.0, 1.0, 2.0]]);
    }

    /// Most aimed rays meet something, so that there is something to compare.
    #[test]
    fn rays_hit() {
        let (mut hits, mut tried) = (0, 0);
        for seed in 0..20 {
            let mut random = Pcg64Mcg::seed_from_u64(seed);
            let world = World::new(&mut random);
            let scene = scene(&world.text);
            let probe = Probe::new(&scene);
            for _ in 0..100 {
                hits += usize::from(probe.nearest_by_all(&world.aimed(&mut random)).is_some());
                tried += 1;
            }
        }
        assert!(hits * 2 > tried, "{hits} of {tried}");
    }
}
