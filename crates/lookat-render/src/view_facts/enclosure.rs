//! Whether a point is inside a closed shape.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::DVec3;

use super::shapes::key;
use crate::ray::Ray;
use crate::surface::Surface;
use crate::traceable::Traceable;

/// Rays in all directions.
const RAYS: u32 = 64;
/// The most surfaces along a ray.
const MOST_HITS: usize = 64;

/// The closed shape around a point, relative to the origin: the one that rays in all directions meet an odd number of times, and of
/// several the one that they leave first. `except` does not count.
pub(super) fn around(traceable: &Traceable, p: DVec3, except: Option<(u32, u32)>) -> Option<(u32, u32)> {
    // Of each shape how many rays meet it an odd number of times, and the sum of the distances at which they do first.
    let mut odd: BTreeMap<(u32, u32), (u32, f64)> = BTreeMap::new();
    for i in 0..RAYS {
        let mut met: BTreeMap<(u32, u32), (u32, f64)> = BTreeMap::new();
        let mut ray = Ray::new(p, direction(i));
        for _ in 0..MOST_HITS {
            let Some(hit) = traceable.nearest(&ray) else { break };
            let surface = Surface::new(traceable, &ray, &hit);
            let distance = surface.p.distance(p);
            met.entry(key(surface.element)).or_insert((0, distance)).0 += 1;
            ray = surface.leave(ray.d);
        }
        let is_odd = |(key, (count, _)): &((u32, u32), (u32, f64))| Some(*key) != except && count % 2 == 1;
        for (key, (_, distance)) in met.into_iter().filter(is_odd) {
            let entry = odd.entry(key).or_default();
            *entry = (entry.0 + 1, entry.1 + distance);
        }
        // Most points are outside of everything.
        if odd.values().all(|(count, _)| *count <= i) {
            return None;
        }
    }
    let closed = odd.into_iter().filter(|(_, (count, _))| *count == RAYS);
    // Of equals, the first.
    closed.min_by(|(_, (_, a)), (_, (_, b))| a.total_cmp(b)).map(|(key, _)| key)
}

/// Directions that cover the sphere evenly (a Fibonacci lattice).
fn direction(i: u32) -> DVec3 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(RAYS);
    let (sin, cos) = (libm::sin(TAU * GOLDEN * f64::from(i)), libm::cos(TAU * GOLDEN * f64::from(i)));
    let radius = (1.0 - z * z).sqrt();
    DVec3::new(radius * cos, radius * sin, z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::Prepared;
    use crate::ray::ElementId;
    use crate::testing::scene;

    #[test]
    fn of_shapes_in_one_place_the_first_is_around() {
        let boxes = "Shape \"trianglemesh\" \"point P\" [-1 -1 -1 3 -1 -1 -1 3 -1 -1 -1 3]
            \"integer indices\" [0 2 1 0 1 3 0 3 2 1 2 3]"
            .repeat(4);
        let scene = scene(&format!(
            "Film \"image\" Camera \"perspective\" WorldBegin Translate 9 9 9 {boxes} WorldEnd"
        ));
        let traceable = Prepared::new(&scene).traceable;
        let p = DVec3::splat(9.0) - traceable.origin;
        assert_eq!(around(&traceable, p, None), Some((ElementId::WORLD, 0)));
    }
}
