//! Cubic Bézier curves, one or eight side by side: points, parts, and views along rays.

use crate::number::V3;
use crate::real::Real;

/// Control points.
pub(super) type Points<T> = [V3<T>; 4];

#[inline(always)]
fn lerp<T: Real>(a: V3<T>, b: V3<T>, u: T) -> V3<T> {
    a * (u.same(1.0) - u) + b * u
}

/// A point of the curve and the derivative there. Where that vanishes, the way from end to end stands in.
#[inline(always)]
pub(super) fn evaluate<T: Real>(points: &Points<T>, u: T) -> [V3<T>; 2] {
    let [a, b, c, d] = *points;
    let (ab, bc, cd) = (lerp(a, b, u), lerp(b, c, u), lerp(c, d, u));
    let (abc, bcd) = (lerp(ab, bc, u), lerp(bc, cd, u));
    let derivative = (bcd - abc) * u.same(3.0);
    let is_zero = derivative.length_squared().is_at_most(u.same(0.0));
    [lerp(abc, bcd, u), V3::select(is_zero, d - a, derivative)]
}

/// The control points of the part between two parameters, by blossoming.
#[inline(always)]
pub(super) fn subcurve<T: Real>(points: &Points<T>, [from, to]: [T; 2]) -> Points<T> {
    let [a, b, c, d] = *points;
    let [[ab, bc, cd], [to_ab, to_bc, to_cd]] = [
        [lerp(a, b, from), lerp(b, c, from), lerp(c, d, from)],
        [lerp(a, b, to), lerp(b, c, to), lerp(c, d, to)],
    ];
    let (first, second) = (lerp(ab, bc, from), lerp(bc, cd, from));
    let (to_first, to_second) = (lerp(to_ab, to_bc, to), lerp(to_bc, to_cd, to));
    [
        lerp(first, second, from),
        lerp(first, second, to),
        lerp(lerp(ab, bc, to), lerp(bc, cd, to), to),
        lerp(to_first, to_second, to),
    ]
}

/// Space as seen along a ray, from its start: axes of length one, z along the ray.
pub(super) struct View<T> {
    pub o: V3<T>,
    pub x: V3<T>,
    pub y: V3<T>,
    pub z: V3<T>,
    /// The length of the ray's direction.
    pub length: T,
}

impl<T: Real> View<T> {
    /// The view along the ray from `o` along `d`, with `along` about in the direction of x; and whether there is one: not if `along` is in
    /// the direction of the ray.
    #[inline(always)]
    pub fn new(o: V3<T>, d: V3<T>, along: V3<T>) -> (Self, T::Mask) {
        let length = d.length_squared().sqrt();
        let z = d / length;
        let across = z.cross(along);
        let inverse = length.same(1.0) / across.length_squared().sqrt();
        let is_possible = inverse.is_less(length.same(f64::INFINITY)) & length.same(0.0).is_less(inverse);
        let y = across * inverse;
        (View { o, x: y.cross(z), y, z, length }, is_possible)
    }

    #[inline(always)]
    pub fn see(&self, p: V3<T>) -> V3<T> {
        let p = p - self.o;
        V3 { x: self.x.dot(p), y: self.y.dot(p), z: self.z.dot(p) }
    }

    #[inline(always)]
    pub fn see_all(&self, [a, b, c, d]: Points<T>) -> Points<T> {
        [self.see(a), self.see(b), self.see(c), self.see(d)]
    }
}

/// Whether the box around points that a view shows, wider by `reach`, is on the ray, at `z_max` or before.
#[inline(always)]
pub(super) fn may_meet<T: Real>([a, b, c, d]: &Points<T>, reach: T, z_max: T) -> T::Mask {
    let ([low_x, high_x], [low_y, high_y]) = (span([a.x, b.x, c.x, d.x]), span([a.y, b.y, c.y, d.y]));
    let [low_z, high_z] = span([a.z, b.z, c.z, d.z]);
    low_y.is_at_most(reach)
        & (-reach).is_at_most(high_y)
        & low_x.is_at_most(reach)
        & (-reach).is_at_most(high_x)
        & reach.same(0.0).is_less(high_z)
        & low_z.is_at_most(z_max)
}

/// The least and the greatest of numbers.
#[inline(always)]
fn span<T: Real>([a, b, c, d]: [T; 4]) -> [T; 2] {
    [a.min(b).min(c.min(d)), a.max(b).max(c.max(d))]
}
