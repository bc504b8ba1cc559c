//! Points of a rational B-spline surface, by de Boor's algorithm.

use glam::{DVec3, DVec4, Vec4Swizzles};

/// The B-splines of one direction.
pub(super) struct Spline {
    /// The degree plus 1, at least 2.
    pub order: usize,
    /// The number of control points, at least `order`.
    pub points: usize,
    /// The knots: `points + order` of them, nondecreasing, with `knots[order - 1] < knots[points]`.
    pub knots: Vec<f64>,
    /// The start of the parameter range, within these two knots.
    pub from: f64,
    /// The end of the parameter range, above `from`.
    pub to: f64,
}

/// A surface over its two parameters.
pub(super) struct Surface {
    pub u: Spline,
    pub v: Spline,
    /// The homogeneous control points in rows along u.
    pub points: Vec<DVec4>,
}

impl Spline {
    /// The parameter at a fraction of the range, exact at both ends.
    pub fn at(&self, share: f64) -> f64 {
        (1.0 - share) * self.from + share * self.to
    }

    /// The first knot of the span of `t`. Between two spans, the first one counts, as in pbrt-v3.
    fn span(&self, t: f64) -> usize {
        let ends = &self.knots[self.order..self.points];
        let first = self.order - 1 + ends.partition_point(|end| *end < t);
        // Only the first span can be empty.
        (first..self.points - 1).find(|at| self.knots[*at] < self.knots[*at + 1]).unwrap_or(self.points - 1)
    }

    /// The value and the derivative at `t`, from the control points of its span.
    fn evaluate(&self, span: usize, mut points: Vec<DVec4>, t: f64) -> (DVec4, DVec4) {
        let knot = |at: usize| self.knots[at];
        for level in 0..self.order - 2 {
            for j in 0..self.order - 1 - level {
                let (low, high) = (knot(span + j + 2 + level - self.order), knot(span + 1 + j));
                let weight = (high - t) / (high - low);
                points[j] = points[j] * weight + points[j + 1] * (1.0 - weight);
            }
        }
        let (low, high) = (knot(span), knot(span + 1));
        let weight = (high - t) / (high - low);
        let slope = (points[1] - points[0]) * ((self.order - 1) as f64 / (high - low));
        (points[0] * weight + points[1] * (1.0 - weight), slope)
    }
}

impl Surface {
    /// A point and its normal, not normalized. `None` at infinity.
    pub fn evaluate(&self, u: f64, v: f64) -> Option<(DVec3, DVec3)> {
        let (u_span, v_span) = (self.u.span(u), self.v.span(v));
        let (u_first, v_first) = (u_span + 1 - self.u.order, v_span + 1 - self.v.order);
        let point = |i: usize, j: usize| self.points[(v_first + j) * self.u.points + u_first + i];
        let column = |i: usize| (0..self.v.order).map(|j| point(i, j)).collect();
        let row = |j: usize| (0..self.u.order).map(|i| point(i, j)).collect();
        let across = (0..self.u.order).map(|i| self.v.evaluate(v_span, column(i), v).0).collect();
        let along = (0..self.v.order).map(|j| self.u.evaluate(u_span, row(j), u).0).collect();
        let (p, du) = self.u.evaluate(u_span, across, u);
        let (_, dv) = self.v.evaluate(v_span, along, v);
        let projected = |d: DVec4| d.xyz() / p.w - p.xyz() * (d.w / (p.w * p.w));
        let found = (p.xyz() / p.w, projected(du).cross(projected(dv)));
        (found.0.is_finite() && found.1.is_finite()).then_some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter of a cylinder of radius 1 about z: exact as a rational surface of degree 2.
    #[test]
    fn a_rational_arc_is_a_circle() {
        let w = std::f64::consts::FRAC_1_SQRT_2;
        let arc = |z: f64| {
            [[1.0, 0.0, 1.0], [1.0, 1.0, w], [0.0, 1.0, 1.0]]
                .map(|[x, y, w]| DVec4::new(x * w, y * w, z * w, w))
        };
        let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let u = Spline { order: 3, points: 3, knots, from: 0.0, to: 1.0 };
        let v = Spline { order: 2, points: 2, knots: vec![2.0, 2.0, 5.0, 5.0], from: 2.0, to: 5.0 };
        let surface = Surface { u, v, points: [arc(0.0), arc(6.0)].concat() };
        for (u, v, z) in [(0.0, 2.0, 0.0), (0.25, 3.5, 3.0), (0.9, 4.0, 4.0), (1.0, 5.0, 6.0)] {
            let (p, n) = surface.evaluate(u, v).unwrap();
            assert!((p.x.hypot(p.y) - 1.0).abs() < 1e-15 && (p.z - z).abs() < 1e-14, "{p}");
            assert!(n.normalize().distance(DVec3::new(p.x, p.y, 0.0)) < 1e-14, "{n}");
        }
    }

    /// B-splines of control points at their Greville abscissae give the parameter itself, whatever the knots.
    #[test]
    fn knots_of_any_spacing_reproduce_a_plane() {
        let knots = vec![0.0, 0.0, 0.0, 0.0, 0.1, 0.5, 0.5, 0.7, 2.0, 2.0, 2.0, 2.0];
        let greville: Vec<f64> = (1..9).map(|i| knots[i..i + 3].iter().sum::<f64>() / 3.0).collect();
        let u = Spline { order: 4, points: 8, knots, from: 0.0, to: 2.0 };
        let v = Spline { order: 2, points: 2, knots: vec![0.0, 0.0, 1.0, 1.0], from: 0.0, to: 1.0 };
        let row = |y: f64| greville.iter().map(move |x| DVec4::new(*x, y, 0.0, 1.0));
        let surface = Surface { u, v, points: row(0.0).chain(row(1.0)).collect() };
        for u in [0.0, 0.05, 0.1, 0.3, 0.5, 0.6, 0.7, 1.3, 2.0] {
            let (p, n) = surface.evaluate(u, 0.25).unwrap();
            assert!(p.distance(DVec3::new(u, 0.25, 0.0)) < 1e-15, "{u}: {p}");
            assert!(n.distance(DVec3::Z) < 1e-13, "{u}: {n}");
        }
    }
}
