//! Disks, spheres and other quadrics, and the hits of rays with them in double-double numbers.

use twofloat::TwoFloat;

use super::double_double::{Wide, quotient};
use super::*;

/// A surface of revolution x² + y² = a (z - s)² + b z + c, cut.
#[derive(Debug, Clone, Copy)]
struct Round {
    /// a, s, b.
    profile: [f64; 3],
    /// c.
    constant: TwoFloat,
    /// Lowest and highest z.
    heights: [f64; 2],
    /// A sweep of 270 degrees starts at x = `start[0]`, y = `start[1]` z; `None` for a whole turn.
    start: Option<[f64; 2]>,
}

/// A shape of about size one, with the middle of its height at the origin.
pub(super) struct CutShape {
    /// Its directives.
    text: &'static str,
    /// The surface; `None` for the disk.
    round: Option<Round>,
}

pub(super) const SHAPES: [CutShape; 5] = [
    CutShape { text: r#"Shape "disk" "float innerradius" 0.25"#, round: None },
    cut(r#"Shape "cylinder""#, [0.0; 3], 1.0, 1.0, [1.0, 0.0]),
    cut(r#"Translate 0 0 -1 Shape "cone" "float height" 2"#, [0.25, 1.0, 0.0], 0.0, 1.0, [1.0, 0.0]),
    cut(
        r#"Translate 0 0 -0.625 Shape "paraboloid" "float zmin" 0.25"#,
        [0.0, 0.0, 1.0],
        0.625,
        0.375,
        [1.0, 0.0],
    ),
    cut(HYPERBOLOID, [0.25, 0.0, 0.0], 0.25, 1.0, [0.5, -0.5]),
];

const HYPERBOLOID: &str = r#"Shape "hyperboloid" "point p1" [0.5 0.5 -1] "point p2" [0.5 -0.5 1]"#;

/// A surface of revolution up to that height above and below the origin.
const fn cut(text: &'static str, profile: [f64; 3], constant: f64, height: f64, start: [f64; 2]) -> CutShape {
    let (constant, heights) = (TwoFloat::from_f64(constant), [-height, height]);
    CutShape { text, round: Some(Round { profile, constant, heights, start: Some(start) }) }
}

impl CutShape {
    /// The whole sphere of this radius.
    pub fn sphere(radius: f64) -> CutShape {
        let constant = TwoFloat::new_mul(radius, radius);
        let round = Round { profile: [-1.0, 0.0, 0.0], constant, heights: [-radius, radius], start: None };
        CutShape { text: "Shape \"sphere\"", round: Some(round) }
    }

    pub fn is_disk(&self) -> bool {
        self.round.is_none()
    }

    /// The shape alone, around the eye, so that rays may start anywhere around it.
    pub fn prepared(&self, size: f64) -> PreparedScene {
        let is_whole = self.round.is_some_and(|round| round.start.is_none());
        let sweep = if is_whole { 360 } else { 270 };
        let shape = format!("{} \"float phimax\" {sweep}", self.text);
        prepared(&around_eye(&format!("Scale {size:e} {size:e} {size:e} {shape}")))
    }

    /// A point of the surface away from its cuts, and the normal. For the disk a point of the edge, and outward.
    pub fn point(&self, random: &mut Pcg64Mcg) -> (DVec3, DVec3) {
        let angle = between(random, 0.1, 4.6);
        let Some(Round { profile: [a, s, b], constant, heights: [low, high], start }) = self.round else {
            let p = DVec2::from_angle(angle).extend(0.0);
            return (p, p);
        };
        let z = between(random, 0.9 * low, 0.9 * high);
        let r = (a * (z - s) * (z - s) + b * z + f64::from(constant)).sqrt();
        let [x, y] = start.unwrap_or([1.0, 0.0]);
        let at = DVec2::from_angle(angle).rotate(DVec2::new(x, y * z).normalize()) * r;
        (at.extend(z), at.extend(-a * (z - s) - 0.5 * b).normalize())
    }
}

/// The hit of a ray with a shape.
pub(super) struct QuadricTruth {
    /// Whether it hits; `None` if that is too close to tell.
    pub hits: Option<bool>,
    /// The distance of the nearest hit.
    pub nearest: Option<f64>,
}

/// An intersection of the line with the uncut surface.
struct Intersection {
    t: f64,
    /// Whether it is on the cut shape; `None` if that is too close to tell.
    is_on_shape: Option<bool>,
}

impl QuadricTruth {
    pub fn new(shape: &CutShape, o: DVec3, d: DVec3) -> QuadricTruth {
        QuadricTruth::wide(shape, Wide::new(o), Wide::new(d))
    }

    pub fn wide(shape: &CutShape, o: Wide, d: Wide) -> QuadricTruth {
        let Some(found) = intersections(shape, o, d) else {
            return QuadricTruth { hits: None, nearest: None };
        };
        let ahead = || found.iter().filter(|hit| hit.t > 0.0);
        let nearest = ahead().find(|hit| hit.is_on_shape == Some(true)).map(|hit| hit.t);
        let doubt = ahead().any(|hit| hit.is_on_shape.is_none());
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
    let mut found = intersections(shape, Wide::new(p), Wide::new(d))?;
    // The start is the nearest hit.
    found.sort_by(|a, b| a.t.abs().total_cmp(&b.t.abs()));
    let Some(other) = found.get(1).filter(|hit| hit.t > 0.0) else { return Some(None) };
    (other.t > 1e-9).then_some(())?;
    other.is_on_shape.map(|is_on_shape| is_on_shape.then_some(other.t))
}

/// In order. Nothing where it is too close to tell whether there are any.
fn intersections(shape: &CutShape, o: Wide, d: Wide) -> Option<Vec<Intersection>> {
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
        return Some(vec![Intersection {
            t: f64::from(offset + k),
            is_on_shape: on_disk(&at(near, offset)),
        }]);
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
    let hit = |offset: TwoFloat| Intersection {
        t: f64::from(offset + k),
        is_on_shape: is_on(round, &at(near, offset)),
    };
    let mut found: Vec<Intersection> = offsets.into_iter().map(hit).collect();
    found.sort_by(|a, b| a.t.total_cmp(&b.t));
    Some(found)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_truth_is_that_of_simple_rays() {
        // From +y and above, downward: each shape stands in the way, and its cut away quarter does not.
        let down =
            |shape: &CutShape, y: f64| QuadricTruth::new(shape, DVec3::new(-0.5, y, 3.0), -DVec3::Z).hits;
        assert_eq!([down(&SHAPES[0], 0.0), down(&SHAPES[0], 1.0)], [Some(true), Some(false)]);
        let across = |shape: &CutShape, x: f64, y: f64| {
            let o = DVec3::new(x, y, 0.1);
            QuadricTruth::new(shape, o * 5.0 + DVec3::Z * -0.4, -DVec3::new(x, y, 0.0)).nearest
        };
        for shape in &SHAPES[1..] {
            let near = across(shape, -1.0, 1.0).unwrap();
            let through_the_gap = across(shape, 1.0, -1.0).unwrap();
            assert!((near + through_the_gap - 10.0).abs() < 1.5 && near < 5.0 && through_the_gap > 5.0);
        }
        assert!((across(&SHAPES[1], -0.6, 0.8).unwrap() - 4.0).abs() < 1e-15);
    }
}
