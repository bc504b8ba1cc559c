//! Eyes and lights in the plane of a triangle, or on a quadric: P1 to P6.
//!
//! A scene has its own coordinates, in which the tested plane is y = 0. A matrix, its frame, puts it into the world.

use super::*;
use crate::text_scene::{at, block, matte, sphere, two_sided};

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("P1", |_| {
        let origins = [DVec3::ZERO, DVec3::new(0.1, -0.3, 0.7), DVec3::new(-12.0, 3.3, 4.1)];
        dark_pixels(&origins.map(|origin| straight(origin, 1.0)).concat())
    }),
    ("P2", |trial| dark_pixels(&straight(DVec3::new(0.3, 0.7, -0.1) * trial.at, trial.at))),
    ("P3", |trial| dark_pixels(&straight(DVec3::new(1.1, -0.7, 0.3) * trial.at, 1.0))),
    ("P4", slanted),
    ("P5", light_in_plane),
    ("P6", eye_on_shape),
];

/// Rays per random scene.
const RAYS: u64 = 100;

fn frame(origin: DVec3, axes: DMat3, size: f64) -> DMat4 {
    DMat4::from_translation(origin) * DMat4::from_mat3(axes * size)
}

/// Three frames, one for each plane along two axes of the world.
fn straight(origin: DVec3, size: f64) -> [DMat4; 3] {
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
    [[x, y, z], [y, z, x], [z, x, y]].map(|[x, y, z]| frame(origin, DMat3::from_cols(x, y, z), size))
}

/// Axes rotated about a random one.
fn turned(random: &mut Pcg64Mcg) -> DMat3 {
    DMat3::from_axis_angle(direction(random), between(random, 0.0, 6.0))
}

/// A `LookAt` from `eye` in the direction `forward`.
fn look_at(frame: &DMat4, eye: DVec3, forward: DVec3, up: DVec3) -> String {
    let [eye, look] = [eye, eye + forward].map(|p| xyz(frame.transform_point3(p)));
    format!("LookAt {eye}  {look}  {}", xyz(frame.transform_vector3(up)))
}

fn placed_mesh(frame: &DMat4, points: &[DVec3], faces: &[[usize; 3]]) -> String {
    let points: Vec<DVec3> = points.iter().map(|p| frame.transform_point3(*p)).collect();
    mesh(&points, faces)
}

/// Triangles whose planes contain the origin.
struct Floor {
    /// x and z of the corners.
    corners: &'static [(i32, i32)],
    faces: &'static [[usize; 3]],
    /// How far corners at z = -30 and z = 30 are below the plane.
    drop: f64,
}

const FLOORS: [Floor; 5] = [
    // The origin is inside a triangle.
    Floor { corners: &[(-30, -18), (30, -18), (0, 42)], faces: &[[0, 1, 2]], drop: 0.0 },
    // The origin is on the edge between two triangles.
    Floor {
        corners: &[(-30, -30), (30, -30), (30, 30), (-30, 30)],
        faces: &[[0, 1, 2], [0, 2, 3]],
        drop: 0.0,
    },
    // The origin is the common corner of four triangles.
    Floor {
        corners: &[(0, 0), (-30, -30), (30, -30), (30, 30), (-30, 30)],
        faces: &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]],
        drop: 0.0,
    },
    // The origin is beside the triangle, in its plane.
    Floor { corners: &[(-30, 6), (30, 7), (0, 42)], faces: &[[0, 1, 2]], drop: 0.0 },
    // The origin is on the ridge of a roof.
    Floor { corners: &[(-30, 0), (30, 0), (3, 30), (-5, -30)], faces: &[[0, 1, 2], [0, 1, 3]], drop: 20.0 },
];

impl Floor {
    fn mesh(&self, frame: &DMat4) -> String {
        let corners = self.corners.iter().map(|(x, z)| [*x, *z].map(f64::from));
        let points: Vec<DVec3> =
            corners.map(|[x, z]| DVec3::new(x, -self.drop * z.abs() / 30.0, z)).collect();
        placed_mesh(frame, &points, self.faces)
    }
}

/// A camera, its viewing direction, its up vector, and whether its rays start from an area of the plane instead of from
/// one point.
type EyeView = (&'static str, DVec3, DVec3, bool);

const LENS: &str = "\"perspective\" \"float lensradius\" 0.5 \"float focaldistance\" 5";

const EYE_VIEWS: [EyeView; 7] = [
    ("\"perspective\" \"float fov\" 50", DVec3::new(0.0, 6.0, 15.0), DVec3::Y, false),
    ("\"perspective\" \"float fov\" 90", DVec3::Z, DVec3::Y, false),
    ("\"environment\"", DVec3::Z, DVec3::Y, false),
    (LENS, DVec3::Y, DVec3::new(1.0, 0.0, 1.0), true),
    (LENS, DVec3::NEG_Y, DVec3::new(1.0, 0.0, 3.0), true),
    ("\"orthographic\"", DVec3::Y, DVec3::new(1.0, 0.0, 1.0), true),
    ("\"orthographic\"", DVec3::NEG_Y, DVec3::new(2.0, 0.0, 1.0), true),
];

/// A scene with a black floor and a white sky.
fn eye_text(frame: &DMat4, floor: &Floor, (camera, forward, up, _): EyeView) -> String {
    let camera = format!("{} Camera {camera}", look_at(frame, DVec3::ZERO, forward, up));
    let world = format!("LightSource \"infinite\" {}{}", matte(0.0), floor.mesh(frame));
    pictured(&camera, 16, 4, "path", &world)
}

/// Counts the pixels of all scenes. Each pixel that is not white is a failure.
fn dark_pixels(frames: &[DMat4]) -> Tally {
    let mut tally = Tally::default();
    for frame in frames {
        for floor in &FLOORS {
            for view in EYE_VIEWS.into_iter().filter(|view| floor.drop == 0.0 || !view.3) {
                let rgb = render(&scene(&eye_text(frame, floor, view)), 0);
                for pixel in rgb {
                    tally.answer((pixel[1] - 1.0).abs() < 1e-6);
                }
            }
        }
    }
    tally
}

/// The corners are rounded, so the eye is only approximately in the plane. Near the origin, coordinates are as large as the
/// triangle, and the eye sees nothing of it. Farther away, rounding may turn one side of the triangle to the eye.
fn slanted(trial: &Trial) -> Tally {
    let is_near = trial.at <= 10.0;
    tally(trial.rays.min(50_000) / RAYS, trial.seed, |random, tally| {
        let axes = turned(random);
        let frame = frame(direction(random) * trial.at, axes, 1.0);
        let floor = &FLOORS[if is_near { random.random_range(0..4) } else { 0 }];
        let views = if is_near { EYE_VIEWS.len() } else { 3 };
        let view = EYE_VIEWS[random.random_range(0..views)];
        let wrong = wrong_answers(random, &frame, floor, view, is_near);
        (0..RAYS).for_each(|ray| tally.answer(ray >= wrong));
    })
}

/// The number of camera rays with a wrong result. The triangle must be invisible or, unless `is_near`, visible from one
/// side only.
fn wrong_answers(random: &mut Pcg64Mcg, frame: &DMat4, floor: &Floor, view: EyeView, is_near: bool) -> u64 {
    let prepared = prepared(&eye_text(frame, floor, view));
    let [mut hits, mut misses] = [[0; 2]; 2];
    for _ in 0..RAYS {
        let mut number = || DVec2::new(random.random(), random.random());
        let ray = prepared.camera.ray(number() * 16.0, number());
        let height = ray.d.dot(frame.y_axis.truncate());
        // This close to the plane, a ray may leave the triangle before it meets the plane.
        if height.abs() < 1e-6 {
            continue;
        }
        let counts = if prepared.world.nearest(&ray).is_some() { &mut hits } else { &mut misses };
        counts[usize::from(height > 0.0)] += 1;
    }
    let seen = hits[0] + hits[1];
    if is_near { seen } else { seen.min(hits[0] + misses[1]).min(hits[1] + misses[0]) }
}

/// Half the side of the square, and the radius of the disk.
const HALF: f64 = 0.5;

/// Directives for one light of each kind in the plane, on the x axis, at this distance. They light the sphere equally from any
/// distance.
fn lights(frame: &DMat4, distance: f64) -> [String; 7] {
    let at = distance * DVec3::X;
    let bright = distance * distance;
    let [from, to, x, middle] =
        [at, 2.0 * DVec3::Y, DVec3::X, DVec3::ZERO].map(|p| xyz(frame.transform_point3(p)));
    let turned = |x, y, z| {
        transform(&(*frame * DMat4::from_translation(at) * DMat4::from_mat3(DMat3::from_cols(x, y, z))))
    };
    let toward_middle = turned(DVec3::NEG_Z, DVec3::Y, DVec3::NEG_X);
    let upright = turned(DVec3::Z, DVec3::X, DVec3::Y);
    let square = placed_square(frame, at, HALF);
    let disk = format!("{upright} Shape \"disk\" \"float radius\" {HALF}");
    let intensity = format!("\"rgb I\" [{bright} 1 1]");
    let lights = [
        format!("LightSource \"point\" \"point from\" [{from}] {intensity}"),
        format!(
            "LightSource \"spot\" \"point from\" [{from}] \"point to\" [{to}] \"float coneangle\" 89 {intensity}"
        ),
        format!("Translate {from} LightSource \"goniometric\" {intensity}"),
        format!("{toward_middle} LightSource \"projection\" \"float fov\" 89 {intensity}"),
        format!("LightSource \"distant\" \"point from\" [{x}] \"point to\" [{middle}]"),
        two_sided([bright, 1.0, 1.0], &square),
        two_sided([bright, 1.0, 1.0], &disk),
    ];
    lights.map(|light| block(&light))
}

fn has_area(light: &str) -> bool {
    light.contains("AreaLightSource")
}

/// The corners of a square in the plane, with its center and half its side.
fn flat_square(middle: DVec3, half: f64) -> [DVec3; 4] {
    square(middle, half * DVec3::X, half * DVec3::Z)
}

fn placed_square(frame: &DMat4, middle: DVec3, half: f64) -> String {
    placed_mesh(frame, &flat_square(middle, half), &[[0, 1, 2], [0, 2, 3]])
}

/// A black floor, with a hole for an area light.
fn floor_around(has_area: bool, frame: &DMat4, distance: f64) -> String {
    let at = distance * DVec3::X;
    let mesh = if has_area {
        let points = [HALF, 3.0 * distance].map(|half| flat_square(at, half)).concat();
        let sides = (0..4).flat_map(|i| [[i, (i + 1) % 4, i + 4], [(i + 1) % 4, (i + 1) % 4 + 4, i + 4]]);
        placed_mesh(frame, &points, &sides.collect::<Vec<_>>())
    } else {
        placed_square(frame, at, 3.0 * distance)
    };
    matte(0.0) + &mesh
}

/// A scene with a sphere of radius 1 at this height over the plane, seen from slightly above the plane.
fn lit_text(light: &str, frame: &DMat4, height: f64, floor: &str) -> String {
    let (eye, forward) = (DVec3::new(0.0, 0.25, -8.0), DVec3::new(0.0, height - 0.25, 8.0));
    let camera =
        format!("{} Camera \"perspective\" \"float fov\" 20", look_at(frame, eye, forward, DVec3::Y));
    let sphere = at(frame.transform_point3(height * DVec3::Y), &sphere(1.0));
    pictured(&camera, 24, 4, "directlighting", &format!("{light} {sphere} {floor}"))
}

/// The floor does not change the picture of the sphere. The lowest point of the sphere is above the floor or on it.
fn light_in_plane(trial: &Trial) -> Tally {
    let mut tally = Tally::default();
    for frame in straight(DVec3::new(3.3, -0.7, 0.1), 1.0) {
        for light in lights(&frame, trial.at) {
            // At any distance, the part of the sphere near the plane sees an area light edge-on, so the sphere stays above the
            // plane.
            let heights = if has_area(&light) { [2.0, 1.5] } else { [2.0, 1.0] };
            for height in heights {
                let picture = |floor: &str| render(&scene(&lit_text(&light, &frame, height, floor)), 0);
                let floored = picture(&floor_around(has_area(&light), &frame, trial.at));
                for (a, b) in picture("").iter().zip(&floored) {
                    tally.answer((a[0] - b[0]).abs() <= 1e-5 * a[0]);
                }
            }
        }
    }
    tally
}

/// A shape, a point on it, and the normal at the point.
type SurfacePoint = (&'static str, [f64; 3], [f64; 3]);

const SURFACE_POINTS: [SurfacePoint; 6] = [
    ("Shape \"disk\"", [0.3, -0.5, 0.0], [0.0, 0.0, 1.0]),
    ("Shape \"sphere\"", [0.48, 0.6, 0.64], [0.48, 0.6, 0.64]),
    ("Shape \"cylinder\"", [0.6, -0.8, 0.1], [0.6, -0.8, 0.0]),
    ("Shape \"cone\"", [0.0, 0.75, 0.25], [0.0, 1.0, 1.0]),
    ("Shape \"paraboloid\"", [0.3, 0.4, 0.25], [0.6, 0.8, -1.0]),
    (
        "Shape \"hyperboloid\" \"point p1\" [1 0 -1] \"point p2\" [1 0.5 1]",
        [1.0, 0.25, 0.0],
        [1.0, 0.25, -0.0625],
    ),
];

/// Outward rays hit nothing, except on a hyperboloid. Inward rays hit the far side or leave through an opening. No ray
/// hits the shape at the eye.
fn eye_on_shape(trial: &Trial) -> Tally {
    tally(trial.rays.min(100_000) / RAYS, trial.seed, |random, all| {
        let surface = SURFACE_POINTS[random.random_range(0..SURFACE_POINTS.len())];
        let turn = turned(random);
        let axes = if random.random() { turn } else { DMat3::IDENTITY };
        let size = 10_f64.powi(random.random_range(-6..7));
        let prepared = prepared(&shape_text(surface, &frame(direction(random) * size, axes, size)));
        let outward = axes * DVec3::from(surface.2).normalize();
        for _ in 0..RAYS {
            let film = DVec2::new(random.random(), random.random()) * 16.0;
            let ray = prepared.camera.ray(film, DVec2::ZERO);
            let cosine = ray.d.dot(outward);
            // For nearly tangent rays, the far side may be as near as the tolerance.
            if cosine.abs() < 1e-3 {
                continue;
            }
            let hit = prepared.world.nearest(&ray);
            all.answer(
                hit.is_none_or(|hit| hit.t > 1e-6 * size && (cosine < 0.0 || surface.0.contains("hyper"))),
            );
        }
    })
}

fn shape_text((shape, point, _): SurfacePoint, frame: &DMat4) -> String {
    let look_at = look_at(frame, point.into(), DVec3::new(0.3, 0.2, 1.0), DVec3::Y);
    let world = format!("LightSource \"infinite\" {} {shape}", transform(frame));
    pictured(&format!("{look_at} Camera \"environment\""), 16, 1, "path", &world)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each point is on its shape: a ray from outside hits the shape there.
    #[test]
    fn eyes_are_on_shapes() {
        for surface in SURFACE_POINTS {
            let prepared = prepared(&shape_text(surface, &DMat4::IDENTITY));
            let n = DVec3::from(surface.2).normalize();
            let hit = prepared.world.nearest(&Ray::new(prepared.camera.eye + n * 0.25, -n)).expect("a hit");
            assert!((hit.t - 0.25).abs() < 1e-12, "{}: {}", surface.0, hit.t);
        }
    }

    /// A floor slightly below the eye is visible, so white pixels are a real result.
    #[test]
    fn floors_below_are_seen() {
        let [frame, ..] = straight(DVec3::ZERO, 1.0);
        let lower = DMat4::from_translation(-1e-9 * DVec3::Y) * frame;
        for floor in &FLOORS[..3] {
            let text = eye_text(&frame, floor, EYE_VIEWS[1]);
            let text = text.replace(&floor.mesh(&frame), &floor.mesh(&lower));
            let rgb = render(&scene(&text), 1);
            let dark = rgb.iter().filter(|pixel| pixel[1] == 0.0).count();
            assert_eq!(dark, rgb.len() / 2);
        }
    }

    /// Each light reaches the sphere, and a floor above the light hides it.
    #[test]
    fn lights_are_seen_and_can_be_hidden() {
        let [frame, ..] = straight(DVec3::ZERO, 1.0);
        let higher = DMat4::from_translation(1e-6 * DVec3::Y) * frame;
        for light in lights(&frame, 4.0) {
            let sum = |floor: &str| {
                let scene = scene(&lit_text(&light, &frame, 2.0, floor));
                render(&scene, 1).iter().map(|pixel| pixel[0]).sum::<f32>()
            };
            assert!(sum("") > 0.0, "{light}");
            // Distant light arrives parallel to the floor, so the floor cannot hide it.
            if !light.contains("\"distant\"") {
                let hidden = sum(&floor_around(false, &higher, 4.0));
                assert!(hidden < 0.5 * sum(""), "{light}");
            }
        }
    }
}
