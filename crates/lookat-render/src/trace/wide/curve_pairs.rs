//! Tests of rays against pieces of curves: eight pairs of a ray and a piece side by side.

use fearless_simd::{Simd, prelude::*};

use super::pairs::Pairs;
use super::{Traced, WideTracer};
use crate::curve::side_by_side::PieceHits;
use crate::curved::side_by_side::ShapeRays;
use crate::number::{LANES, bits, set_lanes, vectorized};
use crate::ray::{ElementId, Hit};
use crate::trace::rays::PLACES;
use crate::traceable::NonTriangle;

/// A piece of a curve.
#[derive(Clone, Copy)]
pub(super) struct CurvePiece {
    pub primitive: u32,
    pub piece: u32,
}

/// Pairs of a ray and a piece of a curve that wait for their tests.
#[derive(Clone, Copy)]
pub(super) struct CurvePairs {
    /// Those that may pass each other.
    any: Pairs<CurvePiece>,
    /// Those that come near each other.
    near: Pairs<CurvePiece>,
}

impl CurvePairs {
    pub const NONE: CurvePairs = {
        let none = Pairs::none(CurvePiece { primitive: 0, piece: 0 });
        CurvePairs { any: none, near: none }
    };
}

impl WideTracer {
    /// Lets a pair of a ray and a piece of a curve wait for its test. Returns the rays that hit their pieces, once there are eight pairs.
    #[inline(always)]
    pub(super) fn push_curve<S: Simd, const ANY: bool>(
        &mut self,
        traced: &Traced<S>,
        ray: usize,
        piece: CurvePiece,
    ) -> u64 {
        if self.curve_pairs.any.push(ray, piece) { self.find_near::<S, ANY>(traced) } else { 0 }
    }

    /// Tests all pairs that wait. Returns the rays that hit their pieces.
    #[inline(always)]
    pub(super) fn test_all_curves<S: Simd, const ANY: bool>(&mut self, traced: &Traced<S>) -> u64 {
        let mut met = 0;
        if self.curve_pairs.any.len() > 0 {
            met |= self.find_near::<S, ANY>(traced);
        }
        if self.curve_pairs.near.len() > 0 {
            met |= self.test_near::<S, ANY>(traced);
        }
        met
    }

    /// The rays of pairs.
    #[inline(always)]
    fn rays_of_curves<S: Simd>(&self, traced: &Traced<S>, pairs: &Pairs<CurvePiece>) -> ShapeRays<S> {
        let Traced { simd, scene, rays, instances, .. } = *traced;
        let (mut t_max, mut leaving) = ([1.0; LANES], 0);
        for (lane, t_max) in t_max.iter_mut().enumerate().take(pairs.len()) {
            let (ray, CurvePiece { primitive, .. }) = pairs.pair(lane);
            *t_max = self.end(traced, ray);
            let (left, instance) = (rays.leaving[ray], instances[ray]);
            let is_left = left >= PLACES
                && rays.leaving_instance[ray] == instance
                && scene.labels.element(left - PLACES, instance).primitive == primitive;
            leaving |= u64::from(is_left) << lane;
        }
        let ([o, d], active) = (pairs.lines(simd, rays), pairs.lanes(simd));
        ShapeRays { o, d, t_max: t_max.simd_into(simd), leaving: bits(simd, leaving), active }
    }

    /// Lets the pairs wait that come near each other. Returns the rays that hit their pieces.
    #[inline(never)]
    fn find_near<S: Simd, const ANY: bool>(&mut self, traced: &Traced<S>) -> u64 {
        let (pairs, mut met) = (self.curve_pairs.any.take(), 0);
        vectorized!(traced.simd, {
            let rays = self.rays_of_curves(traced, &pairs);
            let near = traced.scene.curves.near(&rays, pairs.others().map(|it| it.piece));
            for lane in set_lanes(near) {
                let (ray, piece) = pairs.pair(lane);
                traced.scene.curves.prefetch_segment(piece.piece);
                if self.curve_pairs.near.push(ray, piece) {
                    met |= self.test_near::<S, ANY>(traced);
                }
            }
        });
        met
    }

    /// Tests the pairs that come near each other. Returns the rays that hit their pieces.
    #[inline(never)]
    fn test_near<S: Simd, const ANY: bool>(&mut self, traced: &Traced<S>) -> u64 {
        let Traced { simd, scene, instances, .. } = *traced;
        let (pairs, mut met) = (self.curve_pairs.near.take(), 0);
        vectorized!(simd, {
            let rays = self.rays_of_curves(traced, &pairs);
            let PieceHits { met: certain, t, uv, doubtful } =
                scene.curves.meet_all(&rays, pairs.others().map(|it| it.piece));
            for lane in set_lanes(certain) {
                let (ray, CurvePiece { primitive, piece }) = pairs.pair(lane);
                let element = ElementId { instance: instances[ray], primitive, index: piece };
                let barycentric = [uv[0][lane], uv[1][lane]];
                let hit = Hit { t: t[lane], element, barycentric, place: Hit::NO_PLACE };
                met |= u64::from(self.accept::<S, ANY>(traced, ray, hit)) << ray;
            }
            for lane in set_lanes(doubtful) {
                let (ray, CurvePiece { primitive, piece }) = pairs.pair(lane);
                let other = NonTriangle::Curve { primitive, piece };
                met |= u64::from(self.test_non_triangle::<S, ANY>(traced, ray, other)) << ray;
            }
        });
        met
    }
}
