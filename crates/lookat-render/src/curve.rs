//! Rays against cubic Bézier curves: where the curve, seen along the ray, comes closest to it (PBR 3.7).
//!
//! pbrt-v3 splits a curve until its parts are straight to a twentieth of the width; here the least distances are the roots
//! of a polynomial.

mod approach;
mod bezier;
mod capsule;
mod segment;
pub(crate) mod side_by_side;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use glam::{DVec2, DVec3};
use lookat_scene::Curve;

use crate::number::{V3, prefetch};
use crate::parametric::Parametric;
use crate::ray::Ray;
use crate::real::Real;
use approach::{approach, falls};
use bezier::{Points, View, evaluate, may_meet};
use capsule::Capsule;
use segment::{CrossSection, Part, Segment, Widths};

/// All curves of a scene.
#[derive(Default)]
pub(crate) struct Curves {
    segments: Vec<Segment>,
    pieces: Vec<Piece>,
}

/// The part of a segment that an element of the tree holds. Its control points are computed when a ray comes near it: that takes less time
/// than to fetch them.
struct Piece {
    segment: u32,
    /// Its number in the segment, which has 2^`depth` of them.
    number: u8,
    depth: u8,
    capsule: Capsule,
}

impl Piece {
    /// Its first and last parameter.
    #[inline(always)]
    fn range(&self) -> [f64; 2] {
        range(self.number, self.depth)
    }
}

/// The first and last parameter of one of 2^`depth` pieces.
#[inline(always)]
fn range(number: u8, depth: u8) -> [f64; 2] {
    let (number, parts) = (f64::from(number), f64::from(1_u32 << depth));
    [(number / parts - OVERLAP).max(0.0), ((number + 1.0) / parts + OVERLAP).min(1.0)]
}

/// Pieces overlap by this much of their parameter, so that no ray passes between two.
const OVERLAP: f64 = 1e-9;

/// The hit of a ray on a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Meeting {
    /// Distance in lengths of the ray's direction.
    pub t: f64,
    /// Along the segment, and across the curve; 0 to 1.
    pub uv: DVec2,
}

impl Curves {
    /// The number of pieces.
    pub fn len(&self) -> usize {
        self.pieces.len()
    }

    /// Takes a curve in. Gives the number of each of its pieces, with two corners of the box around it and the largest
    /// coordinate that they were computed from.
    pub fn add(&mut self, curve: &Arc<Curve>, world_origin: DVec3) -> Vec<(u32, [DVec3; 2], f64)> {
        let world_from_object = &curve.world_from_object;
        let origin = curve.segments.first().map_or(DVec3::ZERO, |segment| segment[0]);
        let offset = world_from_object.matrix().w_axis.truncate() - world_origin;
        let anchor = *world_from_object.linear() * origin + offset;
        let magnitude = magnitude(curve, origin, anchor);
        let (count, depth, [width, end]) =
            (curve.segments.len() as f64, curve.split_depth as u8, curve.widths);
        let mut added = Vec::with_capacity(curve.segments.len() << depth);
        for (number, points) in (0..).zip(&curve.segments) {
            let width = |at: u32| width + (end - width) * (f64::from(at) / count);
            let segment = Segment {
                number,
                last: curve.segments.len() as u32 - 1,
                world_from_object: world_from_object.clone(),
                anchor,
                points: points.map(|p| V3::from(p - origin)),
                widths: Widths([width(number), width(number + 1)]),
                cross_section: CrossSection::new(&curve.kind, number),
            };
            for number in 0..1 << depth {
                let part = segment.part(range(number, depth));
                added.push((self.pieces.len() as u32, segment.corners(&part), magnitude));
                let (segment, capsule) = (self.segments.len() as u32, segment.capsule(&part));
                self.pieces.push(Piece { segment, number, depth, capsule });
            }
            self.segments.push(segment);
        }
        added
    }

    /// Asks for the memory of a piece.
    #[inline(always)]
    pub fn prefetch(&self, piece: u32) {
        prefetch(&raw const self.pieces[piece as usize], 0..1);
    }

    /// Asks for the memory of the segment of a piece.
    #[inline(always)]
    pub fn prefetch_segment(&self, piece: u32) {
        prefetch(self.segment(piece), 0..3);
    }

    /// The nearest meeting of a ray with a piece, at more than 0 and at most `t_max`. A ray that leaves the same curve, at
    /// the piece that is given, meets it only where it has been away from it.
    pub fn meet(&self, piece: u32, ray: &Ray, t_max: f64, leaving: Option<u32>) -> Option<Meeting> {
        let piece = &self.pieces[piece as usize];
        if !piece.capsule.numbers().may_meet(ray.o.into(), ray.d.into(), t_max) {
            return None;
        }
        let segment = &self.segments[piece.segment as usize];
        let Part { range, points } = segment.part(piece.range());
        let view = segment.view(ray, points[3] - points[0]);
        let seen = view.see_all(points);
        if !may_meet(&seen, segment.widths.widest(range) * 0.5, t_max * view.length) {
            return None;
        }
        let z = DVec3::from(view.z);
        let mut nearest: Option<Meeting> = None;
        falls(&approach(&flat(&seen)), &mut |at| {
            let [p, along] = evaluate(&seen, at);
            let [p_z, u] = [p.z / view.length, range[0] + (range[1] - range[0]) * at];
            let width = segment.widths.at(u) * segment.facing(u, z);
            let across = Across::of(p, along, width);
            let hit = across.is_met && p_z > 0.0 && p_z <= t_max;
            let inside = || leaving.is_some_and(|left| self.is_inside(&view, (piece.segment, u), left));
            if hit && nearest.is_none_or(|nearest| p_z < nearest.t) && !inside() {
                nearest = Some(Meeting { t: p_z, uv: DVec2::new(u, across.v) });
            }
        });
        nearest
    }

    /// True if a ray that leaves the curve at the piece `left` is, up to a meeting with it, still within half a width of
    /// it: that is where the ray came from, not where it goes to.
    fn is_inside(&self, view: &View<f64>, (index, u): (u32, f64), left: u32) -> bool {
        const STEPS: u32 = 8;
        let Segment { number, last, .. } = self.segments[index as usize];
        let (piece, left) = (&self.pieces[left as usize], self.segment(left));
        let start = f64::from(left.number) + left.nearest(piece.range(), view);
        let end = f64::from(number) + u;
        let steps = STEPS * (1 + left.number.abs_diff(number)).min(STEPS);
        (0..steps).all(|step| {
            let at = start + (end - start) * f64::from(step) / f64::from(steps);
            let own = (at as u32).min(last);
            let (segment, u) = (&self.segments[(index - number + own) as usize], at - f64::from(own));
            let [p, along] = evaluate(&view.see_all(segment.points), u);
            Across::of(p, along, segment.widths.at(u) * (1.0 + 1e-6)).is_met
        })
    }

    /// The segment of a piece.
    fn segment(&self, piece: u32) -> &Segment {
        &self.segments[self.pieces[piece as usize].segment as usize]
    }

    /// The coordinates where a ray of direction `d` has met a curve.
    pub fn parametric(&self, piece: u32, d: DVec3, uv: DVec2) -> Parametric {
        let segment = self.segment(piece);
        let direction = (*segment.object_from_world() * d).normalize_or(DVec3::Z);
        let tangents = segment.tangents(direction, uv);
        let [dpdu, dpdv] = tangents.map(|v| *segment.world_from_object.linear() * v);
        Parametric { uv, dpdu, dpdv, dndu: DVec3::ZERO, dndv: DVec3::ZERO }
    }

    /// The unit normal where a ray has met a curve, on the side of `dpdu` times `dpdv` before the curve was placed.
    pub fn normal(&self, piece: u32, ray: &Ray, uv: DVec2) -> DVec3 {
        let segment = self.segment(piece);
        let object_from_world = *segment.object_from_world();
        let direction = (object_from_world * ray.d).normalize_or(DVec3::Z);
        let [dpdu, dpdv] = segment.tangents(direction, uv);
        let normal = dpdu.normalize_or_zero().cross(dpdv.normalize_or_zero());
        (object_from_world.transpose() * normal).normalize_or(DVec3::Z)
    }
}

/// The largest coordinate that places of a curve are computed from.
fn magnitude(curve: &Curve, origin: DVec3, anchor: DVec3) -> f64 {
    let m = curve.world_from_object.linear();
    let rows = m.x_axis.abs() + m.y_axis.abs() + m.z_axis.abs();
    let own = curve.segments.as_flattened().iter().map(|p| (*p - origin).abs().max_element());
    let widest = curve.widths[0].max(curve.widths[1]);
    (rows * (own.fold(0.0, f64::max) + widest) + anchor.abs()).max_element()
}

/// Control points that a view shows, moved into its plane.
#[inline(always)]
fn flat<T: Real>(seen: &Points<T>) -> Points<T> {
    let [a, b, c, d] = *seen;
    let zero = a.z.same(0.0);
    [V3 { z: zero, ..a }, V3 { z: zero, ..b }, V3 { z: zero, ..c }, V3 { z: zero, ..d }]
}

/// Where a ray passes a curve.
struct Across<T: Real> {
    /// It passes within half a width.
    is_met: T::Mask,
    /// The coordinate across the curve, 0 to 1.
    v: T,
}

impl<T: Real> Across<T> {
    /// For a point of the curve and the derivative there, as the view along the ray shows them.
    #[inline(always)]
    fn of(p: V3<T>, along: V3<T>, width: T) -> Self {
        let distance = (p.x * p.x + p.y * p.y).sqrt();
        let side = p.x * along.y - p.y * along.x;
        let share = distance / width;
        let is_left = side.is_less(side.same(0.0));
        let v = T::select(is_left, share.same(0.5) - share, share.same(0.5) + share);
        Across { is_met: distance.is_at_most(width * 0.5), v }
    }
}
