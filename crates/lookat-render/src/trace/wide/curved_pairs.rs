//! Tests of rays against curved shapes: eight pairs of a ray and a shape of a kind side by side.

use fearless_simd::{Simd, prelude::*};

use super::pairs::Pairs;
use super::{Traced, WideTracer};
use crate::curved::Curved;
use crate::curved::side_by_side::{Kind, ShapeHits, ShapeRays, gather};
use crate::number::{LANES, Vec3x8, bits, set_lanes, vectorized};
use crate::ray::{ElementId, Hit, NEAR_END};
use crate::trace::rays::{PLACES, POINT_LIGHT};
use crate::traceable::NonTriangle;

/// Fewer pairs are tested one by one.
const FEW: usize = 3;

/// A curved shape.
#[derive(Clone, Copy)]
pub(super) struct CurvedShape {
    pub primitive: u32,
    /// Its index among the curved shapes.
    pub shape: u32,
}

/// Pairs of a ray and a curved shape, of each kind.
pub(super) type CurvedPairs = [Pairs<CurvedShape>; Kind::COUNT];

pub(super) const NO_PAIRS: CurvedPairs = [Pairs::none(CurvedShape { primitive: 0, shape: 0 }); Kind::COUNT];

impl WideTracer {
    /// Lets a pair of a ray and a curved shape wait for its test. Returns the rays that hit their shapes, once there are eight pairs.
    #[inline(always)]
    pub(super) fn push_curved<S: Simd, const ANY: bool>(
        &mut self,
        traced: &Traced<S>,
        ray: usize,
        shape: CurvedShape,
    ) -> u64 {
        let kind = traced.scene.curved[shape.shape as usize].kind();
        let is_full = self.curved_pairs[kind as usize].push(ray, shape);
        if is_full { self.test_curved::<S, ANY>(traced, kind) } else { 0 }
    }

    /// Tests all pairs that wait. Returns the rays that hit their shapes.
    #[inline(always)]
    pub(super) fn test_all_curved<S: Simd, const ANY: bool>(&mut self, traced: &Traced<S>) -> u64 {
        let mut met = 0;
        for kind in Kind::ALL {
            if self.curved_pairs[kind as usize].len() > 0 {
                met |= self.test_curved::<S, ANY>(traced, kind);
            }
        }
        met
    }

    /// Tests the pairs of a kind that wait. Returns the rays that hit their shapes.
    #[inline(never)]
    fn test_curved<S: Simd, const ANY: bool>(&mut self, traced: &Traced<S>, kind: Kind) -> u64 {
        let Traced { simd, scene, rays, instances, .. } = *traced;
        let (pairs, mut met) = (self.curved_pairs[kind as usize].take(), 0);
        vectorized!(simd, {
            let mut doubtful = pairs.lanes(simd);
            if pairs.len() >= FEW {
                let mut numbers = [[1.0; LANES]; 14];
                let (mut leaving, mut active) = (0, 0);
                let mut shapes = [&scene.curved[pairs.pair(0).1.shape as usize]; LANES];
                for lane in 0..pairs.len() {
                    let (ray, CurvedShape { primitive, shape }) = pairs.pair(lane);
                    let curved = &scene.curved[shape as usize];
                    let label = scene.labels.of(ElementId { instance: instances[ray], primitive, index: 0 });
                    let in_world = instances[ray] == ElementId::WORLD;
                    let is_left =
                        rays.leaving[ray] == PLACES + label && rays.leaving_instance[ray] == instances[ray];
                    leaving |= u64::from(is_left) << lane;
                    active |= u64::from(!(ANY && in_world && rays.target[ray] == label)) << lane;
                    let Curved { center, own_from_world: m, .. } = curved;
                    let vectors = [*center, m.x_axis, m.y_axis, m.z_axis];
                    for (numbers, v) in numbers.as_chunks_mut::<3>().0.iter_mut().zip(vectors) {
                        (numbers[0][lane], numbers[1][lane], numbers[2][lane]) = v.into();
                    }
                    numbers[12][lane] = curved.radius();
                    numbers[13][lane] = self.end(traced, ray);
                    shapes[lane] = curved;
                }
                let [o, d] = pairs.lines(simd, rays);
                let [center, x, y, z] = [0, 3, 6, 9].map(
                    #[inline(always)]
                    |at| Vec3x8::from_arrays(simd, &[numbers[at], numbers[at + 1], numbers[at + 2]]),
                );
                let own = ShapeRays {
                    o: (o - center).by_columns([x, y, z]),
                    d: d.by_columns([x, y, z]),
                    t_max: numbers[13].simd_into(simd),
                    leaving: bits(simd, leaving),
                    active: bits(simd, active),
                };
                let found = match kind {
                    Kind::WholeSphere => own.meet_whole_spheres(numbers[12].simd_into(simd)),
                    _ => {
                        let columns = gather(&shapes[..pairs.len()]);
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
                    let (ray, CurvedShape { primitive, .. }) = pairs.pair(lane);
                    if ANY && rays.target[ray] == POINT_LIGHT && t[lane] > rays.t_max[ray] * NEAR_END {
                        doubtful |= bits(simd, 1 << lane);
                        continue;
                    }
                    let element = ElementId { instance: instances[ray], primitive, index: 0 };
                    let hit = Hit { t: t[lane], element, barycentric: [0.0; 2], place: Hit::NO_PLACE };
                    met |= u64::from(self.accept::<S, ANY>(traced, ray, hit)) << ray;
                }
            }
            for lane in set_lanes(doubtful) {
                let (ray, CurvedShape { primitive, shape }) = pairs.pair(lane);
                let other = NonTriangle::Curved { primitive, shape };
                met |= u64::from(self.test_non_triangle::<S, ANY>(traced, ray, other)) << ray;
            }
        });
        met
    }
}
