//! `Shape "nurbs"`: a rational B-spline surface, diced into triangles (shapes/nurbs.cpp).

use glam::{DVec3, DVec4, Vec4Swizzles};
use lookat_syntax::{Diagnostic, ParamType};

use crate::Transform;
use crate::mesh::{Mesh, VertexShading, finish, grid};
use crate::params::Params;
use crate::params::value::{Floats, OptionalFloat, OptionalInteger, Triples};
use crate::schema::{Key, Kind, Range, Unit};

/// The points along each side, as in pbrt-v3.
const DICED: usize = 30;
/// The highest order. Usual surfaces have 3 to 6.
const HIGHEST_ORDER: f64 = 64.0;

/// The parameters of one direction.
struct Direction {
    count: Key<OptionalInteger>,
    order: Key<OptionalInteger>,
    knots: Key<Floats>,
    from: Key<OptionalFloat>,
    to: Key<OptionalFloat>,
}

macro_rules! direction {
    ($u:literal) => {
        Direction {
            count: Key::optional_integer(
                concat!("n", $u),
                concat!("the number of control points along ", $u, ", at least ", $u, "order"),
            )
            .required(),
            order: Key::optional_integer(concat!($u, "order"), concat!("the degree along ", $u, " plus 1"))
                .within(Range::from_to(2.0, HIGHEST_ORDER))
                .required(),
            knots: Key::new(
                concat!($u, "knots"),
                ParamType::Float,
                Floats,
                concat!("n", $u, " + ", $u, "order knots that never decrease"),
            )
            .required(),
            from: Key::new(
                concat!($u, "0"),
                ParamType::Float,
                OptionalFloat,
                concat!("where the surface starts along ", $u, ", less than ", $u, "1"),
            )
            .default_words(concat!("knot number ", $u, "order")),
            to: Key::new(
                concat!($u, "1"),
                ParamType::Float,
                OptionalFloat,
                concat!("where the surface ends along ", $u),
            )
            .default_words(concat!("knot number n", $u, " + 1")),
        }
    };
}

const U: Direction = direction!("u");
const V: Direction = direction!("v");

const POINTS: Key<Triples> =
    Key::new("P", ParamType::Point3, Triples, "nu times nv control points, in rows along u")
        .default_words("none; a nurbs needs P or Pw")
        .unit(Unit::ObjectSpace);
const WEIGHTED_POINTS: Key<Floats> = Key::new(
    "Pw",
    ParamType::Float,
    Floats,
    "x, y and z times the weight, and the weight, of each control point; P has precedence",
)
.default_words("none; a nurbs needs P or Pw");

pub(super) const KIND: Kind = Kind::new(
    "nurbs",
    "a rational B-spline surface, diced into 30 by 30 points",
    &[
        &[&U.count, &U.order, &U.knots, &U.from, &U.to],
        &[&V.count, &V.order, &V.knots, &V.from, &V.to],
        &[&POINTS, &WEIGHTED_POINTS],
    ],
);

/// pbrt-v3's CreateNURBS.
pub(crate) fn nurbs(params: &mut Params, world_from_object: Transform) -> Option<Mesh> {
    let (u, v) = (spline(params, &U), spline(params, &V));
    let points = control_points(params);
    let (u, v, points) = (u?, v?, points?);
    if u.points.checked_mul(v.points) != Some(points.len()) {
        let (nu, nv) = (u.points, v.points);
        let name = if params.was_taken("P") { "P" } else { "Pw" };
        let message =
            format!("nu times nv is {nu} times {nv}, but there are {} control points", points.len());
        params.reject(name, message, None);
    }
    if !params.usable() {
        return None;
    }
    let surface = Surface { u, v, points };
    let Some(mesh) = diced(&surface) else {
        let help = "the fourth number of each point is its weight: use weights above 0";
        params.reject("Pw", "the weights of the control points cancel each other", Some(help));
        return None;
    };
    finish(params, mesh, world_from_object)
}

/// The triangles. `None` if a point is at infinity.
fn diced(surface: &Surface) -> Option<Mesh> {
    let (mut positions, mut normals, mut uvs) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..DICED {
        for column in 0..DICED {
            let (u, v) = (surface.u.at(share(column)), surface.v.at(share(row)));
            let (p, normal) = surface.evaluate(u, v)?;
            positions.push(p.into());
            // A pole has no normal: interpolation then uses its neighbors.
            normals.push(normal.normalize_or_zero().into());
            uvs.push([u, v]);
        }
    }
    let shading = VertexShading { normals: normals.into(), uvs: uvs.into(), ..VertexShading::default() };
    let mesh = Mesh { indices: grid(DICED, DICED).into(), positions: positions.into(), ..Mesh::default() };
    Some(mesh.with_shading(shading))
}

fn share(at: usize) -> f64 {
    at as f64 / (DICED - 1) as f64
}

/// Reads one direction of the surface.
fn spline(params: &mut Params, keys: &Direction) -> Option<Spline> {
    let (points, order) = (params.take(&keys.count), params.take(&keys.order));
    let knots = params.take(&keys.knots);
    let (from, to) = (params.take(&keys.from), params.take(&keys.to));
    let (points, order, knots) = (points?, order?, knots?);
    check_counts(params, keys, points, order, knots.len())?;
    let (order, points) = (order as usize, points as usize);
    let (least, most) = (knots[order - 1], knots[points]);
    let (from, to) = (from.unwrap_or(least), to.unwrap_or(most));
    let spline = Spline { order, points, knots, from, to };
    check(params, keys, &spline, [least, most]);
    params.usable().then_some(spline)
}

/// Checks the numbers of points and knots for the order.
fn check_counts(params: &mut Params, keys: &Direction, points: i32, order: i32, knots: usize) -> Option<()> {
    let needed = i64::from(points) + i64::from(order);
    let (name, message) = if points < order {
        (keys.count.name, format!("{} must be at least {}, {order}", keys.count.name, keys.order.name))
    } else if knots as i64 != needed {
        (keys.knots.name, format!("{points} points of order {order} need {needed} knots, not {knots}"))
    } else {
        return Some(());
    };
    params.reject(name, message, None);
    None
}

fn check(params: &mut Params, keys: &Direction, spline: &Spline, [least, most]: [f64; 2]) {
    let knots = &spline.knots;
    params.check_range(keys.knots.name, knots);
    if let Some(at) = (1..knots.len()).find(|at| knots[*at] < knots[*at - 1]) {
        let message = format!("knot {} follows {}: knots must not decrease", knots[at], knots[at - 1]);
        params.error(Diagnostic::error(params.value_place(keys.knots.name, at), message));
        return;
    }
    if least >= most {
        let message = format!(
            "the first and last knot of the surface, number {} and {}, are equal",
            spline.order,
            spline.points + 1
        );
        params.reject(keys.knots.name, message, None);
        return;
    }
    for (name, value) in [(keys.from.name, spline.from), (keys.to.name, spline.to)] {
        if !(least..=most).contains(&value) {
            params.reject(name, format!("{name} must be from {least} to {most}, within the knots"), None);
        }
    }
    if spline.from >= spline.to {
        let name = if params.was_taken(keys.to.name) { keys.to.name } else { keys.from.name };
        params.reject(
            name,
            format!("{} {} is not below {} {}", keys.from.name, spline.from, keys.to.name, spline.to),
            None,
        );
    }
}

/// Homogeneous control points. The points of `P` have weight 1.
fn control_points(params: &mut Params) -> Option<Vec<DVec4>> {
    let (plain, weighted) = (params.take(&POINTS), params.take(&WEIGHTED_POINTS));
    match (plain, weighted) {
        (Some(plain), _) => {
            params.replaced_by("Pw", &["P"]);
            Some(plain.into_iter().map(|[x, y, z]| DVec4::new(x, y, z, 1.0)).collect())
        }
        (None, Some(weighted)) => {
            if !weighted.len().is_multiple_of(4) {
                let message = format!("Pw takes groups of four numbers, found {} numbers", weighted.len());
                params.reject("Pw", message, None);
            }
            Some(weighted.chunks_exact(4).map(DVec4::from_slice).collect())
        }
        (None, None) => {
            let help = "add \"point P\" [...] with control points, or \"float Pw\" [...] with weighted ones";
            params.missing("P", "a nurbs needs P or Pw", help);
            None
        }
    }
}

/// The B-splines of one direction.
pub(crate) struct Spline {
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
