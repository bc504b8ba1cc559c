//! `Shape "curve"`: cubic Bézier curves with a width, for hair and grass (PBR 3.7).

use std::sync::Arc;

use glam::DVec3;
use lookat_syntax::ParamType;

use crate::Transform;
use crate::params::Params;
use crate::params::value::Triples;
use crate::schema::{Effect, Key, Kind, Range, Unit};
use crate::transform::{LARGEST, in_range};

/// A curve, in object space.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// The control points of its cubic Bézier segments, at least one segment (`P`, `basis`, `degree`).
    pub segments: Vec<[DVec3; 4]>,
    /// The cross section (`type`).
    pub kind: CurveKind,
    /// The width at the start and the end. Both are at least 0, and one is above 0. The width changes linearly from
    /// segment to segment (`width0` and `width1`, default `width`, default 1).
    pub widths: [f64; 2],
    /// Each segment has 2^`split_depth` bounding boxes (`splitdepth`, default 3, at most 5).
    pub split_depth: u32,
    /// Its placement, which many curves share.
    pub world_from_object: Arc<Transform>,
}

/// The cross section of a curve.
#[derive(Debug, Clone, PartialEq)]
pub enum CurveKind {
    /// A flat ribbon that faces the ray.
    Flat,
    /// A flat ribbon that faces the ray, shaded as a cylinder.
    Cylinder,
    /// A flat ribbon with its own orientation: unit normals at the start of each segment and at the end of the last.
    Ribbon(Vec<DVec3>),
}

const POINTS: Key<Triples> = Key::new(
    "P",
    ParamType::Point3,
    Triples,
    "control points: for bezier degree + 1, plus degree for each further segment; for bspline at least degree + 1",
)
.required()
.unit(Unit::ObjectSpace);
const BASIS: Key<&[&str]> =
    Key::choice("basis", &["bezier", "bspline"], "Bézier segments or a uniform B-spline");
const DEGREE: Key<i32> =
    Key::integer("degree", 3, "the degree of the polynomials").within(Range::from_to(2.0, 3.0));
const TYPE: Key<&[&str]> = Key::choice(
    "type",
    &["flat", "cylinder", "ribbon"],
    "a ribbon that faces the ray, the same shaded as a cylinder, or a ribbon with normals N",
);
const NORMALS: Key<Triples> =
    Key::new("N", ParamType::Normal, Triples, "a ribbon's normals at both ends of each segment");
const WIDTH: Key<f64> = width("width", "the width; a curve of width 0 at both ends is an error");
const WIDTH_0: Key<f64> = width("width0", "the width at the start").default_words("width");
const WIDTH_1: Key<f64> = width("width1", "the width at the end").default_words("width");
const SPLIT_DEPTH: Key<i32> =
    Key::integer("splitdepth", 3, "each segment has 2^splitdepth boxes; over 5 counts as 5")
        .within(Range::at_least(0.0))
        .effect(Effect::NoEffect);

const fn width(name: &'static str, meaning: &'static str) -> Key<f64> {
    Key::float(name, 1.0, meaning).within(Range::at_least(0.0)).unit(Unit::ObjectSpace)
}

pub(super) const KIND: Kind = Kind::new(
    "curve",
    "a curve with a width, for hair and grass",
    &[&[&POINTS, &BASIS, &DEGREE, &TYPE, &NORMALS, &WIDTH, &WIDTH_0, &WIDTH_1, &SPLIT_DEPTH]],
);

impl Curve {
    /// The largest `split_depth`. More boxes do not make a segment faster.
    pub(crate) const MOST_SPLITS: u32 = 5;

    /// True if its coordinates and widths are in the range of computation.
    pub(crate) fn is_in_range(&self) -> bool {
        let matrix = self.world_from_object.linear().to_cols_array();
        let scale = matrix.iter().fold(1.0_f64, |max, x| max.max(x.abs()));
        let is_near =
            |p: &DVec3| in_range(&p.to_array()) && in_range(&self.world_from_object.point(*p).to_array());
        in_range(&self.widths.map(|width| width * scale)) && self.segments.as_flattened().iter().all(is_near)
    }
}

/// pbrt-v3's CreateCurveShape.
pub(crate) fn curve(params: &mut Params, world_from_object: &Arc<Transform>) -> Option<Curve> {
    let world_from_object = world_from_object.clone();
    let degree = params.take(&DEGREE);
    let is_degree_known = params.usable();
    let bspline = params.take(&BASIS) == "bspline";
    let kind = params.take(&TYPE);
    let (points, normals) = (params.take(&POINTS), params.take(&NORMALS));
    let widths = widths(params);
    let split_depth = split_depth(params);
    if !is_degree_known {
        return None;
    }
    let segments = segments(params, &points?, degree as usize, bspline)?;
    params.reserve("P", size_of_val(&segments[..]))?.keep();
    let kind = match kind {
        "flat" => CurveKind::Flat,
        "cylinder" => CurveKind::Cylinder,
        _ => CurveKind::Ribbon(ribbon_normals(params, normals.as_deref(), segments.len())?),
    };
    if normals.is_some() && !matches!(kind, CurveKind::Ribbon(_)) {
        params.warn(
            "N",
            "N is ignored: the curve is not a ribbon",
            "to use N, add \"string type\" \"ribbon\"",
        );
    }
    let curve = Curve { segments, kind, widths, split_depth, world_from_object };
    if !curve.is_in_range() {
        params.reject("P", format!("the curve has coordinates above {LARGEST:e} in world space"), None);
    }
    params.usable().then_some(curve)
}

fn widths(params: &mut Params) -> [f64; 2] {
    // Between two other widths, it has no meaning.
    let is_used = !(params.given("width0") && params.given("width1"));
    let range = if is_used { WIDTH.range } else { Range::ALL };
    let default = params.take(&Key { range, ..WIDTH });
    let widths = [WIDTH_0, WIDTH_1].map(|key| params.take(&Key { default, ..key }));
    params.replaced_by("width", &["width0", "width1"]);
    if widths == [0.0; 2] {
        let name = if params.was_taken("width") { "width" } else { "width1" };
        params.reject(name, "a curve of width 0 is invisible", None);
    }
    widths
}

fn split_depth(params: &mut Params) -> u32 {
    // Old files use a float.
    let Key { name, default, meaning, .. } = SPLIT_DEPTH;
    let default = params.take(&Key::float(name, default.into(), meaning)) as i32;
    let depth = params.take(&Key { default, ..SPLIT_DEPTH });
    (depth.max(0) as u32).min(Curve::MOST_SPLITS)
}

/// Converts the control points to cubic Bézier segments.
fn segments(
    params: &mut Params,
    points: &[[f64; 3]],
    degree: usize,
    bspline: bool,
) -> Option<Vec<[DVec3; 4]>> {
    let count = points.len();
    let p = |at: usize| DVec3::from(points[at]);
    drop(params.reserve("P", count * size_of::<[DVec3; 4]>())?);
    if bspline && count > degree {
        return Some((0..count - degree).map(|at| from_bspline(degree, |k| p(at + k))).collect());
    }
    if !bspline && count > degree && (count - 1).is_multiple_of(degree) {
        return Some((0..count - 1).step_by(degree).map(|at| from_bezier(degree, |k| p(at + k))).collect());
    }
    let needed = if bspline { "at least " } else { "" };
    let more = if bspline { String::new() } else { format!(", plus {degree} for each further segment") };
    let message =
        format!("a curve of degree {degree} needs {needed}{} points{more}, not {count}", degree + 1);
    params.reject("P", message, None);
    None
}

/// Converts a Bézier curve of degree 2 or 3 to a cubic one.
fn from_bezier(degree: usize, p: impl Fn(usize) -> DVec3) -> [DVec3; 4] {
    if degree == 3 { [p(0), p(1), p(2), p(3)] } else { elevated([p(0), p(1), p(2)]) }
}

/// One span of a uniform B-spline.
fn from_bspline(degree: usize, p: impl Fn(usize) -> DVec3) -> [DVec3; 4] {
    if degree == 2 {
        return elevated([p(0).midpoint(p(1)), p(1), p(1).midpoint(p(2))]);
    }
    let between = |at: usize, share: f64| p(at).lerp(p(at + 1), share);
    let (near, far) = (between(1, 1.0 / 3.0), between(1, 2.0 / 3.0));
    [between(0, 2.0 / 3.0).midpoint(near), near, far, far.midpoint(between(2, 1.0 / 3.0))]
}

/// Elevates a quadratic curve to a cubic one.
fn elevated([a, b, c]: [DVec3; 3]) -> [DVec3; 4] {
    [a, a.lerp(b, 2.0 / 3.0), b.lerp(c, 1.0 / 3.0), c]
}

/// The unit normals of a ribbon, one more than segments.
fn ribbon_normals(params: &mut Params, normals: Option<&[[f64; 3]]>, segments: usize) -> Option<Vec<DVec3>> {
    let Some(normals) = normals else {
        let help = format!(
            "add \"normal N\" [...] with one normal at each end of a segment: {} normals",
            segments + 1
        );
        params.missing("N", "a ribbon needs normals N", &help);
        return None;
    };
    if normals.len() != segments + 1 {
        let message = format!(
            "a ribbon of {segments} {} needs {} normals, not {}",
            if segments == 1 { "segment" } else { "segments" },
            segments + 1,
            normals.len()
        );
        params.reject("N", message, None);
        return None;
    }
    let unit: Option<Vec<DVec3>> = normals.iter().map(|n| DVec3::from(*n).try_normalize()).collect();
    if unit.is_none() {
        params.reject("N", "a normal has length 0", None);
    }
    unit
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evaluate([a, b, c, d]: [DVec3; 4], u: f64) -> DVec3 {
        let (ab, bc, cd) = (a.lerp(b, u), b.lerp(c, u), c.lerp(d, u));
        ab.lerp(bc, u).lerp(bc.lerp(cd, u), u)
    }

    fn corner(k: usize) -> DVec3 {
        let k = k as f64;
        DVec3::new((k * 0.7).sin(), (k * 1.3).cos(), k * 0.5)
    }

    #[test]
    fn a_quadratic_curve_stays_the_same() {
        let cubic = from_bezier(2, corner);
        for u in [0.0, 0.3, 0.5, 1.0] {
            let (a, b) = (corner(0).lerp(corner(1), u), corner(1).lerp(corner(2), u));
            assert!(evaluate(cubic, u).distance(a.lerp(b, u)) < 1e-15);
        }
    }

    /// By the basis functions of uniform B-splines.
    #[test]
    fn spans_of_b_splines_are_bezier_curves() {
        for u in [0.0_f64, 0.25, 0.6, 1.0] {
            let t = 1.0 - u;
            let cubic = [
                t.powi(3) / 6.0,
                (3.0 * u.powi(3) - 6.0 * u * u + 4.0) / 6.0,
                (3.0 * t.powi(3) - 6.0 * t * t + 4.0) / 6.0,
                u.powi(3) / 6.0,
            ];
            let expected: DVec3 = (0..4).map(|k| corner(k) * cubic[k]).sum();
            assert!(evaluate(from_bspline(3, corner), u).distance(expected) < 1e-15);
            let quadratic = [t * t / 2.0, 0.5 + u * t, u * u / 2.0];
            let expected: DVec3 = (0..3).map(|k| corner(k) * quadratic[k]).sum();
            assert!(evaluate(from_bspline(2, corner), u).distance(expected) < 1e-15);
        }
    }
}
