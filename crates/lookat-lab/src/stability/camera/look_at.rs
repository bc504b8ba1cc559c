//! The axes that `LookAt` gives: C6 and C9.

use super::exact::{CameraAxes, angle};
use super::perspective::{options, pinhole};
use super::{anywhere, directions, film, look_at, text};
use crate::stability::prelude::*;

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
    let options = format!("{}\nCamera \"perspective\" {}", look_at(points), film([64, 64]));
    let scene = load(&text(&options)).scene?;
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
        let place = |random: &mut _| anywhere(random, resolution).as_vec2().as_dvec2();
        let options = options(points, 45.0, resolution);
        directions(effort, seed, &options, place, |film, d| angle(d, exact.direction(film)))
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
