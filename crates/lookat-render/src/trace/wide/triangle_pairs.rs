//! Tests of rays against triangles in `f64`: eight pairs of a ray and a triangle side by side.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};

use super::pairs::Pairs;
use super::{Traced, WideTracer};
use crate::bvh::not_less;
use crate::cutout::CutoutPoints;
use crate::number::{LANES, Vec3x8, bits, set_bits, set_lanes, vectorized};
use crate::ray::Hit;
use crate::triangle::{holds_end, sheared::ShearedRays};

/// Pairs of a ray and the place of a triangle in the group.
pub(super) type TrianglePairs = Pairs<u32>;

/// The pairs of which the ray hits the triangle.
pub(super) struct PairHits<S: Simd> {
    pub met: mask64x8<S>,
    pub t: f64x8<S>,
    /// The weights of the corners, in their order in [`Triangle::corners`](crate::triangle::Triangle::corners).
    pub weights: [f64x8<S>; 3],
}

impl TrianglePairs {
    #[inline(always)]
    pub fn intersect<S: Simd>(&self, traced: &Traced<S>) -> PairHits<S> {
        let Traced { simd, group, rays, .. } = *traced;
        let mut corners = [[[1.0_f64; LANES]; 3]; 3];
        for (lane, place) in self.others().enumerate() {
            for (numbers, v) in corners.iter_mut().zip(&group.triangle(place).corners) {
                [numbers[0][lane], numbers[1][lane], numbers[2][lane]] = (*v).into();
            }
        }
        let ([o, d], active) = (self.lines(simd, rays), self.lanes(simd));
        let corners = Vec3x8::three(simd, &corners);
        let (met, t, sides) = ShearedRays::new(o, d, active).intersect(simd, &corners, active);
        let sum = sides[0] + sides[1] + sides[2];
        PairHits { met, t, weights: [sides[0] / sum, sides[1] / sum, sides[2] / sum] }
    }

    /// The hit of a pair.
    #[inline(always)]
    pub fn hit<S: Simd>(&self, traced: &Traced<S>, hits: &PairHits<S>, lane: usize) -> Hit {
        let (ray, place) = self.pair(lane);
        let triangle = traced.group.triangle(place);
        let barycentric = triangle.first_two(|corner| hits.weights[corner][lane]);
        Hit { t: hits.t[lane], element: triangle.element(traced.instances[ray]), barycentric, place }
    }
}

impl WideTracer {
    /// Tests the pairs with triangles that may have holes. Returns the rays that hit them where there is none.
    #[inline(never)]
    pub(super) fn test_cut_out<S: Simd, const ANY: bool>(&mut self, traced: &Traced<S>) -> u64 {
        let Traced { simd, scene, group, rays, is_shadow, .. } = *traced;
        let (pairs, mut met) = (self.cut_out_pairs.take(), 0_u64);
        vectorized!(simd, {
            let found = pairs.intersect(traced);
            let nearer = set_lanes(found.met).filter(|lane| {
                let (ray, _) = pairs.pair(*lane);
                found.t[*lane] <= self.end(traced, ray)
            });
            let nearer = nearer.fold(0_u64, |nearer, lane| nearer | 1 << lane);
            if nearer == 0 {
                return 0;
            }
            let (mut barycentric, mut triangles) = ([[0.0; LANES]; 2], [0; LANES]);
            let mut primitives = [scene.primitive(group.triangle(pairs.pair(0).1).primitive); LANES];
            for lane in set_bits(nearer) {
                let Hit { element, barycentric: [b0, b1], .. } = pairs.hit(traced, &found, lane);
                (barycentric[0][lane], barycentric[1][lane]) = (b0, b1);
                (triangles[lane], primitives[lane]) = (element.index, scene.primitive(element.primitive));
            }
            let barycentric = [barycentric[0].simd_into(simd), barycentric[1].simd_into(simd)];
            let points = CutoutPoints { primitives, triangles, barycentric, is_shadow };
            for lane in set_lanes(points.solid(bits(simd, nearer))) {
                let ((ray, place), hit) = (pairs.pair(lane), &pairs.hit(traced, &found, lane));
                if ANY {
                    let own = self.single(traced, ray);
                    let is_end = own.may_end_at(hit.t) && holds_end(&own, &group.triangle(place).corners);
                    met |= u64::from(!is_end) << ray;
                } else if self.hits.replace(ray, rays.t_max[ray], hit) {
                    self.limit[ray] = self.limit[ray].min(not_less(hit.t));
                }
            }
            met
        })
    }
}
