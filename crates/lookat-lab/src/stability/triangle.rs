//! Rays against triangles: T1 to T10.

use lookat_render::ElementId;

use super::double_double::{cosine, crossing};
use super::icosphere::Icosphere;
use super::pictures::same_on_threads;
use super::*;
use crate::text_scene::quad;

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("T1", |trial| closed_mesh(trial, DVec3::new(0.6, 0.5, 0.62).normalize() * trial.at, 1.0)),
    ("T2", |trial| closed_mesh(trial, DVec3::ZERO, trial.at)),
    ("T3", horizon),
    ("T3b", seam),
    ("T4", far_triangle),
    ("T5", needles),
    ("T6", |_| no_area()),
    ("T8", same_place),
    ("T9", |_| in_plane()),
    ("T10", grid),
];

/// Rays from inside at a closed mesh and at a rotated and stretched instance of it.
fn closed_mesh(trial: &Trial, center: DVec3, radius: f64) -> Tally {
    let ball = Icosphere::new(2, center, radius);
    let [plain, instance] = ball_scenes(&ball);
    let shoot = |seed, prepared: &PreparedScene, stretch: DMat3| {
        tally(trial.rays, seed, |random, tally| {
            let (o, d) = shot(&ball, random);
            let ray = Ray::new(prepared.camera.eye + stretch * o, (stretch * d).normalize());
            tally.answer(prepared.world.nearest(&ray).is_some());
        })
    };
    let plain = shoot(trial.seed, &plain, DMat3::IDENTITY);
    let instance = shoot(trial.seed + 1000, &instance, stretch());
    plain.join(instance.clone()).part("lookat, instances", &instance)
}

/// The transformation of the instance.
fn stretch() -> DMat3 {
    let axis = DVec3::new(1.0, 2.0, 3.0).normalize();
    DMat3::from_axis_angle(axis, 40_f64.to_radians()) * DMat3::from_diagonal(DVec3::new(2.0, 0.5, 1.25))
}

/// The mesh and its instance, with the eye in the middle.
fn ball_scenes(ball: &Icosphere) -> [PreparedScene; 2] {
    let around = |center: DVec3| {
        let positions: Vec<DVec3> = ball.directions.iter().map(|p| center + *p * ball.radius).collect();
        mesh(&positions, &ball.faces)
    };
    let place = transform(&(DMat4::from_translation(ball.center) * DMat4::from_mat3(stretch())));
    let object = format!("ObjectBegin \"o\" {} ObjectEnd", around(DVec3::ZERO));
    let instance = format!("{object} {place} ObjectInstance \"o\"");
    [around(ball.center), instance].map(|world| prepared(&seen_from(ball.center, &world)))
}

/// A ray at an edge, or every other time at a vertex, from somewhere inside, relative to the middle. Its origin in the world is
/// not rounded.
fn shot(ball: &Icosphere, random: &mut Pcg64Mcg) -> (DVec3, DVec3) {
    let from = direction(random) * (0.5 * random.random::<f64>());
    let face = ball.face(random.random_range(0..ball.faces.len()));
    let corner = random.random_range(0..3);
    let along = if random.random() { random.random() } else { 0.0 };
    let o = ball.center + from * ball.radius - ball.center;
    let (p, q) = (face[corner], face[(corner + 1) % 3]);
    (o, (p + (q - p) * along - o).normalize())
}

/// Rays from height 1, at ground below: all hit. `ray` gives an origin and a direction.
fn at_ground(
    trial: &Trial,
    ground: &str,
    ray: impl Fn(&mut Pcg64Mcg) -> Option<(DVec3, DVec3)> + Sync,
) -> Tally {
    let prepared = prepared(&seen_from(DVec3::Y, ground));
    tally(trial.rays, trial.seed, |random, tally| {
        let Some((o, d)) = ray(random) else { return };
        // Positions are relative to the eye.
        tally.answer(prepared.world.nearest(&Ray::new(prepared.camera.eye + (o - DVec3::Y), d)).is_some());
    })
}

/// A square on the ground, with its middle below an eye at height 1.
fn horizon(trial: &Trial) -> Tally {
    let half = trial.at;
    at_ground(trial, &quad(DVec3::ZERO, DVec3::X * half, DVec3::Z * half), |random| {
        Some(downward(random, half)).filter(|(o, d)| is_on_ground(*o, *d, half))
    })
}

/// A ray from height 1 near the middle to the ground. All orders of magnitude of the distance are equally likely.
fn downward(random: &mut Pcg64Mcg, half: f64) -> (DVec3, DVec3) {
    let mut near = || (random.random::<f64>() - 0.5) * 0.1 * half;
    let o = DVec3::new(near(), 1.0, near());
    let (sin, cos) = (std::f64::consts::TAU * random.random::<f64>()).sin_cos();
    let distance = half.powf(random.random::<f64>());
    (o, DVec3::new(distance * cos, -1.0, distance * sin).normalize())
}

/// Whether the ray crosses the ground on the square, away from its rim. The rim is far wider than rounding errors.
fn is_on_ground(o: DVec3, d: DVec3, half: f64) -> bool {
    let p = o - d * (o.y / d.y);
    d.y < 0.0 && p.x.abs().max(p.z.abs()) < half * 0.999
}

/// Rays close to the common edge of two triangles. It is a side of the boxes of both, and their corners are far beyond the hits.
fn seam(trial: &Trial) -> Tally {
    let half = trial.at;
    let [a, b] = [-half, half].map(|z| DVec3::new(0.5, 0.0, z));
    let corners = [a, b, DVec3::new(-half, 0.0, 0.0), DVec3::new(half, 0.0, 0.0)];
    at_ground(trial, &mesh(&corners, &[[0, 1, 2], [0, 3, 1]]), |random| {
        let mut number = |low, high| between(random, low, high);
        let o = DVec3::new(number(-1.0, 1.0), 1.0, number(-1.0, 1.0));
        let beside = 10_f64.powf(number(-17.0, -5.0)).copysign(number(-1.0, 1.0));
        Some((o, (DVec3::new(0.5 + beside, 0.0, number(2.0, 50.0)) - o).normalize()))
    })
}

/// Poses of a triangle, each a scene of its own.
const POSES: usize = 64;

fn poses(seed: u64, make: impl Fn(&mut Pcg64Mcg) -> [DVec3; 3]) -> Vec<[DVec3; 3]> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    (0..POSES).map(|_| make(&mut random)).collect()
}

/// Sends rays from the origin at triangles that each stand alone. `judge` gets the distance that lookat finds, the direction and
/// the triangle.
fn at_poses(
    trial: &Trial,
    make: impl Fn(&mut Pcg64Mcg) -> [DVec3; 3],
    judge: impl Fn(&mut Tally, Option<f64>, DVec3, [DVec3; 3]) + Sync,
) -> Tally {
    let poses = poses(trial.seed + 100, make);
    let scenes: Vec<PreparedScene> =
        poses.iter().map(|pose| prepared(&around_eye(&triangles(pose)))).collect();
    tally(trial.rays, trial.seed, |random, tally| {
        let pose = random.random_range(0..POSES);
        let triangle = poses[pose];
        let d = in_triangle(random, triangle).normalize();
        // Certain hits, not at a grazing angle.
        let is_inside = crossing(DVec3::ZERO, d, triangle).is_some_and(|crossing| crossing.inside > 1e-3);
        if is_inside && cosine(d, triangle) > 0.05 {
            let hit = scenes[pose].world.nearest(&Ray::new(scenes[pose].camera.eye, d));
            judge(tally, hit.map(|hit| hit.t), d, triangle);
        }
    })
}

/// A triangle of size 1, seen at no less than 3 degrees.
fn far_triangle(trial: &Trial) -> Tally {
    let triangle = |random: &mut Pcg64Mcg| {
        let middle = direction(random) * trial.at;
        loop {
            let triangle = [0; 3].map(|_| middle + direction(random) * 0.5);
            let [a, b, c] = triangle;
            if (b - a).cross(c - a).length() > 0.2 && cosine(middle / trial.at, triangle) > 0.1 {
                return triangle;
            }
        }
    };
    at_poses(trial, triangle, |tally, t, _, _| tally.answer(t.is_some()))
}

/// Triangles of length 1 at a distance of 5.
///
/// The limit is the effect of rounding on the thinnest, seen at 3 degrees: 2e-16 of its distance is 2e-6 of its height, and along
/// its height and length the distance changes by no more than a fifth.
fn needles(trial: &Trial) -> Tally {
    const DISTANCE: f64 = 5.0;
    let needle = |random: &mut Pcg64Mcg| {
        let middle = direction(random) * DISTANCE;
        loop {
            let along = direction(random);
            let up = along.cross(direction(random)).normalize();
            // Seen from the side, so that its own edge hides none.
            if along.cross(up).dot(middle / DISTANCE).abs() > 0.1 {
                let tip = middle + along * 0.1 + up * (1.0 / trial.at);
                return [middle - along * 0.5, middle + along * 0.5, tip];
            }
        }
    };
    at_poses(trial, needle, |tally, t, d, triangle| {
        let truth = crossing(DVec3::ZERO, d, triangle).map_or(f64::NAN, |crossing| crossing.t);
        tally.error(((t.unwrap_or(f64::NAN) - truth) / truth).abs());
    })
}

/// Triangles without area, as points and indices. Their vertices follow the three of a right triangle.
const NO_AREA: [(&str, &str, &str); 5] = [
    ("one point three times", "7 7 7  7 7 7  7 7 7", "3 4 5"),
    ("a vertex twice", "1 2 0  0 2 1", "3 3 4"),
    ("two vertices in one place", "1 2 0  1 2 0  0 2 1", "3 4 5"),
    ("vertices in a line", "0 0 0  1 1 0  3 3 0", "3 4 5"),
    ("a vertex thrice in front of the eye", "0 0 -3", "3 3 3"),
];

fn no_area() -> Tally {
    let mut tally = Tally::default();
    let alone = render(&scene(&right_triangle("", "", "", "")), 1);
    for (name, points, indices) in NO_AREA {
        let loaded = load(&right_triangle("", points, indices, ""));
        let has_message = loaded.diagnostics.iter().any(|problem| problem.message.contains("area"));
        tally.check(has_message, || format!("{name}: skipped without a message"));
        let picture = loaded.scene.map(|scene| render(&scene, 1));
        tally.check(picture.is_some(), || format!("{name}: the scene is refused"));
        let same = picture.is_some_and(|picture| picture == alone);
        tally.check(same, || format!("{name}: changes the picture"));
        // As a light, and with normals of length zero.
        let normals =
            format!("\"normal N\" [{}]", "0 0 0 ".repeat(3 + points.split_whitespace().count() / 3));
        for (light, more) in [("AreaLightSource \"diffuse\"", ""), ("", normals.as_str())] {
            let text = right_triangle(light, points, indices, more);
            let picture = load(&text).scene.map(|scene| render(&scene, 1));
            let finite = picture.is_some_and(|rgb| rgb.as_flattened().iter().all(|x| x.is_finite()));
            tally.check(finite, || format!("{name} {light}{more}: the picture is not finite"));
        }
    }
    tally
}

/// A scene with one triangle, and additions to its mesh.
fn right_triangle(light: &str, points: &str, indices: &str, more: &str) -> String {
    let shape = format!("Shape \"trianglemesh\" \"point P\" [-1 -1 0  1 -1 0  0 1 1  {points}]");
    let world =
        format!("LightSource \"infinite\" {light} {shape} \"integer indices\" [0 1 2 {indices}] {more}");
    pictured("LookAt 0 0 -5  0 0 0  0 1 0  Camera \"perspective\"", 16, 4, "path", &world)
}

/// Copies in each of two meshes, enough for a BVH of several leaves.
const COPIES: usize = 6;

/// Two meshes of the same triangle over and over. Rays come from both sides.
fn same_place(trial: &Trial) -> Tally {
    let poses = poses(trial.seed, |random| [0; 3].map(|_| direction(random) * 2.0));
    // Each corner first, in both windings.
    let turned = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let first = Some(ElementId { instance: ElementId::WORLD, primitive: 0, index: 0 });
    let ask = |seed, faces: &[[usize; 3]; COPIES]| {
        let stack = |pose| around_eye(&mesh(pose, faces).repeat(2));
        let scenes: Vec<PreparedScene> = poses.iter().map(|pose| prepared(&stack(pose))).collect();
        tally(trial.rays, seed, |random, tally| {
            let pose = random.random_range(0..poses.len());
            let target = in_triangle(random, poses[pose]);
            let o = direction(random) * 5.0;
            let hit = scenes[pose].world.nearest(&Ray::new(o, (target - o).normalize()));
            tally.answer(hit.map(|hit| hit.element) == first);
        })
    };
    let same = ask(trial.seed + 1, &[[0, 1, 2]; COPIES]);
    let turned = ask(trial.seed + 2, &turned);
    let all = same.clone().join(turned.clone()).join(two_colors());
    all.part("lookat, same corners", &same).part("lookat, corners in any order", &turned)
}

/// A picture of two triangles of different color in the same place.
fn two_colors() -> Tally {
    let points = [DVec3::new(-1.0, -1.0, 0.1), DVec3::new(1.0, -1.0, 0.3), DVec3::new(0.2, 1.0, 0.7)];
    let world = format!(
        "LightSource \"infinite\" Material \"matte\" \"rgb Kd\" [1 0 0] {} Material \"matte\" \"rgb Kd\" [0 1 0] {}",
        triangles(&points),
        mesh(&points, &[[2, 1, 0]])
    );
    let camera = "LookAt 0 0 -3  0 0 0  0 1 0  Camera \"perspective\"";
    same_on_threads("two triangles in the same place", &scene(&pictured(camera, 48, 4, "path", &world)))
}

/// Planes through the origin, by two directions: first planes along an axis, in which slopes are exact.
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

/// Places in the plane, by its directions, beside a triangle with the corners (0, 0), (8, 0) and (0, 8).
const FROM: [(i32, i32); 6] = [(-3, -5), (-7, 2), (13, 1), (3, -9), (10, 10), (16, 0)];

/// Targets: inside the triangle, on its edges, at its corners, and beside it.
const TO: [(i32, i32); 10] =
    [(1, 1), (2, 3), (5, 1), (0, 0), (8, 0), (0, 8), (4, 4), (0, 5), (-1, -2), (9, 2)];

/// A ray in the plane of a triangle, without rounding errors.
struct Coplanar {
    ray: Ray,
    triangle: [DVec3; 3],
}

/// All coordinates are small integers, or such integers times one number of few digits.
fn coplanar_rays(plane: [[f64; 3]; 2]) -> Vec<Coplanar> {
    let [p, q] = plane.map(DVec3::from);
    let at = |(a, b): (i32, i32)| p * f64::from(a) + q * f64::from(b);
    let ray = |from, to| {
        let (o, away) = (at(from), at(to) - at(from));
        let digits = (1_u64 << 40) as f64;
        let d = away * ((digits / away.length()).round() / digits);
        Coplanar { ray: Ray::new(o, d), triangle: [(0, 0), (8, 0), (0, 8)].map(at) }
    };
    FROM.iter().flat_map(|from| TO.map(|to| ray(*from, to))).collect()
}

/// The origin of each ray is in the plane, within the rounding of corners, so the ray misses.
fn in_plane() -> Tally {
    let mut tally = Tally::default();
    for Coplanar { ray, triangle } in PLANES.into_iter().flat_map(coplanar_rays) {
        let hit = prepared(&around_eye(&triangles(&triangle))).world.nearest(&ray);
        tally.check(hit.is_none(), || format!("from {} toward {}: hits {triangle:?}", ray.o, ray.d));
    }
    tally
}

/// About as many vertices as rays are asked for, up to a million.
fn grid(trial: &Trial) -> Tally {
    let cells = ((trial.rays as f64).sqrt() as usize).clamp(10, 1000);
    let mut tally = Tally::default();
    // With cells of size 1 the rays meet vertices exactly, also at the rim. Otherwise rounding decides on which side they pass.
    for (size, first, last) in [(1.0, 0, cells), (0.1, 1, cells - 1)] {
        let (grid, mut random) = (Grid::new(cells, size), Pcg64Mcg::seed_from_u64(4000));
        let prepared = grid.prepared();
        let mut ask = |x, y| tally.answer(prepared.world.nearest(&grid.ray(&prepared, x, y)).is_some());
        for y in first..=last {
            for x in first..=last {
                ask(x as f64, y as f64);
                // A point of an edge that begins there.
                let step = random.random_range(1..1024) as f64 / 1024.0;
                let along = [(step, 0.0), (0.0, step), (step, step), (step, 1.0 - step)];
                let (dx, dy) = along[if (x + y).is_multiple_of(2) { random.random_range(0..3) } else { 3 }];
                let (x, y) = (x as f64 + dx, y as f64 + dy);
                if x.max(y) <= last as f64 {
                    ask(x, y);
                }
            }
        }
    }
    tally
}

/// Squares of two triangles each, with vertices of random height.
struct Grid {
    cells: usize,
    size: f64,
    positions: Vec<DVec3>,
}

impl Grid {
    fn new(cells: usize, size: f64) -> Grid {
        let mut random = Pcg64Mcg::seed_from_u64(4001);
        let places = (0..=cells).flat_map(|y| (0..=cells).map(move |x| (x as f64, y as f64)));
        let point = |(x, y)| DVec3::new(x * size, y * size, random.random::<f64>());
        Grid { cells, size, positions: places.map(point).collect() }
    }

    /// The two triangles of a cell. Diagonals alternate.
    fn cell(&self, x: usize, y: usize) -> [[usize; 3]; 2] {
        let at = |dx: usize, dy: usize| (y + dy) * (self.cells + 1) + x + dx;
        let [a, b, c, d] = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
        if (x + y).is_multiple_of(2) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    }

    /// Seen from far above by a camera with a pixel at each vertex.
    fn prepared(&self) -> PreparedScene {
        let cells = (0..self.cells).flat_map(|y| (0..self.cells).map(move |x| (x, y)));
        let faces: Vec<[usize; 3]> = cells.flat_map(|(x, y)| self.cell(x, y)).collect();
        let (start, end) = (-0.5 * self.size, (self.cells as f64 + 0.5) * self.size);
        let camera = format!(
            "LookAt 0 0 -10  0 0 0  0 1 0 Camera \"orthographic\" \"float screenwindow\" [{start:?} {end:?} {start:?} {end:?}]"
        );
        let world = format!("LightSource \"infinite\" {}", mesh(&self.positions, &faces));
        prepared(&pictured(&camera, self.cells as u32 + 1, 1, "path", &world))
    }

    /// A ray at a place, in cells.
    fn ray(&self, prepared: &PreparedScene, x: f64, y: f64) -> Ray {
        prepared.camera.ray(DVec2::new(x + 0.5, self.cells as f64 - y + 0.5), DVec2::splat(0.5))
    }
}

#[cfg(test)]
mod tests {
    use robust::{Coord3D, orient3d};

    use super::*;

    /// Rays far from all edges hit the mesh and its instance.
    #[test]
    fn rays_at_the_middle_of_faces_hit() {
        let ball = Icosphere::new(2, DVec3::new(1.0, 2.0, 3.0), 0.5);
        let [plain, instance] = ball_scenes(&ball);
        for face in 0..ball.faces.len() {
            let [a, b, c] = ball.face(face);
            let o = DVec3::new(0.05, -0.1, 0.02);
            let away = (a + b + c) / 3.0 - o;
            let hit = plain.world.nearest(&Ray::new(plain.camera.eye + o, away.normalize())).unwrap();
            assert!((hit.t - away.length()).abs() < 1e-14);
            let stretched = stretch() * away;
            let hit = instance
                .world
                .nearest(&Ray::new(instance.camera.eye + stretch() * o, stretched.normalize()))
                .unwrap();
            assert!((hit.t - stretched.length()).abs() < 1e-14);
        }
    }

    #[test]
    fn the_ground_ends_at_its_edge() {
        let o = DVec3::new(1.0, 1.0, 2.0);
        let to = |x: f64, z: f64| DVec3::new(x, 0.0, z) - o;
        assert!(is_on_ground(o, to(99.0, -99.0), 100.0));
        assert!(!is_on_ground(o, to(100.0, 0.0), 100.0));
        assert!(!is_on_ground(o, to(0.0, -101.0), 100.0));
        assert!(!is_on_ground(o, -to(0.0, 0.0), 100.0));
    }

    #[test]
    fn rays_lie_in_the_plane_and_begin_beside_the_triangle() {
        let point = |p: DVec3| Coord3D { x: p.x, y: p.y, z: p.z };
        for Coplanar { ray, triangle } in PLANES.into_iter().flat_map(coplanar_rays) {
            let is_flat = |p: DVec3| {
                let [a, b, c] = triangle.map(point);
                orient3d(a, b, c, point(p)) == 0.0
            };
            // The origin is a corner of the triangle.
            assert!(is_flat(ray.o) && is_flat(ray.d));
            assert!(!is_flat(triangle[1].cross(triangle[2]) * 1e-12));
            assert!((ray.d.length() - 1.0).abs() < 1e-9);
        }
        assert!(FROM.iter().all(|(a, b)| *a < 0 || *b < 0 || a + b > 8));
    }

    #[test]
    fn the_right_triangle_is_visible() {
        let rgb = render(&scene(&right_triangle("", "", "", "")), 1);
        assert!(rgb.iter().any(|pixel| *pixel != rgb[0]), "the triangle is not visible");
    }

    #[test]
    fn camera_rays_go_exactly_through_vertices() {
        let grid = Grid::new(10, 1.0);
        let prepared = grid.prepared();
        let ray = grid.ray(&prepared, 3.0, 7.0);
        assert_eq!((prepared.world.origin() + ray.o, ray.d), (DVec3::new(3.0, 7.0, -10.0), DVec3::Z));
        let hit = prepared.world.nearest(&ray).unwrap();
        assert!((hit.t - 10.0 - grid.positions[7 * 11 + 3].z).abs() < 1e-14);
    }
}
