//! Where pixels are on the screen, and mirrored and scaled cameras: C14 and C16 to C18.

use twofloat::TwoFloat;

use super::exact::{CameraAxes, Pinhole, angle, tan_half};
use super::{anywhere, directions, film, text};
use crate::stability::prelude::*;

pub(super) fn off_center(effort: &Effort) -> Found {
    let resolution = [3000; 2];
    Found::sweep(14_000, [1.0, 1e2, 1e4, 1e6], |seed, center| {
        let (low, high): (f64, f64) = (center - 0.5, center + 0.5);
        let scene = scene(&text(&format!(
            "Camera \"orthographic\" \"float screenwindow\" [{low} {high} {low} {high}]\n{}",
            film(resolution)
        )));
        let probe = Probe::new(&scene);
        tally(effort.rays, seed, |random, tally| {
            let film = anywhere(random, resolution);
            let (o, eye) = (probe.camera_ray(film, DVec2::splat(0.5)).o, probe.origin());
            let dx = (TwoFloat::new_add(o.x, eye.x) - low) * 3000.0 - film.x;
            let dy = (TwoFloat::from(high) - TwoFloat::new_add(o.y, eye.y)) * 3000.0 - film.y;
            tally.error(f64::from(dx).hypot(f64::from(dy)));
        })
    })
}

pub(super) fn window(effort: &Effort) -> Found {
    let resolution = [640, 480];
    // Window and film differ in aspect: a height of 3/4 of what the film would have.
    let camera = "Camera \"perspective\" \"float frameaspectratio\" 3 \"float screenwindow\" [-1 1 -1 1]";
    let options = format!("{camera}\n{}", film(resolution));
    let place = |random: &mut _| anywhere(random, resolution);
    let tally = directions(effort, 16_000, &options, place, |film, d| {
        let x = TwoFloat::new_sub(2.0 * film.x, 640.0) / 640.0;
        let y = TwoFloat::new_sub(480.0, 2.0 * film.y) / 480.0;
        angle(d, CameraAxes::CAMERA_SPACE.world(x, y, TwoFloat::from(1.0)))
    });
    Found::own(None, tally)
}

pub(super) fn portrait(effort: &Effort) -> Found {
    let one = |seed, resolution| {
        let options = format!("Camera \"perspective\" \"float fov\" 90\n{}", film(resolution));
        let exact = Pinhole { view: CameraAxes::CAMERA_SPACE, tan: tan_half(90.0), resolution };
        let place = |random: &mut _| anywhere(random, resolution);
        directions(effort, seed, &options, place, |film, d| angle(d, exact.direction(film)))
    };
    Found::own(None, one(17_000, [480, 640]).join(one(17_001, [640, 480])))
}

pub(super) fn scaled(effort: &Effort) -> Found {
    let resolution = [640, 480];
    let camera = "LookAt 3 4 5  0 .5 0  0 0 1\nCamera \"perspective\" \"float fov\" 60";
    let view = CameraAxes::new((3.0, 4.0, 5.0).into(), (0.0, 0.5, 0.0).into(), (0.0, 0.0, 1.0).into());
    let exact = Pinhole { view: view.expect("this view has a side"), tan: tan_half(60.0), resolution };
    Found::sweep(18_000, [1.0_f64, 10.0, 1e10, 1e-10, 1e20, 1e-20], |seed, scale| {
        // Every second one is mirrored.
        let sign = if seed % 2 == 0 { -1.0 } else { 1.0 };
        let options = format!("Scale {} {scale} {scale}\n{camera}\n{}", sign * scale, film(resolution));
        let place = |random: &mut _| anywhere(random, resolution);
        directions(effort, seed, &options, place, |film, d| {
            let mirrored = if sign < 0.0 { DVec2::new(640.0 - film.x, film.y) } else { film };
            angle(d, exact.direction(mirrored)).max((d.length() - 1.0).abs())
        })
    })
}
