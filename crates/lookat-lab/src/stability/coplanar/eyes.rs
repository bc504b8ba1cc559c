//! Eyes in the plane of a triangle: P1 to P4.

use super::{RAYS, frame, look_at, placed_mesh, straight, turned};
use crate::stability::prelude::*;

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

const VIEWS: [EyeView; 7] = [
    ("\"perspective\" \"float fov\" 50", DVec3::new(0.0, 6.0, 15.0), DVec3::Y, false),
    ("\"perspective\" \"float fov\" 90", DVec3::Z, DVec3::Y, false),
    ("\"environment\"", DVec3::Z, DVec3::Y, false),
    (LENS, DVec3::Y, DVec3::new(1.0, 0.0, 1.0), true),
    (LENS, DVec3::NEG_Y, DVec3::new(1.0, 0.0, 3.0), true),
    ("\"orthographic\"", DVec3::Y, DVec3::new(1.0, 0.0, 1.0), true),
    ("\"orthographic\"", DVec3::NEG_Y, DVec3::new(2.0, 0.0, 1.0), true),
];

/// A scene with a black floor and a white sky.
fn text(frame: &DMat4, floor: &Floor, (camera, forward, up, _): EyeView) -> String {
    let camera = format!("{} Camera {camera}", look_at(frame, DVec3::ZERO, forward, up));
    let floor = format!("Material \"matte\" \"rgb Kd\" [0 0 0] {}", floor.mesh(frame));
    pictured(&camera, 16, 4, "path", &format!("LightSource \"infinite\" {floor}"))
}

/// Counts the pixels of all scenes. Each pixel that is not white is a failure.
fn dark_pixels(frames: &[DMat4]) -> Tally {
    let mut tally = Tally::default();
    for frame in frames {
        for floor in &FLOORS {
            for view in VIEWS.into_iter().filter(|view| floor.drop == 0.0 || !view.3) {
                let rgb = render(&scene(&text(frame, floor, view)), 0);
                rgb.iter().for_each(|pixel| tally.answer((pixel[1] - 1.0).abs() < 1e-6));
            }
        }
    }
    tally
}

pub(super) fn in_plane(_: &Effort) -> Found {
    let origins = [DVec3::ZERO, DVec3::new(0.1, -0.3, 0.7), DVec3::new(-12.0, 3.3, 4.1)];
    Found::own(None, dark_pixels(&origins.map(|origin| straight(origin, 1.0)).concat()))
}

pub(super) fn of_any_size(_: &Effort) -> Found {
    Found::sweep(0, [1e-30, 1e-6, 1e-3, 1e3, 1e6, 1e30], |_, size| {
        dark_pixels(&straight(DVec3::new(0.3, 0.7, -0.1) * size, size))
    })
}

pub(super) fn far(_: &Effort) -> Found {
    Found::sweep(0, [1e2, 1e5, 1e8, 1e11], |_, distance| {
        dark_pixels(&straight(DVec3::new(1.1, -0.7, 0.3) * distance, 1.0))
    })
}

/// The corners are rounded, so the eye is only approximately in the plane. Near the origin, coordinates are as large as
/// the triangle, and the eye sees nothing of it. Farther away, rounding may turn one side of the triangle to the eye.
pub(super) fn slanted(effort: &Effort) -> Found {
    Found::sweep(4600, decades((0..10).step_by(2)), |seed, distance| {
        let is_near = distance <= 10.0;
        tally(effort.rays.min(50_000) / RAYS, seed, |random, tally| {
            let axes = turned(random);
            let frame = frame(direction(random) * distance, axes, 1.0);
            let floor = &FLOORS[if is_near { random.random_range(0..4) } else { 0 }];
            let view =
                VIEWS[if is_near { random.random_range(0..VIEWS.len()) } else { random.random_range(0..3) }];
            let wrong = wrong_answers(random, &frame, floor, view, is_near);
            (0..RAYS).for_each(|ray| tally.answer(ray >= wrong));
        })
    })
}

/// The number of camera rays with a wrong result. The triangle must be invisible or, unless `is_near`, visible from one
/// side only.
fn wrong_answers(random: &mut Pcg64Mcg, frame: &DMat4, floor: &Floor, view: EyeView, is_near: bool) -> u64 {
    let probe = probe(&text(frame, floor, view));
    let [mut hits, mut misses] = [[0; 2]; 2];
    for _ in 0..RAYS {
        let mut number = || DVec2::new(random.random(), random.random());
        let ray = probe.camera_ray(number() * 16.0, number());
        let height = ray.d.dot(frame.y_axis.truncate());
        // This close to the plane, a ray may leave the triangle before it meets the plane.
        if height.abs() < 1e-6 {
            continue;
        }
        let counts = if probe.nearest(&ray).is_some() { &mut hits } else { &mut misses };
        counts[usize::from(height > 0.0)] += 1;
    }
    let unseen = hits[0] + hits[1];
    if is_near { unseen } else { unseen.min(hits[0] + misses[1]).min(hits[1] + misses[0]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A floor slightly below the eye is visible, so white pixels are a real result.
    #[test]
    fn floors_below_are_seen() {
        let [frame, ..] = straight(DVec3::ZERO, 1.0);
        let lower = DMat4::from_translation(-1e-9 * DVec3::Y) * frame;
        for floor in &FLOORS[..3] {
            let text = text(&frame, floor, VIEWS[1]);
            let text = text.replace(&floor.mesh(&frame), &floor.mesh(&lower));
            let rgb = render(&scene(&text), 1);
            let dark = rgb.iter().filter(|pixel| pixel[1] == 0.0).count();
            assert_eq!(dark, rgb.len() / 2);
        }
    }
}
