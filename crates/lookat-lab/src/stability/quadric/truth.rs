//! What lines have to do with the shapes, in double-double numbers.

use twofloat::TwoFloat;

use super::{CutShape, Round};
use crate::stability::prelude::*;
use crate::stability::truth::{Wide, quotient};

/// What a ray has to do with a shape.
pub(in crate::stability) struct QuadricTruth {
    /// Whether it hits; `None` where that is too close to tell.
    pub hits: Option<bool>,
    /// The distance of the nearest hit.
    pub nearest: Option<f64>,
}

/// A place where the line meets the surface, uncut.
struct Meeting {
    t: f64,
    /// Whether the shape is there; `None` where that is too close to tell.
    is_there: Option<bool>,
}

impl QuadricTruth {
    pub fn new(shape: &CutShape, o: DVec3, d: DVec3) -> QuadricTruth {
        QuadricTruth::wide(shape, Wide::new(o), Wide::new(d))
    }

    pub fn wide(shape: &CutShape, o: Wide, d: Wide) -> QuadricTruth {
        let Some(places) = places(shape, o, d) else { return QuadricTruth { hits: None, nearest: None } };
        let ahead = || places.iter().filter(|place| place.t > 0.0);
        let nearest = ahead().find(|place| place.is_there == Some(true)).map(|place| place.t);
        let doubt = ahead().any(|place| place.is_there.is_none());
        QuadricTruth { hits: (nearest.is_some() || !doubt).then_some(nearest.is_some()), nearest }
    }
}

/// The distance of what a ray meets that starts at `p` on the shape. Nothing in all where that is too close to tell.
pub(super) fn beyond(shape: &CutShape, p: DVec3, d: DVec3, cos: f64) -> Option<Option<f64>> {
    if cos.abs() < 1e-3 {
        return None;
    }
    if shape.round.is_none() {
        return Some(None);
    }
    let mut places = places(shape, Wide::new(p), Wide::new(d))?;
    // The start is the nearest place.
    places.sort_by(|a, b| a.t.abs().total_cmp(&b.t.abs()));
    let Some(other) = places.get(1).filter(|place| place.t > 0.0) else { return Some(None) };
    (other.t > 1e-9).then_some(())?;
    other.is_there.map(|is_there| is_there.then_some(other.t))
}

/// In order. Nothing where it is too close to tell whether there are any.
fn places(shape: &CutShape, o: Wide, d: Wide) -> Option<Vec<Meeting>> {
    let k = f64::from(-o.dot(d)) / f64::from(d.dot(d));
    let at = |from: Wide, t: TwoFloat| std::array::from_fn(|i| from.0[i] + d.0[i] * t);
    // The coordinates of rays from afar, which cancel, are gone here.
    let near = Wide(at(o, k.into()));
    let ([x, y, z], [dx, dy, dz]) = (near.0, d.0);
    let Some(round) = &shape.round else {
        if dz == 0.0 {
            return Some(Vec::new());
        }
        let offset = -quotient(z, dz);
        return Some(vec![Meeting { t: f64::from(offset + k), is_there: on_disk(&at(near, offset)) }]);
    };
    let Round { profile: [a, s, b], constant: c, .. } = *round;
    let from_s = z - s;
    let alpha = dx * dx + dy * dy - dz * dz * a;
    let beta = dx * x + dy * y - dz * from_s * a - dz * (0.5 * b);
    let gamma = x * x + y * y - from_s * from_s * a - z * b - c;
    let margin = beta * beta - alpha * gamma;
    let size = f64::from(beta * beta).abs() + f64::from(alpha * gamma).abs() + 1e-2;
    // Of double-double numbers, the coordinates of a far origin may cancel.
    let far = f64::from(o.dot(o)) * f64::from(d.dot(d));
    if f64::from(margin).abs() < 1e-28 * size + 1e-30 * far {
        return None;
    }
    if margin < TwoFloat::from(0.0) {
        return Some(Vec::new());
    }
    let root = margin.sqrt();
    let q = if beta < TwoFloat::from(0.0) { root - beta } else { -(root + beta) };
    let mut offsets = vec![quotient(gamma, q)];
    if f64::from(alpha) != 0.0 {
        offsets.push(quotient(q, alpha));
    }
    let place =
        |offset: TwoFloat| Meeting { t: f64::from(offset + k), is_there: is_on(round, &at(near, offset)) };
    let mut places: Vec<Meeting> = offsets.into_iter().map(place).collect();
    places.sort_by(|a, b| a.t.total_cmp(&b.t));
    Some(places)
}

/// All must hold. A quantity must be positive, and is too close to tell up to the number beside it.
fn all(quantities: &[(TwoFloat, f64)]) -> Option<bool> {
    if quantities.iter().any(|(x, doubt)| f64::from(*x) < -doubt) {
        return Some(false);
    }
    quantities.iter().all(|(x, doubt)| f64::from(*x) > *doubt).then_some(true)
}

/// Inside three quarters of a turn: not where x is positive and y negative. Angles have the digits of `f64`.
fn in_sweep(x: TwoFloat, y: TwoFloat) -> (TwoFloat, f64) {
    (if -x > y { -x } else { y }, 1e-12)
}

fn on_disk([x, y, _]: &[TwoFloat; 3]) -> Option<bool> {
    let squared = *x * *x + *y * *y;
    all(&[(-squared + 1.0, 1e-26), (squared - 0.0625, 1e-26), in_sweep(*x, *y)])
}

fn is_on(round: &Round, [x, y, z]: &[TwoFloat; 3]) -> Option<bool> {
    // Heights have the digits of `f64` too.
    let [low, high] = round.heights;
    let heights = [(*z - low, 1e-14), (-*z + high, 1e-14)];
    let Some(start) = round.start else { return all(&heights) };
    let start = [TwoFloat::from(start[0]), *z * start[1]];
    let along = *x * start[0] + *y * start[1];
    let beside = *y * start[0] - *x * start[1];
    all(&[heights[0], heights[1], in_sweep(along, beside)])
}
