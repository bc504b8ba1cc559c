//! `Shape "nurbs"`: a rational B-spline surface, diced into triangles (shapes/nurbs.cpp).

mod surface;

use glam::DVec4;
use lookat_syntax::{Diagnostic, ParamType};

use crate::Transform;
use crate::mesh::{Mesh, finish, grid};
use crate::params::Params;
use crate::schema::{Floats, Given, Key, Kind, Needed, Range, Triples, Unit};
use surface::{Spline, Surface};

/// The points along each side, as in pbrt-v3.
const DICED: usize = 30;
/// The highest order. Usual surfaces have 3 to 6.
const HIGHEST_ORDER: f64 = 64.0;

/// The parameters of one direction.
struct Direction {
    count: Key<Needed>,
    order: Key<Needed>,
    knots: Key<Floats>,
    from: Key<Given>,
    to: Key<Given>,
}

macro_rules! direction {
    ($u:literal) => {
        Direction {
            count: Key::needed(
                concat!("n", $u),
                concat!("the number of control points along ", $u, ", at least ", $u, "order"),
            ),
            order: Key::needed(concat!($u, "order"), concat!("the degree along ", $u, " plus 1"))
                .within(Range::from_to(2.0, HIGHEST_ORDER)),
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
                Given,
                concat!("where the surface starts along ", $u, ", less than ", $u, "1"),
            )
            .default_words(concat!("knot number ", $u, "order")),
            to: Key::new(
                concat!($u, "1"),
                ParamType::Float,
                Given,
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
    "Shape",
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
    let mut mesh = Mesh { indices: grid(DICED, DICED), ..Mesh::default() };
    for row in 0..DICED {
        for column in 0..DICED {
            let (u, v) = (surface.u.at(share(column)), surface.v.at(share(row)));
            let (p, normal) = surface.evaluate(u, v)?;
            mesh.positions.push(p.into());
            // A pole has no normal: interpolation then uses its neighbors.
            mesh.normals.push(normal.normalize_or_zero().into());
            mesh.uvs.push([u, v]);
        }
    }
    Some(mesh)
}

fn share(at: usize) -> f64 {
    at as f64 / (DICED - 1) as f64
}

/// Reads one direction of the surface.
fn spline(params: &mut Params, keys: &Direction) -> Option<Spline> {
    let (points, order) = (params.take(&keys.count), params.take(&keys.order));
    let knots = params.take(&keys.knots);
    let (from, to) = (params.take(&keys.from), params.take(&keys.to));
    if knots.is_none() {
        let help = format!(
            "add \"float {}\" [...] with {} + {} knots",
            keys.knots.name, keys.count.name, keys.order.name
        );
        params.missing(keys.knots.name, &format!("a nurbs needs {}", keys.knots.name), &help);
    }
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
