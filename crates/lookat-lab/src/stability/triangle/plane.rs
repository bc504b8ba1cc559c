//! T6, T8 and T9: triangles without area, triangles in the same place, and rays in their plane.

use lookat_render::ElementId;

use super::far::poses;
use crate::stability::prelude::*;
use crate::stability::traversal::same_on_threads;

/// Triangles without area, as points and indices. Their vertices come after the three of a triangle that is right.
const NO_AREA: [(&str, &str, &str); 5] = [
    ("one point three times", "7 7 7  7 7 7  7 7 7", "3 4 5"),
    ("a vertex twice", "1 2 0  0 2 1", "3 3 4"),
    ("two vertices in one place", "1 2 0  1 2 0  0 2 1", "3 4 5"),
    ("vertices in a line", "0 0 0  1 1 0  3 3 0", "3 4 5"),
    ("a vertex thrice in front of the eye", "0 0 -3", "3 3 3"),
];

pub(super) fn no_area(_: &Effort) -> Found {
    let mut found = Found::default();
    let alone = render(&scene(&with("", "", "", "")), 1);
    for (name, points, indices) in NO_AREA {
        let loaded = load(&with("", points, indices, ""));
        let is_said = loaded.diagnostics.iter().any(|problem| problem.message.contains("area"));
        found.check(is_said, || format!("{name}: is left out, which is not said"));
        let picture = loaded.scene.map(|scene| render(&scene, 1));
        found.check(picture.is_some(), || format!("{name}: the whole scene is refused"));
        let same = picture.is_some_and(|picture| picture == alone);
        found.check(same, || format!("{name}: changes the picture"));
        // As a light, and with normals that have no length either.
        let normals =
            format!("\"normal N\" [{}]", "0 0 0 ".repeat(3 + points.split_whitespace().count() / 3));
        for (light, more) in [("AreaLightSource \"diffuse\"", ""), ("", normals.as_str())] {
            let picture = load(&with(light, points, indices, more)).scene.map(|scene| render(&scene, 1));
            let finite = picture.is_some_and(|rgb| rgb.as_flattened().iter().all(|x| x.is_finite()));
            found.check(finite, || format!("{name} {light}{more}: the picture is not finite"));
        }
    }
    found
}

/// A scene with one triangle and what is to be added to its mesh.
fn with(light: &str, points: &str, indices: &str, more: &str) -> String {
    let shape = format!("Shape \"trianglemesh\" \"point P\" [-1 -1 0  1 -1 0  0 1 1  {points}]");
    let world =
        format!("LightSource \"infinite\" {light} {shape} \"integer indices\" [0 1 2 {indices}] {more}");
    pictured("LookAt 0 0 -5  0 0 0  0 1 0  Camera \"perspective\"", 16, 4, "path", &world)
}

/// Copies in each of two meshes, enough for a tree of several leaves.
const COPIES: usize = 6;

/// Two meshes of the same triangle over and over. Rays come from both sides.
pub(super) fn same_place(effort: &Effort) -> Found {
    let poses = poses(3800, |random| [0; 3].map(|_| direction(random) * 2.0));
    // Each corner first, in both windings.
    let turned = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let first = Some(ElementId { instance: ElementId::WORLD, primitive: 0, index: 0 });
    let ask = |seed, faces: &[[usize; 3]; COPIES]| {
        let stack = |pose| around_eye(&mesh(pose, faces).repeat(2));
        let probes: Vec<Probe> = poses.iter().map(|pose| probe(&stack(pose))).collect();
        tally(effort.rays, seed, |random, tally| {
            let pose = random.random_range(0..poses.len());
            let target = in_triangle(random, poses[pose]);
            let o = direction(random) * 5.0;
            let hit = probes[pose].nearest(&Ray::new(o, (target - o).normalize()));
            tally.answer(hit.map(|hit| hit.element) == first);
        })
    };
    let [same, turned] = [ask(3801, &[[0, 1, 2]; COPIES]), ask(3802, &turned)];
    let mut found = Found::own(None, same.join(turned));
    found.add("lookat, same corners", None, same);
    found.add("lookat, corners in any order", None, turned);
    on_threads(&mut found);
    found
}

/// A picture of two triangles of different color in the same place, on some numbers of threads.
fn on_threads(found: &mut Found) {
    let points = [DVec3::new(-1.0, -1.0, 0.1), DVec3::new(1.0, -1.0, 0.3), DVec3::new(0.2, 1.0, 0.7)];
    let world = format!(
        "LightSource \"infinite\" Material \"matte\" \"rgb Kd\" [1 0 0] {} Material \"matte\" \"rgb Kd\" [0 1 0] {}",
        triangles(&points),
        mesh(&points, &[[2, 1, 0]])
    );
    let camera = "LookAt 0 0 -3  0 0 0  0 1 0  Camera \"perspective\"";
    let scene = scene(&pictured(camera, 48, 4, "path", &world));
    same_on_threads(found, "two triangles in the same place", &scene);
}

/// Planes through the origin, by two directions: first those that hold an axis, in which slopes are exact.
const PLANES: [[[f64; 3]; 2]; 9] = [
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
    [[1.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[1.0, 2.0, 0.0], [0.0, 0.0, 1.0]],
    [[1.0, -1.0, 0.0], [0.0, 1.0, -1.0]],
    [[1.0, 0.0, 2.0], [0.0, 3.0, 1.0]],
    [[1.0, 2.0, 3.0], [3.0, -1.0, 2.0]],
    [[7.0, -5.0, 3.0], [2.0, 11.0, -13.0]],
];

/// Places in the plane, by those directions, beside a triangle with the corners (0, 0), (8, 0) and (0, 8).
const FROM: [(i32, i32); 6] = [(-3, -5), (-7, 2), (13, 1), (3, -9), (10, 10), (16, 0)];

/// Targets: inside it, on its edges, at its corners, and beside it.
const TO: [(i32, i32); 10] =
    [(1, 1), (2, 3), (5, 1), (0, 0), (8, 0), (0, 8), (4, 4), (0, 5), (-1, -2), (9, 2)];

/// A ray in the plane of a triangle, without rounding.
struct Flat {
    o: DVec3,
    /// Of length one, nearly.
    d: DVec3,
    triangle: [DVec3; 3],
}

/// All numbers are small integers, and multiples of them by one number of few digits: nothing is rounded.
fn flat_rays(plane: [[f64; 3]; 2]) -> Vec<Flat> {
    let [p, q] = plane.map(DVec3::from);
    let at = |(a, b): (i32, i32)| p * f64::from(a) + q * f64::from(b);
    let ray = |from, to| {
        let (o, away) = (at(from), at(to) - at(from));
        let digits = (1_u64 << 40) as f64;
        let d = away * ((digits / away.length()).round() / digits);
        Flat { o, d, triangle: [(0, 0), (8, 0), (0, 8)].map(at) }
    };
    FROM.iter().flat_map(|from| TO.map(|to| ray(*from, to))).collect()
}

/// The origin of each ray is in the plane, within what the rounding of corners takes: so it misses.
pub(super) fn in_plane(_: &Effort) -> Found {
    let mut found = Found::default();
    for Flat { o, d, triangle } in PLANES.into_iter().flat_map(flat_rays) {
        let hit = probe(&around_eye(&triangles(&triangle))).nearest(&Ray::new(o, d));
        found.check(hit.is_none(), || format!("from {o} toward {d}: hits {triangle:?}"));
    }
    found
}

#[cfg(test)]
mod tests {
    use robust::{Coord3D, orient3d};

    use super::*;

    #[test]
    fn rays_lie_in_the_plane_and_begin_beside_the_triangle() {
        let point = |p: DVec3| Coord3D { x: p.x, y: p.y, z: p.z };
        for flat in PLANES.into_iter().flat_map(flat_rays) {
            let is_flat = |p: DVec3| {
                let [a, b, c] = flat.triangle.map(point);
                orient3d(a, b, c, point(p)) == 0.0
            };
            // The origin is a corner of the triangle.
            assert!(is_flat(flat.o) && is_flat(flat.d));
            assert!(!is_flat(flat.triangle[1].cross(flat.triangle[2]) * 1e-12));
            assert!((flat.d.length() - 1.0).abs() < 1e-9);
        }
        assert!(FROM.iter().all(|(a, b)| *a < 0 || *b < 0 || a + b > 8));
    }

    #[test]
    fn the_triangle_is_seen() {
        let rgb = render(&scene(&with("", "", "", "")), 1);
        assert!(rgb.iter().any(|pixel| *pixel != rgb[0]), "the triangle is not seen");
    }
}
