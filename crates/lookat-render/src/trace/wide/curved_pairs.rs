//! Tests of rays against curved shapes: eight pairs of a ray and a whole sphere side by side, others one by one.

use fearless_simd::{Simd, f64x8, prelude::*};

use super::{MOST_RAYS, Traced, WideTracer};
use crate::curved::Curved;
use crate::curved::sphere::{Meetings, meet_whole};
use crate::number::{LANES, Vec3x8, bits, first_lanes, set_lanes, vectorized};
use crate::ray::{ElementId, Hit, NEAR_END};
use crate::trace::rays::{PLACES, POINT_LIGHT};
use crate::traceable::NonTriangle;

/// Fewer pairs are tested one by one.
const FEW: usize = 3;

/// Pairs of a ray and a curved shape that wait for their tests.
pub(super) struct CurvedPairs {
    rays: [u8; LANES],
    /// The shapes, among all primitives and among the curved shapes.
    shapes: [(u32, u32); LANES],
    pub count: usize,
}

impl CurvedPairs {
    pub fn new() -> Self {
        CurvedPairs { rays: [0; LANES], shapes: [(0, 0); LANES], count: 0 }
    }
}

/// A vector transformed by the matrix of these columns.
#[inline(always)]
fn of_columns<S: Simd>(v: Vec3x8<S>, [x, y, z]: [Vec3x8<S>; 3]) -> Vec3x8<S> {
    x * v.x + y * v.y + z * v.z
}

impl WideTracer {
    /// Lets a pair of a ray and a curved shape wait for its test. Returns the rays that hit their shapes, once there are eight pairs.
    #[inline(always)]
    pub(super) fn push_curved<S: Simd, const ANY: bool>(
        &mut self,
        traced: &Traced<S>,
        ray: usize,
        shape: (u32, u32),
    ) -> u64 {
        let pairs = &mut self.curved_pairs;
        let at = pairs.count % LANES;
        (pairs.rays[at], pairs.shapes[at]) = (ray as u8, shape);
        pairs.count = at + 1;
        if pairs.count == LANES { self.test_curved::<S, ANY>(traced) } else { 0 }
    }

    /// Tests the pairs that wait. Returns the rays that hit their shapes.
    #[inline(never)]
    pub(super) fn test_curved<S: Simd, const ANY: bool>(&mut self, traced: &Traced<S>) -> u64 {
        let Traced { simd, scene, rays, instances, .. } = *traced;
        let count = std::mem::take(&mut self.curved_pairs.count);
        let mut met = 0;
        vectorized!(simd, {
            let mut doubtful = first_lanes(simd, count);
            if count >= FEW {
                let mut numbers = [[1.0; LANES]; 20];
                let (mut leaving, mut active, mut others) = (0, 0, 0);
                for lane in 0..count {
                    let ray = usize::from(self.curved_pairs.rays[lane]) % MOST_RAYS;
                    let (primitive, shape) = self.curved_pairs.shapes[lane];
                    let curved = &scene.curved[shape as usize];
                    let label = scene.labels.of(ElementId { instance: instances[ray], primitive, index: 0 });
                    let in_world = instances[ray] == ElementId::WORLD;
                    let is_left = rays.leaving[ray] == PLACES + label
                        && rays.leaving_instance[ray] == f64::from(instances[ray]);
                    leaving |= u64::from(is_left) << lane;
                    let Some(sphere) = curved.as_sphere().filter(|sphere| sphere.is_whole()) else {
                        others |= 1 << lane;
                        continue;
                    };
                    active |= u64::from(!(ANY && in_world && rays.target[ray] == label)) << lane;
                    let ([o, d], Curved { center, own_from_world: m, .. }) = (rays.line(ray), curved);
                    let vectors = [o, d, *center, m.x_axis, m.y_axis, m.z_axis];
                    for (numbers, v) in numbers.as_chunks_mut::<3>().0.iter_mut().zip(vectors) {
                        (numbers[0][lane], numbers[1][lane], numbers[2][lane]) = v.into();
                    }
                    numbers[18][lane] = sphere.radius;
                    numbers[19][lane] = self.hits.nearest(ray).map_or(rays.t_max[ray], |hit| hit.t);
                }
                let [o, d, center, x, y, z] = [0, 3, 6, 9, 12, 15].map(
                    #[inline(always)]
                    |at| Vec3x8::from_arrays(simd, &[numbers[at], numbers[at + 1], numbers[at + 2]]),
                );
                let (o, d) = (of_columns(o - center, [x, y, z]), of_columns(d, [x, y, z]));
                let (radius, t_max): (f64x8<S>, f64x8<S>) =
                    (numbers[18].simd_into(simd), numbers[19].simd_into(simd));
                let found = meet_whole(radius, (o, d), t_max, bits(simd, leaving), bits(simd, active));
                let Meetings { met: certain, t, .. } = found;
                doubtful = found.doubtful | bits(simd, others);
                for lane in set_lanes(certain & !doubtful) {
                    let ray = usize::from(self.curved_pairs.rays[lane]) % MOST_RAYS;
                    if ANY && rays.target[ray] == POINT_LIGHT && t[lane] > rays.t_max[ray] * NEAR_END {
                        doubtful |= bits(simd, 1 << lane);
                        continue;
                    }
                    let (primitive, _) = self.curved_pairs.shapes[lane];
                    let element = ElementId { instance: instances[ray], primitive, index: 0 };
                    let hit = Hit { t: t[lane], element, barycentric: [0.0; 2], place: Hit::NO_PLACE };
                    met |= u64::from(self.accept::<S, ANY>(traced, ray, hit)) << ray;
                }
            }
            for lane in set_lanes(doubtful) {
                let ray = usize::from(self.curved_pairs.rays[lane]) % MOST_RAYS;
                let (primitive, shape) = self.curved_pairs.shapes[lane];
                let other = NonTriangle::Curved { primitive, shape };
                met |= u64::from(self.test_non_triangle::<S, ANY>(traced, ray, other)) << ray;
            }
        });
        met
    }

    /// Records a hit if it is nearer than what is decided, and no hole. True if it does.
    fn accept<S: Simd, const ANY: bool>(&mut self, traced: &Traced<S>, ray: usize, found: Hit) -> bool {
        self.test_exactly::<S, ANY>(traced, ray, |query, hit| traced.scene.accept::<ANY>(query, found, hit))
    }
}
