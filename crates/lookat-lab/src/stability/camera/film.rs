//! Where pixels are on the screen, mirrored and scaled cameras, and how numbers are read: C14 to C19.

use twofloat::TwoFloat;

use super::exact::{CameraAxes, Pinhole, angle, tan_half};
use super::{anywhere, directions, text};
use crate::stability::prelude::*;

pub(super) fn off_center(effort: &Effort) -> Found {
    let resolution = [3000; 2];
    Found::sweep(14_000, [1.0, 1e2, 1e4, 1e6], |seed, center| {
        let (low, high): (f64, f64) = (center - 0.5, center + 0.5);
        let camera = format!("Camera \"orthographic\" \"float screenwindow\" [{low} {high} {low} {high}]");
        let probe = probe(&text(&camera, resolution));
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
    let tally = directions(effort, 16_000, (camera, resolution), anywhere, |film, d| {
        let x = TwoFloat::new_sub(2.0 * film.x, 640.0) / 640.0;
        let y = TwoFloat::new_sub(480.0, 2.0 * film.y) / 480.0;
        angle(d, CameraAxes::CAMERA_SPACE.world(x, y, TwoFloat::from(1.0)))
    });
    Found::own(None, tally)
}

pub(super) fn portrait(effort: &Effort) -> Found {
    let camera = "Camera \"perspective\" \"float fov\" 90";
    let one = |seed, resolution| {
        let exact = Pinhole { view: CameraAxes::CAMERA_SPACE, tan: tan_half(90.0), resolution };
        directions(effort, seed, (camera, resolution), anywhere, |film, d| angle(d, exact.direction(film)))
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
        let camera = format!("Scale {} {scale} {scale} {camera}", sign * scale);
        directions(effort, seed, (&camera, resolution), anywhere, |film, d| {
            let mirrored = if sign < 0.0 { DVec2::new(640.0 - film.x, film.y) } else { film };
            angle(d, exact.direction(mirrored)).max((d.length() - 1.0).abs())
        })
    })
}

/// A reversed window turns the picture.
pub(super) fn screen_window(_: &Effort) -> Found {
    let mut found = refused("C15");
    for kind in ["perspective", "orthographic"] {
        let [plain, reversed] = ["[-1 1 -1 1]", "[1 -1 1 -1]"].map(|edges| {
            probe(&text(&format!("Camera \"{kind}\" \"float screenwindow\" {edges}"), [64, 48]))
        });
        for film in [DVec2::new(0.0, 0.0), DVec2::new(5.0, 40.0), DVec2::new(63.5, 1.25)] {
            let u = DVec2::splat(0.5);
            let (a, b) = (plain.camera_ray(film, u), reversed.camera_ray(DVec2::new(64.0, 48.0) - film, u));
            let is_mirrored = (a.d - b.d).length().max((a.o - b.o).length()) < 1e-15;
            found.check(is_mirrored, || format!("{kind}, reversed window: {a:?} is not {b:?}"));
        }
    }
    found
}

/// Decimal numbers are read as the nearest number with 53 bits.
pub(super) fn numbers(_: &Effort) -> Found {
    let mut found = refused("C19");
    let exact = [
        ("100000000000000000000", 1e20),
        ("-9223372036854775809", -9223372036854775808.0),
        ("9007199254740993", 9007199254740992.0),
        ("9007199254740993.00000000000000000001", 9007199254740994.0),
        (".1", f64::from_bits(0x3FB9_9999_9999_999A)),
        ("+1.25e-3", 0.00125),
        ("16777217", 16777217.0),
        ("1E+22", 1e22),
    ];
    for (number, value) in exact {
        let scene = scene(&text(&format!("Translate {number} 0 0 Camera \"perspective\""), [64, 48]));
        let read = -scene.view.camera.world_from_camera.matrix().w_axis.x;
        found.check(read == value, || format!("{number} is read as {read:?}, not {value:?}"));
    }
    found
}
