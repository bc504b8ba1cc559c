//! Eyes in the plane of a triangle: P1 to P4.

use glam::{DMat3, DQuat};

use super::LocalFrame;
use crate::stability::prelude::*;

/// Triangles whose planes contain the origin.
struct Floor {
    points: &'static [[f64; 3]],
    faces: &'static [[usize; 3]],
    is_flat: bool,
}

const FLOORS: [Floor; 5] = [
    // The origin is inside a triangle.
    Floor {
        points: &[[-30.0, 0.0, -18.0], [30.0, 0.0, -18.0], [0.0, 0.0, 42.0]],
        faces: &[[0, 1, 2]],
        is_flat: true,
    },
    // The origin is on the edge between two triangles.
    Floor {
        points: &[[-30.0, 0.0, -30.0], [30.0, 0.0, -30.0], [30.0, 0.0, 30.0], [-30.0, 0.0, 30.0]],
        faces: &[[0, 1, 2], [0, 2, 3]],
        is_flat: true,
    },
    // The origin is the common corner of four triangles.
    Floor {
        points: &[
            [0.0, 0.0, 0.0],
            [-30.0, 0.0, -30.0],
            [30.0, 0.0, -30.0],
            [30.0, 0.0, 30.0],
            [-30.0, 0.0, 30.0],
        ],
        faces: &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]],
        is_flat: true,
    },
    // The origin is beside the triangle, in its plane.
    Floor {
        points: &[[-30.0, 0.0, 6.0], [30.0, 0.0, 7.0], [0.0, 0.0, 42.0]],
        faces: &[[0, 1, 2]],
        is_flat: true,
    },
    // The origin is on the ridge of a roof.
    Floor {
        points: &[[-30.0, 0.0, 0.0], [30.0, 0.0, 0.0], [3.0, -20.0, 30.0], [-5.0, -20.0, -30.0]],
        faces: &[[0, 1, 2], [0, 1, 3]],
        is_flat: false,
    },
];

/// A camera, its viewing direction, its up vector, and whether its rays start from an area of the plane instead of from
/// one point.
type EyeView = (&'static str, [f64; 3], [f64; 3], bool);

const VIEWS: [EyeView; 7] = [
    ("\"perspective\" \"float fov\" 50", [0.0, 6.0, 15.0], [0.0, 1.0, 0.0], false),
    ("\"perspective\" \"float fov\" 90", [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], false),
    ("\"environment\"", [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], false),
    (
        "\"perspective\" \"float lensradius\" 0.5 \"float focaldistance\" 5",
        [0.0, 1.0, 0.0],
        [1.0, 0.0, 1.0],
        true,
    ),
    (
        "\"perspective\" \"float lensradius\" 0.5 \"float focaldistance\" 5",
        [0.0, -1.0, 0.0],
        [1.0, 0.0, 3.0],
        true,
    ),
    ("\"orthographic\"", [0.0, 1.0, 0.0], [1.0, 0.0, 1.0], true),
    ("\"orthographic\"", [0.0, -1.0, 0.0], [2.0, 0.0, 1.0], true),
];

/// A scene with a black floor and a white sky.
fn text(place: &LocalFrame, floor: &Floor, (camera, forward, up, _): EyeView) -> String {
    format!(
        "{} Camera {camera} Sampler \"sobol\" \"integer pixelsamples\" 4 Integrator \"path\"
         Film \"image\" \"integer xresolution\" 16 \"integer yresolution\" 16
         WorldBegin LightSource \"infinite\" Material \"matte\" \"rgb Kd\" [0 0 0]
         {} WorldEnd",
        place.look_at([0.0; 3], forward, up),
        place.mesh(floor.points, floor.faces)
    )
}

/// Counts the pixels of all scenes. Each pixel that is not white is a failure.
fn dark_pixels(places: &[LocalFrame]) -> Tally {
    let mut tally = Tally::default();
    for place in places {
        for floor in &FLOORS {
            for view in VIEWS.into_iter().filter(|view| floor.is_flat || !view.3) {
                let rgb = render(&scene(&text(place, floor, view)), 0).rgb().unwrap_or_default();
                rgb.iter().for_each(|pixel| tally.answer((pixel[1] - 1.0).abs() < 1e-6));
            }
        }
    }
    tally
}

pub(super) fn in_plane(_: &Effort) -> Found {
    let origins = [DVec3::ZERO, DVec3::new(0.1, -0.3, 0.7), DVec3::new(-12.0, 3.3, 4.1)];
    let places: Vec<LocalFrame> =
        origins.into_iter().flat_map(|origin| LocalFrame::straight(origin, 1.0)).collect();
    Found::own(None, dark_pixels(&places))
}

pub(super) fn of_any_size(_: &Effort) -> Found {
    Found::sweep(0, [1e-30, 1e-6, 1e-3, 1e3, 1e6, 1e30], |_, size| {
        dark_pixels(&LocalFrame::straight(DVec3::new(0.3, 0.7, -0.1) * size, size))
    })
}

pub(super) fn far(_: &Effort) -> Found {
    Found::sweep(0, [1e2, 1e5, 1e8, 1e11], |_, distance| {
        dark_pixels(&LocalFrame::straight(DVec3::new(1.1, -0.7, 0.3) * distance, 1.0))
    })
}

/// The corners are rounded, so the eye is only approximately in the plane. Near the origin, coordinates are as large as
/// the triangle, and the eye sees nothing of it. Farther away, rounding may turn one side of the triangle to the eye.
pub(super) fn slanted(effort: &Effort) -> Found {
    Found::sweep(4600, decades((0..10).step_by(2)), |seed, distance| {
        let is_near = distance <= 10.0;
        tally(effort.rays.min(50_000) / RAYS, seed, |random, tally| {
            let axis = direction(random);
            let axes = DMat3::from_quat(DQuat::from_axis_angle(axis, random.random::<f64>() * 6.0));
            let place = LocalFrame { origin: direction(random) * distance, axes, size: 1.0 };
            let floor = &FLOORS[if is_near { random.random_range(0..4) } else { 0 }];
            let view =
                VIEWS[if is_near { random.random_range(0..VIEWS.len()) } else { random.random_range(0..3) }];
            let wrong = wrong_answers(random, &place, floor, view, is_near);
            (0..RAYS).for_each(|ray| tally.answer(ray >= wrong));
        })
    })
}

/// Rays per scene.
const RAYS: u64 = 100;

/// The number of camera rays with a wrong result. The triangle must be invisible or, unless `is_near`, visible from one
/// side only.
fn wrong_answers(
    random: &mut Pcg64Mcg,
    place: &LocalFrame,
    floor: &Floor,
    view: EyeView,
    is_near: bool,
) -> u64 {
    let scene = scene(&text(place, floor, view));
    let probe = Probe::new(&scene);
    let [mut hits, mut misses] = [[0; 2]; 2];
    for _ in 0..RAYS {
        let mut square = || DVec2::new(random.random(), random.random());
        let ray = probe.camera_ray(square() * 16.0, square());
        let height = ray.d.dot(place.axes.y_axis);
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
        let [place, ..] = LocalFrame::straight(DVec3::ZERO, 1.0);
        let lower = LocalFrame { origin: DVec3::new(0.0, -1e-9, 0.0), ..place };
        for floor in &FLOORS[..3] {
            let text = text(&place, floor, VIEWS[1]);
            let mesh = place.mesh(floor.points, floor.faces);
            let text = text.replace(&mesh, &lower.mesh(floor.points, floor.faces));
            let rgb = render(&scene(&text), 1).rgb().expect("a picture");
            let dark = rgb.iter().filter(|pixel| pixel[1] == 0.0).count();
            assert_eq!(dark, rgb.len() / 2);
        }
    }
}
