//! `Shape "nurbs"`: a rational B-spline surface, diced into triangles (shapes/nurbs.cpp).

mod surface;

use glam::DVec4;
use lookat_syntax::{Diagnostic, ParamType};

use crate::Transform;
use crate::mesh::{Mesh, finish, grid};
use crate::params::Params;
use surface::{Spline, Surface};

/// The points along each side, as in pbrt-v3.
const DICED: usize = 30;
/// The highest order. Usual surfaces have 3 to 6.
const HIGHEST_ORDER: i32 = 64;

/// The parameter names of one direction.
struct Names {
    count: &'static str,
    order: &'static str,
    knots: &'static str,
    from: &'static str,
    to: &'static str,
}

const U: Names = Names { count: "nu", order: "uorder", knots: "uknots", from: "u0", to: "u1" };
const V: Names = Names { count: "nv", order: "vorder", knots: "vknots", from: "v0", to: "v1" };

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
fn spline(params: &mut Params, names: &Names) -> Option<Spline> {
    let points = params.needed_integer(names.count, "the number of control points in this direction");
    let order = params.needed_integer(names.order, "the degree plus 1");
    let knots = params.floats(names.knots);
    let domain = [params.given(names.from), params.given(names.to)];
    let (from, to) = (params.float(names.from, 0.0), params.float(names.to, 0.0));
    if knots.is_none() {
        let help =
            format!("add \"float {}\" [...] with {} + {} knots", names.knots, names.count, names.order);
        params.missing(names.knots, &format!("a nurbs needs {}", names.knots), &help);
    }
    let (points, order, knots) = (points?, order?, knots?);
    check_counts(params, names, points, order, knots.len())?;
    let (order, points) = (order as usize, points as usize);
    let (least, most) = (knots[order - 1], knots[points]);
    let from = if domain[0] { from } else { least };
    let to = if domain[1] { to } else { most };
    let spline = Spline { order, points, knots, from, to };
    check(params, names, &spline, [least, most]);
    params.usable().then_some(spline)
}

/// Checks the numbers of points and knots for the order.
fn check_counts(params: &mut Params, names: &Names, points: i32, order: i32, knots: usize) -> Option<()> {
    let needed = i64::from(points) + i64::from(order);
    let (name, message) = if !(2..=HIGHEST_ORDER).contains(&order) {
        (names.order, format!("the order must be from 2 to {HIGHEST_ORDER}"))
    } else if points < order {
        (names.count, format!("{} must be at least {}, {order}", names.count, names.order))
    } else if knots as i64 != needed {
        (names.knots, format!("{points} points of order {order} need {needed} knots, not {knots}"))
    } else {
        return Some(());
    };
    params.reject(name, message, None);
    None
}

fn check(params: &mut Params, names: &Names, spline: &Spline, [least, most]: [f64; 2]) {
    let knots = &spline.knots;
    params.check_range(names.knots, knots);
    if let Some(at) = (1..knots.len()).find(|at| knots[*at] < knots[*at - 1]) {
        let message = format!("knot {} follows {}: knots must not decrease", knots[at], knots[at - 1]);
        params.error(Diagnostic::error(params.value_place(names.knots, at), message));
        return;
    }
    if least >= most {
        let message = format!(
            "the first and last knot of the surface, number {} and {}, are equal",
            spline.order,
            spline.points + 1
        );
        params.reject(names.knots, message, None);
        return;
    }
    for (name, value) in [(names.from, spline.from), (names.to, spline.to)] {
        if !(least..=most).contains(&value) {
            params.reject(name, format!("{name} must be from {least} to {most}, within the knots"), None);
        }
    }
    if spline.from >= spline.to {
        let name = if params.was_taken(names.to) { names.to } else { names.from };
        params.reject(
            name,
            format!("{} {} is not below {} {}", names.from, spline.from, names.to, spline.to),
            None,
        );
    }
}

/// Homogeneous control points. The points of `P` have weight 1.
fn control_points(params: &mut Params) -> Option<Vec<DVec4>> {
    let (plain, weighted) = (params.triples("P", ParamType::Point3), params.floats("Pw"));
    match (plain, weighted) {
        (Some(plain), weighted) => {
            if weighted.is_some() {
                params.warn("Pw", "P and Pw are both given: P is used", "delete one of them");
            }
            Some(plain.into_iter().map(|[x, y, z]| DVec4::new(x, y, z, 1.0)).collect())
        }
        (None, Some(weighted)) => {
            if !weighted.len().is_multiple_of(4) {
                let message = format!("Pw takes groups of four numbers; {} numbers given", weighted.len());
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
