//! Directions of a camera without a lens, by its angle of view and its place: C1 to C4.

use glam::{DVec2, DVec3};
use lookat_render::Probe;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::exact::{Pinhole, View, angle, tan_half};
use super::{anywhere, case, film, look_at, text};
use crate::stability::case::{Axis, Case, Effort, Found, LOOKAT};
use crate::stability::methods::{camera as by, double, single};
use crate::stability::tally::{Tally, tally};
use crate::text_scene::scene;

pub(super) fn cases() -> Vec<Case> {
    let degrees = Axis::Of("field of view, degrees");
    vec![
        Case {
            axis: degrees,
            error: "direction, pixels",
            limit: 1e-6,
            ..case(
                "C1",
                "tele",
                "rays of narrow views pass through their points of a film of 16384 pixels",
                tele,
            )
        },
        Case {
            axis: degrees,
            error: "direction, rad",
            limit: 1e-15,
            ..case("C2", "field-of-view", "the directions of usual and narrow views are right", usual)
        },
        Case {
            axis: Axis::Of("180 - field of view, degrees"),
            error: "direction, rad",
            limit: 1e-15,
            ..case("C3", "wide", "the directions of very wide views are right", wide)
        },
        Case {
            axis: Axis::Of("distance of the eye from the origin"),
            error: "direction, pixels",
            limit: 1e-9,
            ..case("C4", "far-eye", "a view does not depend on its place in the world", far_eye)
        },
    ]
}

const METHODS: [&str; 5] = [LOOKAT, "pbrt-v3", "pbrt-v3 in f64", "closed form f32", "closed form f64"];

fn tele(effort: &Effort) -> Found {
    sweep(effort, 1, &[0.001, 0.01, 0.1, 1.0, 10.0, 45.0], |pinhole, film, d| pinhole.pixels(film, d))
}

fn usual(effort: &Effort) -> Found {
    sweep(effort, 2, &[0.001, 0.01, 0.1, 1.0, 10.0, 45.0, 90.0], off_by)
}

fn wide(effort: &Effort) -> Found {
    let mut found = sweep(effort, 3, &[120.0, 150.0, 170.0, 179.0, 179.9, 179.99, 179.999], off_by);
    found.rows.iter_mut().for_each(|row| row.at = row.at.map(|degrees| 180.0 - degrees));
    found
}

fn off_by(pinhole: &Pinhole, film: DVec2, d: DVec3) -> f64 {
    angle(d, pinhole.direction(film))
}

const RESOLUTION: [u32; 2] = [16384; 2];

/// Eye, point looked at and up: numbers that single precision holds.
const LOOK_AT: [DVec3; 3] = [DVec3::new(3.0, 4.0, 5.0), DVec3::new(0.0, 0.5, 0.0), DVec3::Z];

fn sweep(
    effort: &Effort,
    id: u64,
    fields: &[f64],
    error: impl Fn(&Pinhole, DVec2, DVec3) -> f64 + Sync,
) -> Found {
    let mut found = Found::default();
    for (index, fov) in fields.iter().enumerate() {
        let scene = scene(&camera_text(LOOK_AT, *fov, RESOLUTION));
        let probe = Probe::new(&scene);
        let (exact, rounded) = (pinhole(LOOK_AT, *fov), pinhole(LOOK_AT, f64::from(*fov as f32)));
        let (narrow, wide) = (Others::<f32>::new(*fov as f32), Others::<f64>::new(*fov));
        let seed = 1000 * id + index as u64;
        let tallies = tally(effort.rays, seed, |random, tallies: &mut [Tally; 5]| {
            let film = place(random);
            let d = probe.camera_ray(film, DVec2::splat(0.5)).d;
            tallies[0].error(error(&exact, film, d));
            let [matrices, closed] = wide.directions(film.to_array());
            tallies[2].error(error(&exact, film, matrices.into()));
            tallies[4].error(error(&exact, film, closed.into()));
            // The truth for the angle and the place on the film that single precision holds.
            let film = film.as_vec2();
            let [matrices, closed] = narrow.directions(film.to_array());
            tallies[1].error(error(&rounded, film.as_dvec2(), double(matrices)));
            tallies[3].error(error(&rounded, film.as_dvec2(), double(closed)));
        });
        found.add(Some(*fov), &METHODS, &tallies);
    }
    found
}

/// Half of them anywhere on the film, half near its middle, where a wide film leaves few.
fn place(random: &mut Pcg64Mcg) -> DVec2 {
    if random.random::<bool>() {
        return anywhere(random, RESOLUTION);
    }
    let distance = (13.0 - 30.0 * random.random::<f64>()).exp2();
    let direction = DVec2::from_angle(std::f64::consts::TAU * random.random::<f64>());
    DVec2::from(RESOLUTION.map(f64::from)) / 2.0 + distance * direction
}

fn camera_text(at: [DVec3; 3], fov: f64, resolution: [u32; 2]) -> String {
    text(&format!("{}\nCamera \"perspective\" \"float fov\" {fov}\n{}", look_at(at), film(resolution)))
}

fn pinhole([eye, look, up]: [DVec3; 3], fov: f64) -> Pinhole {
    let view = View::new(eye, look, up).expect("these views have a side");
    Pinhole { view, tan: tan_half(fov), resolution: RESOLUTION }
}

/// Other ways to the direction.
struct Others<T> {
    world_from_camera: by::Matrix<T>,
    camera_from_raster: by::Matrix<T>,
    fov: T,
    resolution: [T; 2],
}

impl<T: num_traits::Float + num_traits::FloatConst> Others<T> {
    fn new(fov: T) -> Self {
        let number = |x: f64| T::from(x).expect("every precision holds a rounded number");
        let resolution = RESOLUTION.map(|n| number(f64::from(n)));
        let [eye, look, up] = LOOK_AT.map(|v| v.to_array().map(number));
        Others {
            world_from_camera: by::look_at(eye, look, up).expect("these views have a side"),
            camera_from_raster: by::perspective(fov, by::default_window(resolution), resolution),
            fov,
            resolution,
        }
    }

    /// By matrices, and in closed form.
    fn directions(&self, film: [T; 2]) -> [[T; 3]; 2] {
        let window = by::default_window(self.resolution);
        [by::by_matrices(&self.camera_from_raster, film), by::direct(self.fov, window, self.resolution, film)]
            .map(|d| by::vector(&self.world_from_camera, d))
    }
}

/// The coordinates lose digits in single precision before any formula is used: that is the defect here, so the truth
/// is that of the numbers in the text.
fn far_eye(effort: &Effort) -> Found {
    let mut found = Found::default();
    for exponent in 3..9 {
        let distance = 10_f64.powi(exponent);
        let at = far_look_at(distance);
        let resolution = [1920, 1080];
        let scene = scene(&camera_text(at, 45.0, resolution));
        let probe = Probe::new(&scene);
        let exact = Pinhole { resolution, ..pinhole(at, 45.0) };
        let [eye, look, up] = at.map(single);
        let narrow = (by::look_at(eye, look, up), raster(45.0_f32, [1920.0, 1080.0]));
        let [eye, look, up] = at.map(|v| v.to_array());
        let wide = (by::look_at(eye, look, up), raster(45.0, [1920.0, 1080.0]));
        let seed = 4000 + exponent as u64;
        let tallies = tally(effort.rays, seed, |random, tallies: &mut [Tally; 3]| {
            let film = anywhere(random, resolution);
            let d = probe.camera_ray(film, DVec2::splat(0.5)).d;
            tallies[0].error(exact.pixels(film, d));
            let d = wide.0.map(|world| by::vector(&world, by::by_matrices(&wide.1, film.to_array())));
            tallies[2].error(d.map_or(f64::NAN, |d| exact.pixels(film, d.into())));
            let film = film.as_vec2();
            let d = narrow.0.map(|world| by::vector(&world, by::by_matrices(&narrow.1, film.to_array())));
            tallies[1].error(d.map_or(f64::NAN, |d| exact.pixels(film.as_dvec2(), double(d))));
        });
        found.add(Some(distance), &METHODS[..3], &tallies);
    }
    found
}

fn raster<T: num_traits::Float + num_traits::FloatConst>(fov: T, resolution: [T; 2]) -> by::Matrix<T> {
    by::perspective(fov, by::default_window(resolution), resolution)
}

/// An eye this far away that looks at a point 10 from it; numbers without pattern.
pub(super) fn far_look_at(distance: f64) -> [DVec3; 3] {
    let eye = distance * DVec3::new(0.6180339887, 0.3141592653, 0.7206834121)
        + DVec3::new(0.123456789, 0.23456789, 0.3456789);
    [eye, eye + DVec3::new(6.12345678, 7.0123456, 3.54321), DVec3::Z]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_other_ways_are_right_where_that_is_easy() {
        let exact = pinhole(LOOK_AT, 45.0);
        let (narrow, wide) = (Others::<f32>::new(45.0), Others::<f64>::new(45.0));
        for film in [DVec2::new(0.0, 0.0), DVec2::new(8192.0, 100.0), DVec2::new(16000.0, 12000.0)] {
            for d in wide.directions(film.to_array()) {
                assert!(off_by(&exact, film, d.into()) < 1e-15, "{film}");
            }
            for d in narrow.directions(film.as_vec2().to_array()) {
                assert!(off_by(&exact, film, double(d)) < 1e-6, "{film}");
            }
        }
    }
}
