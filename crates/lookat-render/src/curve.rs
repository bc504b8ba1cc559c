//! Rays against cubic Bézier curves: where the curve, seen along the ray, comes closest to it (PBR 3.7).
//!
//! pbrt-v3 splits a curve until its parts are straight to a twentieth of the width; here the least distances are the roots
//! of a polynomial.

#[cfg(test)]
mod tests;

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};
use lookat_scene::{Curve, CurveKind};

use crate::number::{largest_stretch, prefetch};
use crate::parametric::Parametric;
use crate::ray::Ray;
use crate::warp::at_angle;

/// All curves of a scene.
#[derive(Default)]
pub(crate) struct Curves {
    curves: Vec<PlacedCurve>,
    pieces: Vec<Piece>,
}

/// A curve in its place. Its own space is that of the object, about its first point.
struct PlacedCurve {
    curve: Arc<Curve>,
    /// The origin of the own space, relative to the origin of the world.
    anchor: DVec3,
}

/// The part of a segment that an element of the tree holds. Its control points are computed when a ray comes near it: that takes less time
/// than to fetch them.
struct Piece {
    curve: u32,
    /// Its number in the curve.
    number: u32,
    capsule: Capsule,
}

/// All that is within a radius of a line between two ends, relative to the origin of the world.
struct Capsule {
    ends: [[f32; 3]; 2],
    radius: f32,
}

impl Capsule {
    /// One that holds the hull of points of these `radius`.
    fn around(points: &[DVec3; 4], radius: f64) -> Self {
        let distance = |p: DVec3| nearest_between(points[0] - p, points[3] - p).length();
        let farthest = distance(points[1]).max(distance(points[2]));
        let magnitude = points[0].abs().max(points[3].abs()).max_element();
        let rounding = f64::from(f32::EPSILON) * magnitude;
        let radius = (farthest + radius) * (1.0 + 1e-6) + rounding + f64::from(f32::MIN_POSITIVE);
        Capsule { ends: [points[0], points[3]].map(|p| p.as_vec3().to_array()), radius: radius as f32 }
    }

    /// True if a ray may meet it at `t_max` or before. Never false if it does.
    #[inline(always)]
    fn may_meet(&self, ray: &Ray, t_max: f64) -> bool {
        let (d, radius) = (ray.d, f64::from(self.radius));
        let length_squared = d.length_squared();
        let [(a, a_t), (b, b_t)] = self.ends.map(|end| {
            let to = Vec3::from(end).as_dvec3() - ray.o;
            let t = to.dot(d) / length_squared;
            (to - d * t, t)
        });
        // Seen along the ray.
        let nearest = nearest_between(a, b);
        let reach = radius / length_squared.sqrt();
        // Not a number where the ray is out of range.
        let is_missed = nearest.length_squared() > radius * radius
            || a_t.min(b_t) - reach > t_max
            || a_t.max(b_t) + reach < 0.0;
        !is_missed
    }
}

/// A part of a segment.
#[derive(Clone, Copy)]
struct Part {
    segment: u32,
    /// The first and last parameter.
    range: [f64; 2],
    /// Control points, in the curve's own space.
    points: [DVec3; 4],
}

/// The point nearest to the origin of the line from one end to the other.
#[inline(always)]
fn nearest_between(from: DVec3, to: DVec3) -> DVec3 {
    let along = to - from;
    let share = -from.dot(along) / along.length_squared();
    // It is not a number if the ends are one point.
    from + along * if share > 0.0 { share.min(1.0) } else { 0.0 }
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
        let placed = PlacedCurve::new(curve, world_origin);
        let magnitude = placed.magnitude();
        let count = (curve.segments.len() as u32) << curve.split_depth;
        let mut added = Vec::with_capacity(count as usize);
        for number in 0..count {
            let part = placed.part(number);
            added.push((self.pieces.len() as u32, placed.corners(&part), magnitude));
            let capsule = placed.capsule(&part);
            self.pieces.push(Piece { curve: self.curves.len() as u32, number, capsule });
        }
        self.curves.push(placed);
        added
    }

    /// Asks for the memory of a piece.
    #[inline(always)]
    pub fn prefetch(&self, piece: u32) {
        prefetch(&raw const self.pieces[piece as usize], 0..1);
    }

    /// The nearest meeting of a ray with a piece, at more than 0 and at most `t_max`. A ray that leaves the same curve, at
    /// the piece that is given, meets it only where it has been away from it.
    pub fn meet(&self, piece: u32, ray: &Ray, t_max: f64, leaving: Option<u32>) -> Option<Meeting> {
        let piece = &self.pieces[piece as usize];
        // Two thirds of the rays in the box of a piece pass it.
        if !piece.capsule.may_meet(ray, t_max) {
            return None;
        }
        let placed = &self.curves[piece.curve as usize];
        let part = placed.part(piece.number);
        let Part { segment, range, points } = part;
        let view = placed.view(ray, points[3] - points[0]);
        let seen = points.map(|p| view.see(p));
        if !may_meet(&seen, placed.widest(&part) * 0.5, t_max * view.length) {
            return None;
        }
        let flat = seen.map(|p| p.with_z(0.0));
        let mut nearest: Option<(f64, f64)> = None;
        falls(&approach(&flat), &mut |at| {
            let u = range[0] + (range[1] - range[0]) * at;
            let p = evaluate(&seen, at).0;
            let t = p.z / view.length;
            let width = placed.width(segment, u) * placed.facing(segment, u, view.z);
            let hit = p.truncate().length() <= 0.5 * width && t > 0.0 && t <= t_max;
            let inside = || leaving.is_some_and(|left| self.is_inside(placed, &view, (segment, u), left));
            if hit && nearest.is_none_or(|(_, least)| t < least) && !inside() {
                nearest = Some((at, t));
            }
        });
        let (at, t) = nearest?;
        let u = range[0] + (range[1] - range[0]) * at;
        let width = placed.width(segment, u) * placed.facing(segment, u, view.z);
        let (p, along) = evaluate(&seen, at);
        let side = p.truncate().perp_dot(along.truncate());
        let v = 0.5 + (p.truncate().length() / width).copysign(side);
        Some(Meeting { t, uv: DVec2::new(u, v) })
    }

    /// True if a ray that leaves the curve at the piece `left` is, up to a meeting with it, still within half a width of
    /// it: that is where the ray came from, not where it goes to.
    fn is_inside(&self, placed: &PlacedCurve, view: &View, (segment, u): (u32, f64), left: u32) -> bool {
        const STEPS: u32 = 8;
        let left = self.at(left).1;
        let start = f64::from(left) + placed.nearest(left, view);
        let end = f64::from(segment) + u;
        let steps = STEPS * (1 + left.abs_diff(segment)).min(STEPS);
        (0..steps).all(|step| {
            let at = start + (end - start) * f64::from(step) / f64::from(steps);
            let segment = (at as u32).min(placed.curve.segments.len() as u32 - 1);
            let u = at - f64::from(segment);
            let p = evaluate(&placed.seen(segment, view), u).0;
            p.truncate().length() <= 0.5 * placed.width(segment, u) * (1.0 + 1e-6)
        })
    }

    /// The curve of a piece, and its segment there.
    fn at(&self, piece: u32) -> (&PlacedCurve, u32) {
        let Piece { curve, number, .. } = self.pieces[piece as usize];
        let placed = &self.curves[curve as usize];
        (placed, number >> placed.curve.split_depth)
    }

    /// The coordinates where a ray of direction `d` has met a curve.
    pub fn parametric(&self, piece: u32, d: DVec3, uv: DVec2) -> Parametric {
        let (placed, segment) = self.at(piece);
        let transform = &placed.curve.world_from_object;
        let direction = (*transform.inverse_linear() * d).normalize_or(DVec3::Z);
        let [dpdu, dpdv] = placed.tangents(segment, direction, uv).map(|v| *transform.linear() * v);
        Parametric { uv, dpdu, dpdv, dndu: DVec3::ZERO, dndv: DVec3::ZERO }
    }

    /// The unit normal where a ray has met a curve, on the side of `dpdu` times `dpdv` before the curve was placed.
    pub fn normal(&self, piece: u32, ray: &Ray, uv: DVec2) -> DVec3 {
        let (placed, segment) = self.at(piece);
        let object_from_world = *placed.curve.world_from_object.inverse_linear();
        let direction = (object_from_world * ray.d).normalize_or(DVec3::Z);
        let [dpdu, dpdv] = placed.tangents(segment, direction, uv);
        let normal = dpdu.normalize_or_zero().cross(dpdv.normalize_or_zero());
        (object_from_world.transpose() * normal).normalize_or(DVec3::Z)
    }
}

impl PlacedCurve {
    fn new(curve: &Arc<Curve>, world_origin: DVec3) -> Self {
        let mut placed = PlacedCurve { curve: curve.clone(), anchor: DVec3::ZERO };
        let transform = &curve.world_from_object;
        let offset = transform.matrix().w_axis.truncate() - world_origin;
        placed.anchor = *transform.linear() * placed.origin() + offset;
        placed
    }

    /// The origin of the own space, in the object.
    fn origin(&self) -> DVec3 {
        self.curve.segments.first().map_or(DVec3::ZERO, |segment| segment[0])
    }

    /// The control points of a segment, in the own space.
    fn own_points(&self, segment: u32) -> [DVec3; 4] {
        let origin = self.origin();
        self.curve.segments[segment as usize].map(|p| p - origin)
    }

    /// The part that is a piece.
    fn part(&self, number: u32) -> Part {
        let depth = self.curve.split_depth;
        let parts = 1 << depth;
        let at = number & (parts - 1);
        let share = |at: u32, more: f64| (f64::from(at) / f64::from(parts) + more).clamp(0.0, 1.0);
        let (segment, range) = (number >> depth, [share(at, -OVERLAP), share(at + 1, OVERLAP)]);
        let points = subcurve(&self.own_points(segment), range[0], range[1]);
        Part { segment, range, points }
    }

    /// The box around a piece, relative to the origin of the world: all that is within half a width of it, in object space.
    fn corners(&self, part: &Part) -> [DVec3; 2] {
        let rows = self.curve.world_from_object.linear().transpose();
        let round = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
        let half = round * (0.5 * self.widest(part));
        let [a, b, c, d] = self.placed_points(part);
        [a.min(b).min(c).min(d) - half, a.max(b).max(c).max(d) + half]
    }

    /// The control points of a part, relative to the origin of the world.
    fn placed_points(&self, part: &Part) -> [DVec3; 4] {
        part.points.map(|p| self.anchor + *self.curve.world_from_object.linear() * p)
    }

    /// A capsule that holds a piece.
    fn capsule(&self, part: &Part) -> Capsule {
        let half = 0.5 * self.widest(part) * largest_stretch(self.curve.world_from_object.linear());
        Capsule::around(&self.placed_points(part), half)
    }

    fn magnitude(&self) -> f64 {
        let (m, origin) = (self.curve.world_from_object.linear(), self.origin());
        let rows = m.x_axis.abs() + m.y_axis.abs() + m.z_axis.abs();
        let own = self.curve.segments.as_flattened().iter().map(|p| (*p - origin).abs().max_element());
        let widest = self.curve.widths[0].max(self.curve.widths[1]);
        (rows * (own.fold(0.0, f64::max) + widest) + self.anchor.abs()).max_element()
    }

    /// The width at a place, in object space.
    fn width(&self, segment: u32, u: f64) -> f64 {
        let [first, last] = self.curve.widths;
        let share = (f64::from(segment) + u) / self.curve.segments.len() as f64;
        first + (last - first) * share
    }

    fn widest(&self, part: &Part) -> f64 {
        part.range.map(|u| self.width(part.segment, u)).into_iter().fold(0.0, f64::max)
    }

    /// The share of the width that is seen from a direction: all, except of a ribbon.
    fn facing(&self, segment: u32, u: f64, direction: DVec3) -> f64 {
        match &self.curve.kind {
            CurveKind::Flat | CurveKind::Cylinder => 1.0,
            CurveKind::Ribbon(normals) => ribbon_normal(normals, segment, u).dot(direction).abs(),
        }
    }

    /// The change of the position with u and with v, in object space, as seen from a unit direction. That with v is as long
    /// as the curve is wide there.
    fn tangents(&self, segment: u32, direction: DVec3, uv: DVec2) -> [DVec3; 2] {
        let dpdu = evaluate(&self.curve.segments[segment as usize], uv.x).1;
        let across = match &self.curve.kind {
            CurveKind::Flat => direction.cross(dpdu),
            CurveKind::Cylinder => {
                let axis = dpdu.normalize_or(DVec3::X);
                let (side, turn) = (direction.cross(dpdu), at_angle((0.5 - uv.y) * PI));
                side * turn.x + axis.cross(side) * turn.y
            }
            CurveKind::Ribbon(normals) => ribbon_normal(normals, segment, uv.x).cross(dpdu),
        };
        let width = self.width(segment, uv.x) * self.facing(segment, uv.x, direction);
        [dpdu, across.normalize_or(direction.any_orthonormal_vector()) * width]
    }

    /// The view along a ray, with `along` about in the direction of x.
    fn view(&self, ray: &Ray, along: DVec3) -> View {
        let object_from_world = *self.curve.world_from_object.inverse_linear();
        let o = object_from_world * (ray.o - self.anchor);
        let d = object_from_world * ray.d;
        let length = d.length();
        let z = d / length;
        let y = z.cross(along).try_normalize().unwrap_or_else(|| z.any_orthonormal_vector());
        View { o, x: y.cross(z), y, z, length }
    }

    /// The control points of a segment as a view shows them.
    fn seen(&self, segment: u32, view: &View) -> [DVec3; 4] {
        self.own_points(segment).map(|p| view.see(p))
    }

    /// The place on a segment that is nearest to the start of the ray.
    fn nearest(&self, segment: u32, view: &View) -> f64 {
        let seen = self.seen(segment, view);
        let distance = |u: f64| evaluate(&seen, u).0.length_squared();
        let mut nearest = if distance(0.0) <= distance(1.0) { 0.0 } else { 1.0 };
        falls(&approach(&seen), &mut |u| {
            if distance(u) < distance(nearest) {
                nearest = u;
            }
        });
        nearest
    }
}

/// Space as seen along a ray, from its start: axes of length one, z along the ray.
struct View {
    o: DVec3,
    x: DVec3,
    y: DVec3,
    z: DVec3,
    /// The length of the ray's direction.
    length: f64,
}

impl View {
    fn see(&self, p: DVec3) -> DVec3 {
        let p = p - self.o;
        DVec3::new(self.x.dot(p), self.y.dot(p), self.z.dot(p))
    }
}

/// True if the box around a piece, wider by `reach`, is on the ray.
fn may_meet(seen: &[DVec3; 4], reach: f64, z_max: f64) -> bool {
    let [a, b, c, d] = *seen;
    let (low, high) = (a.min(b).min(c).min(d), a.max(b).max(c).max(d));
    low.y <= reach && high.y >= -reach && low.x <= reach && high.x >= -reach && high.z > 0.0 && low.z <= z_max
}

/// The normal of a ribbon at a place, turned evenly from one given normal to the next; as in pbrt-v3, which takes angles
/// above 90 degrees for 90.
fn ribbon_normal(normals: &[DVec3], segment: u32, u: f64) -> DVec3 {
    let normal = |at: u32| normals.get(at as usize).copied().unwrap_or(DVec3::Z);
    let (from, to) = (normal(segment), normal(segment + 1));
    let angle = libm::acos(from.dot(to).clamp(0.0, 1.0));
    if angle < 1e-6 {
        return from;
    }
    (from * libm::sin((1.0 - u) * angle) + to * libm::sin(u * angle)) / libm::sin(angle)
}

/// A point of the curve and the derivative there. Where that vanishes, the way from end to end stands in.
fn evaluate(points: &[DVec3; 4], u: f64) -> (DVec3, DVec3) {
    let [a, b, c, d] = *points;
    let (ab, bc, cd) = (a.lerp(b, u), b.lerp(c, u), c.lerp(d, u));
    let (abc, bcd) = (ab.lerp(bc, u), bc.lerp(cd, u));
    let derivative = (bcd - abc) * 3.0;
    (abc.lerp(bcd, u), if derivative == DVec3::ZERO { d - a } else { derivative })
}

/// The control points of the part between two parameters, by blossoming.
fn subcurve(points: &[DVec3; 4], from: f64, to: f64) -> [DVec3; 4] {
    let blossom = |u: f64, v: f64, w: f64| {
        let [a, b, c, d] = *points;
        let (ab, bc, cd) = (a.lerp(b, u), b.lerp(c, u), c.lerp(d, u));
        ab.lerp(bc, v).lerp(bc.lerp(cd, v), w)
    };
    [blossom(from, from, from), blossom(from, from, to), blossom(from, to, to), blossom(to, to, to)]
}

/// A polynomial of degree 5 on 0..1, in Bernstein form.
type Quintic = [f64; 6];

/// A third of the rate at which the curve comes closer to the origin, times its distance: it goes from more to less than
/// 0 where the distance is least.
fn approach(c: &[DVec3; 4]) -> Quintic {
    let d = [c[1] - c[0], c[2] - c[1], c[3] - c[2]];
    let dot = |i: usize, j: usize| -c[i].dot(d[j]);
    [
        dot(0, 0),
        (3.0 * dot(1, 0) + 2.0 * dot(0, 1)) / 5.0,
        (3.0 * dot(2, 0) + 6.0 * dot(1, 1) + dot(0, 2)) / 10.0,
        (dot(3, 0) + 6.0 * dot(2, 1) + 3.0 * dot(1, 2)) / 10.0,
        (2.0 * dot(3, 1) + 3.0 * dot(2, 2)) / 5.0,
        dot(3, 2),
    ]
}

/// Below this length an interval is not halved again: two roots in it are one.
const SHORTEST: f64 = 1e-9;

/// Calls `visit` with each place where the polynomial goes from more to less than 0, the ends included.
///
/// A polynomial has at most as many roots as its coefficients change their signs (Descartes); intervals are halved until
/// there is one change or none.
fn falls(g: &Quintic, visit: &mut impl FnMut(f64)) {
    if g.iter().any(|x| *x != 0.0) {
        falls_within(g, 0.0, 1.0, visit);
    }
}

fn falls_within(g: &Quintic, from: f64, to: f64, visit: &mut impl FnMut(f64)) {
    // A zero at an end counts as a fall there.
    let starts = g[0] >= 0.0;
    let ends = g[5] <= 0.0;
    let changes = changes(g, starts, !ends);
    if changes >= 2 && to - from > SHORTEST {
        let (left, right) = halves(g);
        let middle = 0.5 * (from + to);
        falls_within(&left, from, middle, visit);
        falls_within(&right, middle, to, visit);
    } else if starts && ends {
        visit(from + (to - from) * root(g));
    }
}

/// The number of sign changes along the coefficients, for given signs of the first and the last.
fn changes(g: &Quintic, first: bool, last: bool) -> u32 {
    let (mut count, mut positive) = (0, first);
    let mut next = |sign: bool| {
        count += u32::from(sign != positive);
        positive = sign;
    };
    g[1..5].iter().filter(|x| **x != 0.0).for_each(|x| next(*x > 0.0));
    next(last);
    count
}

/// The polynomial over both halves of its interval.
fn halves(g: &Quintic) -> (Quintic, Quintic) {
    let (mut work, mut left, mut right) = (*g, [0.0; 6], [0.0; 6]);
    for level in 0..6 {
        left[level] = work[0];
        right[5 - level] = work[5 - level];
        for at in 0..5 - level {
            work[at] = 0.5 * (work[at] + work[at + 1]);
        }
    }
    (left, right)
}

/// A step of Newton's method squares the error of a simple root: after one this small, nothing is left of it but rounding. At a triple root
/// about 2e-10 is left, far less than a width.
const SMALL_STEP: f64 = 1e-10;

/// The root of a polynomial that falls from at least 0 to at most 0: by Newton's method, within an interval that shrinks.
fn root(g: &Quintic) -> f64 {
    if g[0] == 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    let mut at = g[0] / (g[0] - g[5]);
    for _ in 0..60 {
        let (value, slope) = value(g, at);
        if value > 0.0 {
            low = at;
        } else {
            high = at;
        }
        let newton = at - value / slope;
        if (newton - at).abs() <= SMALL_STEP {
            return newton.clamp(low, high);
        }
        at = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
    }
    at
}

/// The value and slope at `u`.
fn value(g: &Quintic, u: f64) -> (f64, f64) {
    let mut work = *g;
    for level in 0..4 {
        for at in 0..5 - level {
            work[at] += (work[at + 1] - work[at]) * u;
        }
    }
    let slope = work[1] - work[0];
    (work[0] + slope * u, 5.0 * slope)
}
