//! Directions of a camera without a lens, by its angle of view and its place: C1 to C4.

use super::exact::{CameraAxes, Pinhole, angle, tan_half};
use super::{anywhere, directions, film, look_at};
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
    directions(effort, seed, &options(LOOK_AT, fov, RESOLUTION), place, |film, d| error(&exact, film, d))
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

pub(super) fn options(at: [DVec3; 3], fov: f64, resolution: [u32; 2]) -> String {
    format!("{}\nCamera \"perspective\" \"float fov\" {fov}\n{}", look_at(at), film(resolution))
}

pub(super) fn pinhole([eye, look, up]: [DVec3; 3], fov: f64, resolution: [u32; 2]) -> Pinhole {
    let view = CameraAxes::new(eye, look, up).expect("these views have a side");
    Pinhole { view, tan: tan_half(fov), resolution }
}

pub(super) fn far_eye(effort: &Effort) -> Found {
    Found::sweep(4000, decades(3..9), |seed, distance| {
        let (at, resolution) = (far_look_at(distance), [1920, 1080]);
        let exact = pinhole(at, 45.0, resolution);
        let place = |random: &mut _| anywhere(random, resolution);
        directions(effort, seed, &options(at, 45.0, resolution), place, |film, d| exact.pixels(film, d))
    })
}

/// An eye this far away that looks at a point 10 from it; numbers without pattern.
pub(super) fn far_look_at(distance: f64) -> [DVec3; 3] {
    let eye = distance * DVec3::new(0.6180339887, 0.3141592653, 0.7206834121)
        + DVec3::new(0.123456789, 0.23456789, 0.3456789);
    [eye, eye + DVec3::new(6.12345678, 7.0123456, 3.54321), DVec3::Z]
}
