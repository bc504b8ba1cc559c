//! Eight rays against pieces of curves, each against its own.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::DVec3;

use super::approach::{Signs, approach, root};
use super::bezier::{View, evaluate, may_meet, subcurve};
use super::capsule::CapsuleNumbers;
use super::segment::{CrossSection, Widths};
use super::{Across, Curves, flat};
use crate::curved::side_by_side::ShapeRays;
use crate::number::{LANES, V3, Vec3x8, bits};

/// Possible hits of rays on pieces of curves.
pub(crate) struct PieceHits<S: Simd> {
    pub met: mask64x8<S>,
    pub t: f64x8<S>,
    /// See [`super::Meeting::uv`].
    pub uv: [f64x8<S>; 2],
    /// The rays that must be tested one by one.
    pub doubtful: mask64x8<S>,
}

/// Numbers of eight pieces.
struct Columns<const N: usize>([[f64; LANES]; N]);

impl<const N: usize> Columns<N> {
    fn new() -> Self {
        Columns([[1.0; LANES]; N])
    }

    #[inline(always)]
    fn set_vector(&mut self, from: usize, lane: usize, v: impl Into<[f64; 3]>) {
        let v: [f64; 3] = v.into();
        for (column, x) in self.0[from..from + 3].iter_mut().zip(v) {
            column[lane] = x;
        }
    }

    #[inline(always)]
    fn number<S: Simd>(&self, simd: S, at: usize) -> f64x8<S> {
        self.0[at].simd_into(simd)
    }

    #[inline(always)]
    fn vector<S: Simd>(&self, simd: S, from: usize) -> Vec3x8<S> {
        V3 { x: self.number(simd, from), y: self.number(simd, from + 1), z: self.number(simd, from + 2) }
    }
}

impl Curves {
    /// The rays that may meet their pieces. `pieces`: at most eight.
    #[inline(always)]
    pub fn near<S: Simd>(&self, rays: &ShapeRays<S>, pieces: impl Iterator<Item = u32>) -> mask64x8<S> {
        let simd = rays.t_max.token();
        let mut columns = Columns::<7>::new();
        for (lane, piece) in pieces.enumerate().take(LANES) {
            let CapsuleNumbers { ends: [a, b], radius } = self.pieces[piece as usize].capsule.numbers();
            columns.set_vector(0, lane, DVec3::from(a));
            columns.set_vector(3, lane, DVec3::from(b));
            columns.0[6][lane] = radius;
        }
        let ends = [columns.vector(simd, 0), columns.vector(simd, 3)];
        let capsules = CapsuleNumbers { ends, radius: columns.number(simd, 6) };
        rays.active & capsules.may_meet(rays.o, rays.d, rays.t_max)
    }

    /// The hits of rays of the world on their pieces, with the bits of [`Curves::meet`], wherever they come [near](Curves::near) these.
    /// `rays.leaving`: those that leave the same curve.
    #[inline(always)]
    pub fn meet_all<S: Simd>(&self, rays: &ShapeRays<S>, pieces: impl Iterator<Item = u32>) -> PieceHits<S> {
        const POINTS: usize = 0;
        const MATRIX: usize = 12;
        const ANCHOR: usize = 21;
        const RANGE: usize = 24;
        const WIDTHS: usize = 26;
        let simd = rays.t_max.token();
        let (mut columns, mut ribbons) = (Columns::<{ WIDTHS + 2 }>::new(), 0);
        for (lane, piece) in pieces.enumerate().take(LANES) {
            let piece = &self.pieces[piece as usize];
            let segment = &self.segments[piece.segment as usize];
            for (at, p) in segment.points.into_iter().enumerate() {
                columns.set_vector(POINTS + 3 * at, lane, DVec3::from(p));
            }
            let matrix = segment.object_from_world();
            columns.set_vector(MATRIX, lane, matrix.x_axis);
            columns.set_vector(MATRIX + 3, lane, matrix.y_axis);
            columns.set_vector(MATRIX + 6, lane, matrix.z_axis);
            columns.set_vector(ANCHOR, lane, segment.anchor);
            let ([from, to], Widths([first, last])) = (piece.range(), &segment.widths);
            for (at, x) in [from, to, *first, *last].into_iter().enumerate() {
                columns.0[RANGE + at][lane] = x;
            }
            ribbons |= u64::from(matches!(segment.cross_section, CrossSection::Ribbon(_))) << lane;
        }
        let range = [columns.number(simd, RANGE), columns.number(simd, RANGE + 1)];
        let own = [
            columns.vector(simd, POINTS),
            columns.vector(simd, POINTS + 3),
            columns.vector(simd, POINTS + 6),
            columns.vector(simd, POINTS + 9),
        ];
        let points = subcurve(&own, range);
        let matrix = [
            columns.vector(simd, MATRIX),
            columns.vector(simd, MATRIX + 3),
            columns.vector(simd, MATRIX + 6),
        ];
        let o = (rays.o - columns.vector(simd, ANCHOR)).by_columns(matrix);
        let (view, is_possible) = View::new(o, rays.d.by_columns(matrix), points[3] - points[0]);
        let seen = view.see_all(points);
        let widths = Widths([columns.number(simd, WIDTHS), columns.number(simd, WIDTHS + 1)]);
        let reach = widths.widest(range) * 0.5;
        let may = may_meet(&seen, reach, rays.t_max * view.length);
        let is_plain = is_possible & !bits(simd, ribbons);
        let mut doubtful = rays.active & !is_plain;
        let may = rays.active & is_plain & may;
        let polynomial = approach(&flat(&seen));
        let Signs { falls, changes_twice } = Signs::of(&polynomial);
        doubtful |= may & changes_twice;
        let falls = may & falls & !changes_twice;
        let at = root(&polynomial, falls);
        let [p, along] = evaluate(&seen, at);
        let (t, u) = (p.z / view.length, range[0] + (range[1] - range[0]) * at);
        let Across { is_met, v } = Across::of(p, along, widths.at(u));
        let met = falls & is_met & t.simd_gt(0.0) & t.simd_le(rays.t_max);
        PieceHits { met: met & !rays.leaving, t, uv: [u, v], doubtful: doubtful | met & rays.leaving }
    }
}
