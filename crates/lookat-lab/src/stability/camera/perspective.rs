//! Directions of a camera without a lens, by its angle of view, its place, and where it looks: C1 to C4, C6 and C9.

use super::exact::{CameraAxes, Pinhole, angle, tan_half};
use super::{anywhere, directions, look_at, text};
use crate::stability::prelude::*;

pub(super) fn tele(effort: &Effort) -> Found {
    Found::sweep(1000, [0.001, 0.01, 0.1, 1.0, 10.0, 45.0], |seed, fov| {
        view(effort, seed, fov, |pinhole, film, d| pinhole.pixels(film, d))
    })
}

pub(super) fn usual(effort: &Effort) -> Found {
    Found::sweep(2000, [0.001, 0.01, 0.1, 1.0, 10.0, 45.0, 90.0], |seed, fov| view(effort, seed, fov, off_by))
}

pub(super) fn wide(effort: &Effort) -> Found {
    Found::sweep(3000, [60.0, 30.0, 10.0, 1.0, 0.1, 0.01, 0.001], |seed, rest| {
        view(effort, seed, 180.0 - rest, off_by)
    })
}

fn off_by(pinhole: &Pinhole, film: DVec2, d: DVec3) -> f64 {
    angle(d, pinhole.direction(film))
}

const RESOLUTION: [u32; 2] = [16384; 2];

/// Eye, point looked at and up.
const LOOK_AT: [DVec3; 3] = [DVec3::new(3.0, 4.0, 5.0), DVec3::new(0.0, 0.5, 0.0), DVec3::Z];

fn view(effort: &Effort, seed: u64, fov: f64, error: impl Fn(&Pinhole, DVec2, DVec3) -> f64 + Sync) -> Tally {
    let exact = pinhole(LOOK_AT, fov, RESOLUTION);
    directions(effort, seed, (&camera(LOOK_AT, fov), RESOLUTION), place, |film, d| error(&exact, film, d))
}

/// Half of them anywhere on the film, half near its middle, where a wide film leaves few.
fn place(random: &mut Pcg64Mcg, resolution: [u32; 2]) -> DVec2 {
    if random.random::<bool>() {
        return anywhere(random, resolution);
    }
    let distance = (13.0 - 30.0 * random.random::<f64>()).exp2();
    let direction = DVec2::from_angle(std::f64::consts::TAU * random.random::<f64>());
    DVec2::from(resolution.map(f64::from)) / 2.0 + distance * direction
}

pub(super) fn camera(at: [DVec3; 3], fov: f64) -> String {
    format!("{} Camera \"perspective\" \"float fov\" {fov}", look_at(at))
}

pub(super) fn pinhole([eye, look, up]: [DVec3; 3], fov: f64, resolution: [u32; 2]) -> Pinhole {
    let view = CameraAxes::new(eye, look, up).expect("these views have a side");
    Pinhole { view, tan: tan_half(fov), resolution }
}

pub(super) fn far_eye(effort: &Effort) -> Found {
    Found::sweep(4000, decades(3..9), |seed, distance| {
        let (at, resolution) = (far_look_at(distance), [1920, 1080]);
        let exact = pinhole(at, 45.0, resolution);
        directions(effort, seed, (&camera(at, 45.0), resolution), anywhere, |film, d| exact.pixels(film, d))
    })
}

/// An eye this far away that looks at a point 10 from it; numbers without pattern.
pub(super) fn far_look_at(distance: f64) -> [DVec3; 3] {
    let eye = distance * DVec3::new(0.6180339887, 0.3141592653, 0.7206834121)
        + DVec3::new(0.123456789, 0.23456789, 0.3456789);
    [eye, eye + DVec3::new(6.12345678, 7.0123456, 3.54321), DVec3::Z]
}

/// Each try reads a scene: there are fewer of them.
const SHARE: u64 = 100;

/// Exact products are not enough: the difference of the two points is rounded before them, which turns the view
/// by 1e-16.
pub(super) fn up_near_view(effort: &Effort) -> Found {
    Found::sweep(6000, decades([-2, -4, -5, -6, -8, -10, -12, -14, -15]), |seed, tilt| {
        tally(effort.rays.div_ceil(SHARE), seed, |random, tally| {
            let points @ [eye, look, up] = tilted(random, tilt);
            let error = match (CameraAxes::new(eye, look, up), own_side(points)) {
                (Some(view), Some(side)) => angle(side, view.right),
                _ => f64::NAN,
            };
            tally.error(error);
        })
    })
}

/// The side vector of the camera of a scene; `None` if the scene is refused.
fn own_side(points: [DVec3; 3]) -> Option<DVec3> {
    let scene = load(&text(&camera(points, 90.0), [64, 64])).scene?;
    Some(scene.view.camera.world_from_camera.matrix().x_axis.truncate())
}

/// An eye, for half of them the origin, a point looked at, and an up vector `tilt` away from the view.
fn tilted(random: &mut Pcg64Mcg, tilt: f64) -> [DVec3; 3] {
    let [eye, look, other] = [0; 3].map(|_| in_cube(random));
    // Of different sizes, so that their difference is rounded.
    let (eye, look) = if other.x < 0.0 { (DVec3::ZERO, look) } else { (0.3 * eye, 17.0 * look) };
    let view = look - eye;
    let across = view.cross(other).normalize();
    [eye, look, 3.0 * (view.normalize() * tilt.cos() + across * tilt.sin())]
}

pub(super) fn far_look(effort: &Effort) -> Found {
    Found::sweep(9000, [1.0, 1e10, 1e20, 1e30], |seed, distance| {
        let near = DVec3::new(1e8, 0.0, 0.0);
        let points = match distance {
            1.0 => [near, near + DVec3::X, DVec3::Z],
            _ => [DVec3::new(1.0, 2.0, 3.0), distance * DVec3::new(0.3, 0.5, -0.8), DVec3::Y],
        };
        let resolution = [1024; 2];
        let exact = pinhole(points, 45.0, resolution);
        let place = |random: &mut _, resolution| anywhere(random, resolution).as_vec2().as_dvec2();
        let camera = camera(points, 45.0);
        directions(effort, seed, (&camera, resolution), place, |film, d| angle(d, exact.direction(film)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn sides_are_right_where_up_is_far_from_the_view() {
        let mut random = Pcg64Mcg::seed_from_u64(1);
        for _ in 0..20 {
            let points = tilted(&mut random, 1.0);
            let truth = CameraAxes::new(points[0], points[1], points[2]).unwrap().right;
            assert!(angle(own_side(points).unwrap(), truth) < 1e-15);
        }
    }

    #[test]
    fn tilts_are_as_asked() {
        let mut random = Pcg64Mcg::seed_from_u64(2);
        let [eye, look, up] = tilted(&mut random, 1e-6);
        let tilt = (look - eye).cross(up).length() / ((look - eye).length() * up.length());
        assert!((tilt / 1e-6 - 1.0).abs() < 1e-6, "{tilt}");
    }
}
