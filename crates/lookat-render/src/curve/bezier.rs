//! Cubic Bézier curves, and where they come closest to a point.

use glam::DVec3;

/// A point of the curve and the derivative there. Where that vanishes, the way from end to end stands in.
pub(super) fn evaluate(points: &[DVec3; 4], u: f64) -> (DVec3, DVec3) {
    let [a, b, c, d] = *points;
    let (ab, bc, cd) = (a.lerp(b, u), b.lerp(c, u), c.lerp(d, u));
    let (abc, bcd) = (ab.lerp(bc, u), bc.lerp(cd, u));
    let derivative = (bcd - abc) * 3.0;
    (abc.lerp(bcd, u), if derivative == DVec3::ZERO { d - a } else { derivative })
}

/// The control points of the part between two parameters, by blossoming.
pub(super) fn part(points: &[DVec3; 4], from: f64, to: f64) -> [DVec3; 4] {
    let blossom = |u: f64, v: f64, w: f64| {
        let [a, b, c, d] = *points;
        let (ab, bc, cd) = (a.lerp(b, u), b.lerp(c, u), c.lerp(d, u));
        ab.lerp(bc, v).lerp(bc.lerp(cd, v), w)
    };
    [blossom(from, from, from), blossom(from, from, to), blossom(from, to, to), blossom(to, to, to)]
}

/// A polynomial of degree 5 on 0..1, in Bernstein form.
pub(super) type Quintic = [f64; 6];

/// A third of the rate at which the curve comes closer to the origin, times its distance: it goes from more to less than
/// 0 where the distance is least.
pub(super) fn approach(c: &[DVec3; 4]) -> Quintic {
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
pub(super) fn falls(g: &Quintic, visit: &mut impl FnMut(f64)) {
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

/// How often the sign changes along the coefficients, with the signs of the first and the last given.
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
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - at).abs() <= f64::EPSILON {
            return next;
        }
        at = next;
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

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(seed: f64) -> [DVec3; 4] {
        [0.0, 1.0, 2.0, 3.0].map(|k| {
            let k = seed * 3.7 + k;
            DVec3::new((k * 1.9).sin(), (k * 3.1).cos(), (k * 0.8).sin()) + DVec3::X * (k % 1.0)
        })
    }

    #[test]
    fn a_part_is_the_same_curve() {
        let whole = curve(0.3);
        let part = part(&whole, 0.25, 0.75);
        for u in [0.0, 0.4, 1.0] {
            let (p, dp) = evaluate(&part, u);
            let (q, dq) = evaluate(&whole, 0.25 + 0.5 * u);
            assert!(p.distance(q) < 1e-15 && (dp * 2.0).distance(dq) < 1e-14);
        }
    }

    /// All minima of the distance, against a walk along the curve in small steps.
    #[test]
    fn falls_are_where_the_distance_is_least() {
        for case in 0..2000 {
            let points = curve(f64::from(case));
            let mut found = Vec::new();
            falls(&approach(&points), &mut |u| found.push(u));
            let steps = 2000;
            let distance = |k: i32| evaluate(&points, f64::from(k) / f64::from(steps)).0.length();
            let least: Vec<f64> = (1..steps)
                .filter(|k| distance(*k) <= distance(k - 1) && distance(*k) < distance(k + 1))
                .map(|k| f64::from(k) / f64::from(steps))
                .collect();
            // Those within some steps of an end may be counted or not.
            let inner = |u: &f64| (0.005..=0.995).contains(u);
            found.retain(inner);
            let least: Vec<f64> = least.into_iter().filter(inner).collect();
            assert_eq!(found.len(), least.len(), "{case}: {found:?} {least:?}");
            assert!(found.iter().zip(&least).all(|(a, b)| (a - b).abs() < 0.001), "{found:?} {least:?}");
            for u in found {
                let (p, dp) = evaluate(&points, u);
                assert!(p.dot(dp).abs() < 1e-12, "{case}: {u}");
            }
        }
    }

    #[test]
    fn a_curve_that_starts_with_a_point_twice_has_a_round_end() {
        let behind = [DVec3::X, DVec3::X, DVec3::X * 2.0, DVec3::X * 3.0];
        let mut found = Vec::new();
        falls(&approach(&behind), &mut |u| found.push(u));
        assert_eq!(found, [0.0]);
        let none = [DVec3::X, DVec3::X * 1.5, DVec3::X * 2.0, DVec3::X * 3.0];
        falls(&approach(&none), &mut |_| panic!("a straight end"));
    }
}
