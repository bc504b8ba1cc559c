//! Where curves come closest to the origin: roots of polynomials of degree 5.

use super::bezier::Points;
use crate::number::V3;
use crate::real::Real;

/// A polynomial of degree 5 on 0..1, in Bernstein form.
pub(super) type Quintic<T = f64> = [T; 6];

/// A third of the rate at which the curve comes closer to the origin, times its distance: it goes from more to less than
/// 0 where the distance is least.
#[inline(always)]
pub(super) fn approach<T: Real>(c: &Points<T>) -> Quintic<T> {
    let d = [c[1] - c[0], c[2] - c[1], c[3] - c[2]];
    let [a, b, c, e] = [rates(c[0], &d), rates(c[1], &d), rates(c[2], &d), rates(c[3], &d)];
    [
        a[0],
        (b[0] * 3.0 + a[1] * 2.0) / a[0].same(5.0),
        (c[0] * 3.0 + b[1] * 6.0 + a[2]) / a[0].same(10.0),
        (e[0] + c[1] * 6.0 + b[2] * 3.0) / a[0].same(10.0),
        (e[1] * 2.0 + c[2] * 3.0) / a[0].same(5.0),
        e[2],
    ]
}

/// By how much steps lead from a point towards the origin, times its distance.
#[inline(always)]
fn rates<T: Real>(p: V3<T>, steps: &[V3<T>; 3]) -> [T; 3] {
    [-p.dot(steps[0]), -p.dot(steps[1]), -p.dot(steps[2])]
}

/// Below this length an interval is not halved again: two roots in it are one.
const SHORTEST: f64 = 1e-9;

/// Calls `visit` with each place where the polynomial goes from more to less than 0, the ends included.
///
/// A polynomial has at most as many roots as its coefficients change their signs (Descartes); intervals are halved until
/// there is one change or none.
pub(super) fn falls(g: &Quintic, visit: &mut impl FnMut(f64)) {
    falls_within(g, 0.0, 1.0, visit);
}

fn falls_within(g: &Quintic, from: f64, to: f64, visit: &mut impl FnMut(f64)) {
    let Signs { falls, changes_twice } = Signs::of(g);
    if changes_twice && to - from > SHORTEST {
        let (left, right) = halves(g);
        let middle = 0.5 * (from + to);
        falls_within(&left, from, middle, visit);
        falls_within(&right, middle, to, visit);
    } else if falls {
        visit(from + (to - from) * root(g, true));
    }
}

/// The signs of the coefficients of a polynomial.
pub(super) struct Signs<T: Real> {
    /// It goes from more than 0, or 0, to less than 0, or 0, and is not 0 everywhere. A zero at an end counts as a fall there.
    pub falls: T::Mask,
    /// They change at least twice.
    pub changes_twice: T::Mask,
}

impl<T: Real> Signs<T> {
    #[inline(always)]
    pub fn of(g: &Quintic<T>) -> Self {
        let zero = g[0].same(0.0);
        let (starts, ends) = (zero.is_at_most(g[0]), g[5].is_at_most(zero));
        let none = starts & !starts;
        let (mut is_positive, mut once, mut twice, mut is_zero) = (starts, none, none, !none);
        for (at, x) in g.iter().enumerate().skip(1) {
            let (below, above) = if at == 5 { (ends, !ends) } else { (x.is_less(zero), zero.is_less(*x)) };
            let changes = is_positive & below | !is_positive & above;
            (once, twice) = (once | changes, twice | once & changes);
            is_zero = is_zero & x.is_at_most(zero) & zero.is_at_most(*x);
            is_positive = is_positive & !below | above;
        }
        Signs { falls: starts & ends & !(is_zero & g[0].is_at_most(zero)), changes_twice: twice }
    }
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

/// The root of a polynomial that falls from at least 0 to at most 0: by Newton's method, within an interval that shrinks. `active`: those that
/// do fall.
#[inline(always)]
pub(super) fn root<T: Real>(g: &Quintic<T>, active: T::Mask) -> T {
    let (mut low, mut high) = (g[0].same(0.0), g[0].same(1.0));
    let mut active = active & low.is_less(g[0]);
    let mut at = T::select(active, g[0] / (g[0] - g[5]), low);
    for _ in 0..60 {
        if !T::any(active) {
            break;
        }
        let (value, slope) = value(g, at);
        let is_before = g[0].same(0.0).is_less(value);
        low = T::select(active & is_before, at, low);
        high = T::select(active & !is_before, at, high);
        let newton = at - value / slope;
        let is_last = active & (newton - at).abs().is_at_most(at.same(SMALL_STEP));
        let is_within = low.is_less(newton) & newton.is_less(high);
        let next = T::select(is_within, newton, (low + high) * 0.5);
        let next = T::select(is_last, newton.max(low).min(high), next);
        at = T::select(active, next, at);
        active = active & !is_last;
    }
    at
}

/// The value and slope at `u`.
#[inline(always)]
fn value<T: Real>(g: &Quintic<T>, u: T) -> (T, T) {
    let mut work = *g;
    for level in 0..4 {
        for at in 0..5 - level {
            work[at] = work[at] + (work[at + 1] - work[at]) * u;
        }
    }
    let slope = work[1] - work[0];
    (work[0] + slope * u, slope * 5.0)
}
