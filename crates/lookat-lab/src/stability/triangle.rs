//! Rays against triangles: T1 to T10.

mod far;
mod grid;
mod input;
mod leaks;
mod mesh;
mod needles;
mod plane;
mod truth;

use num_traits::Float;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use glam::DVec3;

use super::case::{Axis, Case, Family, LOOKAT};
use super::methods::triangle::{DOUBLE, Formula, SINGLE, Triangle};
use super::methods::{Vector, double, single};
use super::random::direction;
use super::tally::Tally;

pub(super) fn cases() -> Vec<Case> {
    let case = |id, name, claim, axis, error, limit, run| Case {
        id,
        name,
        family: Family::Triangle,
        claim,
        axis,
        error,
        limit,
        run,
    };
    vec![
        case(
            "T1",
            "closed-mesh",
            "no ray from inside a closed mesh escapes through an edge or a vertex, at any place of the mesh",
            Axis::Of("distance from the origin / radius"),
            "",
            0.0,
            leaks::far_from_origin,
        ),
        case(
            "T2",
            "mesh-of-any-size",
            "no ray from inside a closed mesh escapes, at any size of the mesh",
            Axis::Of("radius"),
            "",
            0.0,
            leaks::of_any_size,
        ),
        case(
            "T3",
            "horizon",
            "ground is hit up to the horizon",
            Axis::Of("half size / height of the eye"),
            "",
            0.0,
            far::horizon,
        ),
        case(
            "T3b",
            "seam",
            "no ray escapes where the boxes of two triangles meet",
            Axis::Of("half size / height of the eye"),
            "",
            0.0,
            far::seam,
        ),
        case(
            "T4",
            "far-triangle",
            "a triangle is hit from any distance",
            Axis::Of("distance / size"),
            "",
            0.0,
            far::small,
        ),
        case(
            "T5",
            "needles",
            "triangles of almost no height are hit at the right distance",
            Axis::Of("length / height"),
            "relative error of the distance",
            1e-6,
            needles::needles,
        ),
        case(
            "T6",
            "no-area",
            "triangles without area are skipped with a note, and do no harm",
            Axis::None,
            "",
            0.0,
            input::no_area,
        ),
        case(
            "T7",
            "bad-mesh",
            "a mesh with a bad number is an error that names its line",
            Axis::None,
            "",
            0.0,
            input::bad_mesh,
        ),
        case(
            "T8",
            "same-place",
            "of two triangles in the same place, the first one is hit, on any number of threads",
            Axis::None,
            "",
            0.0,
            plane::same_place,
        ),
        case(
            "T9",
            "in-plane",
            "a ray in the plane of a triangle misses it",
            Axis::None,
            "",
            0.0,
            plane::in_plane,
        ),
        case(
            "T10",
            "grid",
            "a surface of many triangles blocks all rays through its vertices and along its edges",
            Axis::None,
            "",
            0.0,
            grid::grid,
        ),
    ]
}

/// The number of methods: lookat and the formulas.
const COUNT: usize = 1 + SINGLE.len() + DOUBLE.len();

/// Their names, in the order of tallies.
fn names() -> Vec<&'static str> {
    let formulas = SINGLE.iter().map(|f| f.0).chain(DOUBLE.iter().map(|f| f.0));
    std::iter::once(LOOKAT).chain(formulas).collect()
}

/// The nearest distance among triangles that a formula finds.
fn nearest<T: Float>(formula: Formula<T>, [o, d]: [Vector<T>; 2], triangles: &[Triangle<T>]) -> Option<T> {
    let hits = triangles.iter().filter_map(|triangle| formula(o, d, triangle));
    hits.fold(None, |least: Option<T>, t| Some(least.map_or(t, |least| least.min(t))))
}

/// Asks all formulas in single precision; `judge` gets what they find.
fn ask_single(
    tallies: &mut [Tally; COUNT],
    ray: [Vector<f32>; 2],
    triangles: &[Triangle<f32>],
    judge: impl Fn(&mut Tally, Option<f64>),
) {
    for (tally, (_, formula)) in tallies[1..].iter_mut().zip(SINGLE) {
        judge(tally, nearest(formula, ray, triangles).map(f64::from));
    }
}

/// The same in double precision.
fn ask_double(
    tallies: &mut [Tally; COUNT],
    ray: [Vector<f64>; 2],
    triangles: &[Triangle<f64>],
    judge: impl Fn(&mut Tally, Option<f64>),
) {
    for (tally, (_, formula)) in tallies[1 + SINGLE.len()..].iter_mut().zip(DOUBLE) {
        judge(tally, nearest(formula, ray, triangles));
    }
}

/// What single precision holds of a triangle.
fn rounded(triangle: [DVec3; 3]) -> [DVec3; 3] {
    triangle.map(|corner| double(single(corner)))
}

/// Any point of a triangle.
fn inside(random: &mut Pcg64Mcg, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (u, v) = (random.random::<f64>(), random.random::<f64>());
    let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
    a + (b - a) * u + (c - a) * v
}

/// The text of a scene with the eye at a place, in light from everywhere.
fn text(eye: DVec3, world: &str) -> String {
    let [x, y, z] = eye.to_array();
    format!(
        "LookAt {x:?} {y:?} {z:?}  {x:?} {y:?} {:?}  0 1 0\n\
         Camera \"perspective\" Integrator \"path\" Sampler \"sobol\" Film \"image\"\n\
         WorldBegin\nLightSource \"infinite\"\n{world}\nWorldEnd\n",
        z + 1.0
    )
}

/// The text of a mesh. Numbers are written so that they are read as they are.
pub(super) fn mesh_text(positions: &[DVec3], faces: &[[usize; 3]]) -> String {
    let points: Vec<String> = positions.iter().map(|p| format!("{:?} {:?} {:?}", p.x, p.y, p.z)).collect();
    let indices: Vec<String> = faces.iter().flatten().map(usize::to_string).collect();
    let (points, indices) = (points.join("  "), indices.join(" "));
    format!("Shape \"trianglemesh\" \"point P\" [{points}] \"integer indices\" [{indices}]")
}
