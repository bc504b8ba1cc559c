//! Tests of rays against curved shapes: eight pairs of a ray and a shape of a kind side by side.

use fearless_simd::{Simd, prelude::*};

use super::{MOST_RAYS, Traced, WideTracer};
use crate::curved::Curved;
use crate::curved::side_by_side::{Kind, ShapeHits, ShapeRays, gather};
use crate::number::{LANES, Vec3x8, bits, first_lanes, set_lanes, vectorized};
use crate::ray::{ElementId, Hit, NEAR_END};
use crate::trace::rays::{PLACES, POINT_LIGHT};
use crate::traceable::NonTriangle;

/// Fewer pairs are tested one by one.
const FEW: usize = 3;

/// Pairs of a ray and a curved shape of a kind that wait for their tests.
#[derive(Clone, Copy)]
pub(super) struct CurvedPairs {
    rays: [u8; LANES],
    /// The shapes, among all primitives and among the curved shapes.
    shapes: [(u32, u32); LANES],
    pub count: usize,
}

impl CurvedPairs {
    /// None of any kind.
    pub const NONE: [CurvedPairs; Kind::COUNT] =
        [CurvedPairs { rays: [0; LANES], shapes: [(0, 0); LANES], count: 0 }; Kind::COUNT];
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
        let kind = traced.scene.curved[shape.1 as usize].kind();
        let pairs = &mut self.curved_pairs[kind as usize];
        let at = pairs.count % LANES;
        (pairs.rays[at], pairs.shapes[at]) = (ray as u8, shape);
        pairs.count = at + 1;
        if pairs.count == LANES { self.test_curved::<S, ANY>(traced, kind) } else { 0 }
    }

    /// Tests all pairs that wait. Returns the rays that hit their shapes.
    #[inline(always)]
    pub(super) fn test_waiting<S: Simd, const ANY: bool>(&mut self, traced: &Traced<S>) -> u64 {
        let mut met = 0;
        for kind in Kind::ALL {
            if self.curved_pairs[kind as usize].count > 0 {
                met |= self.test_curved::<S, ANY>(traced, kind);
            }
        }
        met
    }

    /// Tests the pairs of a kind that wait. Returns the rays that hit their shapes.
    #[inline(never)]
    fn test_curved<S: Simd, const ANY: bool>(&mut self, traced: &Traced<S>, kind: Kind) -> u64 {
        let Traced { simd, scene, rays, instances, .. } = *traced;
        let pairs = self.curved_pairs[kind as usize];
        self.curved_pairs[kind as usize].count = 0;
        let mut met = 0;
        vectorized!(simd, {
            let mut doubtful = first_lanes(simd, pairs.count);
            if pairs.count >= FEW {
                let mut numbers = [[1.0; LANES]; 20];
                let (mut leaving, mut active) = (0, 0);
                let mut shapes = [&scene.curved[pairs.shapes[0].1 as usize]; LANES];
                for lane in 0..pairs.count {
                    let ray = usize::from(pairs.rays[lane]) % MOST_RAYS;
                    let (primitive, shape) = pairs.shapes[lane];
                    let curved = &scene.curved[shape as usize];
                    let label = scene.labels.of(ElementId { instance: instances[ray], primitive, index: 0 });
                    let in_world = instances[ray] == ElementId::WORLD;
                    let is_left =
                        rays.leaving[ray] == PLACES + label && rays.leaving_instance[ray] == instances[ray];
                    leaving |= u64::from(is_left) << lane;
                    active |= u64::from(!(ANY && in_world && rays.target[ray] == label)) << lane;
                    let ([o, d], Curved { center, own_from_world: m, .. }) = (rays.line(ray), curved);
                    let vectors = [o, d, *center, m.x_axis, m.y_axis, m.z_axis];
                    for (numbers, v) in numbers.as_chunks_mut::<3>().0.iter_mut().zip(vectors) {
                        (numbers[0][lane], numbers[1][lane], numbers[2][lane]) = v.into();
                    }
                    numbers[18][lane] = curved.radius();
                    numbers[19][lane] = self.hits.nearest(ray).map_or(rays.t_max[ray], |hit| hit.t);
                    shapes[lane] = curved;
                }
                let [o, d, center, x, y, z] = [0, 3, 6, 9, 12, 15].map(
                    #[inline(always)]
                    |at| Vec3x8::from_arrays(simd, &[numbers[at], numbers[at + 1], numbers[at + 2]]),
                );
                let own = ShapeRays {
                    o: of_columns(o - center, [x, y, z]),
                    d: of_columns(d, [x, y, z]),
                    t_max: numbers[19].simd_into(simd),
                    leaving: bits(simd, leaving),
                    active: bits(simd, active),
                };
                let found = match kind {
                    Kind::WholeSphere => own.meet_whole_spheres(numbers[18].simd_into(simd)),
                    _ => {
                        let columns = gather(&shapes[..pairs.count]);
                        own.meet(
                            kind,
                            #[inline(always)]
                            |at| columns[at].simd_into(simd),
                            false,
                        )
                    }
                };
                let ShapeHits { met: certain, t, .. } = found;
                doubtful = found.doubtful;
                for lane in set_lanes(certain & !doubtful) {
                    let ray = usize::from(pairs.rays[lane]) % MOST_RAYS;
                    if ANY && rays.target[ray] == POINT_LIGHT && t[lane] > rays.t_max[ray] * NEAR_END {
                        doubtful |= bits(simd, 1 << lane);
                        continue;
                    }
                    let (primitive, _) = pairs.shapes[lane];
                    let element = ElementId { instance: instances[ray], primitive, index: 0 };
                    let hit = Hit { t: t[lane], element, barycentric: [0.0; 2], place: Hit::NO_PLACE };
                    met |= u64::from(self.accept::<S, ANY>(traced, ray, hit)) << ray;
                }
            }
            for lane in set_lanes(doubtful) {
                let ray = usize::from(pairs.rays[lane]) % MOST_RAYS;
                let (primitive, shape) = pairs.shapes[lane];
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
