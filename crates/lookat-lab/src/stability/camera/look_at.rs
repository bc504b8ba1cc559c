//! The axes that `LookAt` gives: C6 and C9.

use glam::{DVec2, DVec3};
use lookat_render::Probe;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::exact::{Pinhole, View, angle, tan_half};
use super::{anywhere, case, film, look_at, text};
use crate::stability::case::{Axis, Case, Effort, Found, LOOKAT};
use crate::stability::methods::{camera as by, double, single};
use crate::stability::tally::{Tally, tally};
use crate::text_scene::{load, scene};

pub(super) fn cases() -> Vec<Case> {
    vec![
        Case {
            axis: Axis::Of("angle between up and view, rad"),
            error: "direction of the side vector, rad",
            limit: 5e-16,
            ..case(
                "C6",
                "up-near-view",
                "LookAt is right even if its up vector is almost parallel to the view",
                up_near_view,
            )
        },
        Case {
            axis: Axis::Of("distance of the target"),
            error: "direction, rad",
            limit: 1e-15,
            ..case("C9", "far-look", "LookAt is right at any distance of its target", far_look)
        },
    ]
}

/// Each try reads a scene: there are fewer of them.
const SHARE: u64 = 100;

/// Exact products are not enough: the difference of the two points is rounded before them, which turns the view
/// by 1e-16.
fn up_near_view(effort: &Effort) -> Found {
    const METHODS: [&str; 4] = [LOOKAT, "pbrt-v3", "pbrt-v3 in f64", "Kahan f64"];
    let mut found = Found::default();
    for exponent in [2, 4, 5, 6, 8, 10, 12, 14, 15] {
        let tilt = 10_f64.powi(-exponent);
        let tries = effort.rays.div_ceil(SHARE);
        let tallies = tally(tries, 6000 + exponent as u64, |random, tallies: &mut [Tally; 4]| {
            let points = tilted(random, tilt);
            let [eye, look, up] = points;
            let truth = View::new(eye, look, up);
            let error = |truth: Option<View>, side: Option<DVec3>| match (truth, side) {
                (Some(view), Some(side)) => angle(side, view.right),
                _ => f64::NAN,
            };
            tallies[0].error(error(truth, own_side(points)));
            let [a, b, c] = points.map(|v| v.to_array());
            tallies[2].error(error(truth, by::look_at(a, b, c).map(|m| side(&m).into())));
            tallies[3].error(error(truth, Some(by::side_by_kahan(a, b, c).into())));
            // The truth for the numbers that single precision holds. Where they leave no side at all, it is too coarse.
            let [a, b, c] = points.map(single);
            let truth = View::new(double(a), double(b), double(c));
            tallies[1].error(error(truth, by::look_at(a, b, c).map(|m| double(side(&m)))));
        });
        found.add(Some(tilt), &METHODS, &tallies);
    }
    found
}

/// The side vector of the camera of a scene; `None` if the scene is refused.
fn own_side(points: [DVec3; 3]) -> Option<DVec3> {
    let options = format!("{}\nCamera \"perspective\" {}", look_at(points), film([64, 64]));
    let scene = load(&text(&options)).scene?;
    Some(scene.view.camera.world_from_camera.m.x_axis.truncate())
}

fn side<T: num_traits::Float>(world_from_camera: &by::Matrix<T>) -> [T; 3] {
    std::array::from_fn(|i| world_from_camera[i][0])
}

/// An eye, for half of them the origin, a point looked at, and an up vector `tilt` away from the view.
fn tilted(random: &mut Pcg64Mcg, tilt: f64) -> [DVec3; 3] {
    let mut point = || DVec3::from_array(std::array::from_fn(|_| 2.0 * random.random::<f64>() - 1.0));
    let (eye, look, other) = (point(), point(), point());
    // Of different sizes, so that their difference is rounded.
    let (eye, look) = if other.x < 0.0 { (DVec3::ZERO, look) } else { (0.3 * eye, 17.0 * look) };
    let view = look - eye;
    let across = view.cross(other).normalize();
    [eye, look, 3.0 * (view.normalize() * tilt.cos() + across * tilt.sin())]
}

fn far_look(effort: &Effort) -> Found {
    const METHODS: [&str; 3] = [LOOKAT, "pbrt-v3", "pbrt-v3 in f64"];
    let far = |distance: f64| [DVec3::new(1.0, 2.0, 3.0), distance * DVec3::new(0.3, 0.5, -0.8), DVec3::Y];
    let near = DVec3::new(1e8, 0.0, 0.0);
    let places =
        [(1.0, [near, near + DVec3::X, DVec3::Z]), (1e10, far(1e10)), (1e20, far(1e20)), (1e30, far(1e30))];
    let mut found = Found::default();
    for (seed, (distance, points)) in (9000..).zip(places) {
        let resolution = [1024; 2];
        let camera = "Camera \"perspective\" \"float fov\" 45";
        let options = format!("{}\n{camera}\n{}", look_at(points), film(resolution));
        let scene = scene(&text(&options));
        let probe = Probe::new(&scene);
        let [eye, look, up] = points;
        let view = View::new(eye, look, up).expect("these views have a side");
        let exact = Pinhole { view, tan: tan_half(45.0), resolution };
        // What `f32` makes of the numbers is the question here: the truth is that of the text.
        let [a, b, c] = points.map(single);
        let narrow = by::look_at(a, b, c);
        let [a, b, c] = points.map(|v| v.to_array());
        let wide = by::look_at(a, b, c);
        let tallies = tally(effort.rays, seed, |random, tallies: &mut [Tally; 3]| {
            let film = anywhere(random, resolution).as_vec2();
            let truth = exact.direction(film.as_dvec2());
            tallies[0].error(angle(probe.camera_ray(film.as_dvec2(), DVec2::splat(0.5)).d, truth));
            let window = [-1.0, 1.0, -1.0, 1.0];
            let d = by::direct(45.0, window, [1024.0; 2], film.to_array());
            let d = narrow.map(|world| double(by::vector(&world, d)));
            tallies[1].error(d.map_or(f64::NAN, |d| angle(d, truth)));
            let d = by::direct(45.0, window.map(f64::from), [1024.0; 2], film.as_dvec2().to_array());
            let d = wide.map(|world| by::vector(&world, d).into());
            tallies[2].error(d.map_or(f64::NAN, |d| angle(d, truth)));
        });
        found.add(Some(distance), &METHODS, &tallies);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn all_sides_agree_where_up_is_far_from_the_view() {
        let mut random = Pcg64Mcg::seed_from_u64(1);
        for _ in 0..20 {
            let points = tilted(&mut random, 1.0);
            let truth = View::new(points[0], points[1], points[2]).unwrap().right;
            let [a, b, c] = points.map(|v| v.to_array());
            assert!(angle(own_side(points).unwrap(), truth) < 1e-15);
            assert!(angle(side(&by::look_at(a, b, c).unwrap()).into(), truth) < 1e-15);
            assert!(angle(by::side_by_kahan(a, b, c).into(), truth) < 1e-15);
            let [a, b, c] = points.map(single);
            assert!(angle(double(side(&by::look_at(a, b, c).unwrap())), truth) < 1e-5);
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
