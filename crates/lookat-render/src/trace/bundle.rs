//! Rays that are traced together. They share the way down the tree, and are tested one by one where it ends.

use super::nothing;
use crate::ray::{ElementId, Hit, Ray};
use crate::traceable::Traceable;

/// So many rays are traced together. More would seldom be left of the samples of a pass.
pub const BUNDLE: usize = 4;

/// They stay together for no more leaves than that: with more they are faster one by one.
pub(super) const MOST_LEAVES: u32 = 8;

/// What is no block of triangles counts as so many leaves.
pub(super) const OTHER: u32 = 4;

impl Traceable {
    /// The nearest hits of several rays that go down the tree together, as far as they run side by side; and whether they
    /// did all the way.
    pub fn nearest_of(&self, rays: &[Ray; BUNDLE]) -> ([Option<Hit>; BUNDLE], bool) {
        let mut hits = rays.each_ref().map(nothing);
        let queries = rays.each_ref().map(|ray| self.query(ray, false));
        let way = rays[0].d.is_negative_bitmask();
        let together = self.is_cheap
            && rays.iter().all(|ray| ray.d.is_negative_bitmask() == way && ray.d.is_finite())
            && self.search_wide::<false, _>(&queries, &mut hits).is_complete;
        if !together {
            for (query, hit) in queries.into_iter().zip(&mut hits) {
                self.search::<false>(query, hit);
            }
        }
        (hits.map(|hit| (hit.element != ElementId::NONE).then_some(hit)), together)
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use glam::DVec3;
    use lookat_scene::Scene;

    use super::*;
    use crate::testing::{self, noise};

    /// A wavy field, with spheres on it.
    fn scene(shapes: &str) -> Scene {
        let mut heights = String::new();
        for at in 0..50 * 50 {
            let [x, y] = [at % 50, at / 50].map(f64::from);
            let _ = write!(heights, "{:.4} ", 0.1 * (0.7 * x).sin() * (0.4 * y).cos());
        }
        testing::scene(&format!(
            "Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator \"path\" WorldBegin
             Shape \"heightfield\" \"integer nu\" 50 \"integer nv\" 50 \"float Pz\" [{heights}] {shapes} WorldEnd"
        ))
    }

    fn bundle(case: usize) -> [Ray; BUNDLE] {
        let vector = |i, k: f64| DVec3::new(noise(i, k), noise(i, k + 0.3), noise(i, k + 0.7));
        let (o, target) =
            (DVec3::new(0.5, -1.0, 1.5) + vector(case, 1.1) * 0.3, vector(case, 2.9) * 0.5 + 0.5);
        // From rays that are almost one to some that have little in common, from one point or from many.
        let spread = 10_f64.powi(case as i32 % 7 - 6);
        std::array::from_fn(|k| {
            let i = case * BUNDLE + k;
            let o = if case.is_multiple_of(2) { o } else { o + vector(i, 5.1) * spread };
            let d = target.with_z(0.0) + vector(i, 3.7) * spread - o;
            // Sometimes along a plane, and on one side of it or the other; and not always as far as there is something.
            let d = if case.is_multiple_of(5) { d.with_x([0.0, -0.0][case % 2]) } else { d };
            let t_max = if i.is_multiple_of(3) { 2.0 } else { f64::INFINITY };
            Ray { t_max, ..Ray::new(o, d.normalize()) }
        })
    }

    /// What rays meet is the same to the bit, whether they stay together or not.
    #[test]
    fn rays_meet_together_what_they_meet_alone() {
        let spheres =
            "Shape \"sphere\" \"float radius\" .2 Translate .6 .6 0 Shape \"sphere\" \"float radius\" .1";
        let cutout = "Texture \"holes\" \"float\" \"checkerboard\" \"float uscale\" 9 \"float vscale\" 9
            \"float tex1\" 0 \"float tex2\" 1 Translate 0 0 .3 Shape \"trianglemesh\" \"texture alpha\" \"holes\"
            \"point P\" [0 0 0 1 0 0 1 1 0 0 1 0] \"float uv\" [0 0 1 0 1 1 0 1] \"integer indices\" [0 1 2 0 2 3]";
        for shapes in ["", spheres, cutout] {
            let scene = scene(shapes);
            let traceable = crate::Prepared::new(&scene).traceable;
            let (mut met, mut stayed) = (0, [0; 2]);
            for case in 0..4000 {
                let rays = bundle(case);
                let (hits, together) = traceable.nearest_of(&rays);
                stayed[usize::from(together)] += 1;
                for (ray, hit) in rays.iter().zip(hits) {
                    let name = |hit: Hit| {
                        (hit.element, hit.t.to_bits(), hit.barycentric.map(f64::to_bits), hit.place)
                    };
                    assert_eq!(hit.map(name), traceable.nearest(ray).map(name), "{shapes} {ray:?}");
                    met += u32::from(hit.is_some());
                }
            }
            assert!(met > 5_000 && stayed.iter().all(|count| *count > 500), "{met} {stayed:?}");
        }
    }
}
