//! Where pixels are on the screen, and mirrored and scaled cameras: C14 and C16 to C18.

use glam::DVec2;
use lookat_render::Probe;
use lookat_scene::Scene;
use twofloat::TwoFloat;

use super::exact::{Pinhole, View, angle, tan_half};
use super::{anywhere, case, film, text};
use crate::stability::case::{Axis, Case, Effort, Found, LOOKAT};
use crate::stability::methods::camera as by;
use crate::stability::tally::{Tally, tally};
use crate::text_scene::scene;

pub(super) fn cases() -> Vec<Case> {
    let exact = |case| Case { error: "direction, rad", limit: 1e-15, ..case };
    vec![
        Case {
            axis: Axis::Of("center of the window / its width"),
            error: "place, pixels",
            limit: 1e-5,
            ..case("C14", "off-center", "an orthographic window may be far from the middle", off_center)
        },
        exact(case(
            "C16",
            "window-and-frame",
            "screenwindow replaces frameaspectratio, as in pbrt-v3",
            window,
        )),
        exact(case("C17", "portrait", "the field of view applies to the shorter side of the film", portrait)),
        Case {
            axis: Axis::Of("scale of the camera"),
            error: "| |d| - 1 |, or direction, rad",
            limit: 1e-15,
            ..case("C18", "scaled", "cameras may be mirrored and scaled; directions stay normalized", scaled)
        },
    ]
}

fn off_center(effort: &Effort) -> Found {
    const METHODS: [&str; 3] = [LOOKAT, "pbrt-v3", "pbrt-v3 in f64"];
    let resolution = [3000; 2];
    let size = [3000.0; 2];
    let mut found = Found::default();
    for (seed, center) in (14_000..).zip([1.0, 1e2, 1e4, 1e6]) {
        let (low, high): (f64, f64) = (center - 0.5, center + 0.5);
        let scene = scene(&text(&format!(
            "Camera \"orthographic\" \"float screenwindow\" [{low} {high} {low} {high}]\n{}",
            film(resolution)
        )));
        let probe = Probe::new(&scene);
        // Single precision holds the edges; what it makes of the places between them is the question.
        let narrow = by::orthographic([low, high, low, high].map(|x| x as f32), [3000.0; 2]);
        let wide = by::orthographic([low, high, low, high], size);
        let tallies = tally(effort.rays, seed, |random, tallies: &mut [Tally; 3]| {
            let film = anywhere(random, resolution).as_vec2();
            let (x, y) = (f64::from(film.x), f64::from(film.y));
            let off = |place: [TwoFloat; 2]| {
                let dx = (place[0] - low) * 3000.0 - x;
                let dy = (TwoFloat::from(high) - place[1]) * 3000.0 - y;
                f64::from(dx).hypot(f64::from(dy))
            };
            let o = probe.camera_ray(DVec2::new(x, y), DVec2::splat(0.5)).o;
            let eye = probe.origin();
            tallies[0].error(off([TwoFloat::new_add(o.x, eye.x), TwoFloat::new_add(o.y, eye.y)]));
            let p = by::point(&narrow, [film.x, film.y, 0.0]);
            tallies[1].error(off([f64::from(p[0]).into(), f64::from(p[1]).into()]));
            let p = by::point(&wide, [x, y, 0.0]);
            tallies[2].error(off([p[0].into(), p[1].into()]));
        });
        found.add(Some(center), &METHODS, &tallies);
    }
    found
}

fn window(effort: &Effort) -> Found {
    let resolution = [640, 480];
    // Window and film differ in aspect: a height of 3/4 of what the film would have.
    let scene = scene(&text(&format!(
        "Camera \"perspective\" \"float frameaspectratio\" 3 \"float screenwindow\" [-1 1 -1 1]\n{}",
        film(resolution)
    )));
    against(effort, 16_000, &scene, |film| {
        let x = TwoFloat::new_sub(2.0 * film.x, 640.0) / 640.0;
        let y = TwoFloat::new_sub(480.0, 2.0 * film.y) / 480.0;
        View::CAMERA_SPACE.world(x, y, TwoFloat::from(1.0))
    })
}

fn portrait(effort: &Effort) -> Found {
    let mut found = Found::default();
    for (seed, resolution) in (17_000..).zip([[480, 640], [640, 480]]) {
        let scene = scene(&text(&format!("Camera \"perspective\" \"float fov\" 90\n{}", film(resolution))));
        let exact = Pinhole { view: View::CAMERA_SPACE, tan: tan_half(90.0), resolution };
        found.rows.extend(against(effort, seed, &scene, |film| exact.direction(film)).rows);
    }
    found
}

/// Compares the directions of a scene's camera with true ones.
fn against(
    effort: &Effort,
    seed: u64,
    scene: &Scene,
    truth: impl Fn(DVec2) -> crate::stability::truth::Wide + Sync,
) -> Found {
    let probe = Probe::new(scene);
    let tallies = tally(effort.rays, seed, |random, tallies: &mut [Tally; 1]| {
        let film = anywhere(random, scene.view.film.resolution);
        tallies[0].error(angle(probe.camera_ray(film, DVec2::splat(0.5)).d, truth(film)));
    });
    let mut found = Found::default();
    found.add(None, &[LOOKAT], &tallies);
    found
}

fn scaled(effort: &Effort) -> Found {
    let resolution = [640, 480];
    let mut found = Found::default();
    let camera = "LookAt 3 4 5  0 .5 0  0 0 1\nCamera \"perspective\" \"float fov\" 60";
    let view = View::new((3.0, 4.0, 5.0).into(), (0.0, 0.5, 0.0).into(), (0.0, 0.0, 1.0).into());
    let exact = Pinhole { view: view.expect("this view has a side"), tan: tan_half(60.0), resolution };
    for (seed, scale) in (18_000..).zip([1.0_f64, 10.0, 1e10, 1e-10, 1e20, 1e-20]) {
        // Every second one is mirrored.
        let sign = if seed % 2 == 0 { -1.0 } else { 1.0 };
        let before = format!("Scale {} {scale} {scale}", sign * scale);
        let scene = scene(&text(&format!("{before}\n{camera}\n{}", film(resolution))));
        let probe = Probe::new(&scene);
        let tallies = tally(effort.rays, seed, |random, tallies: &mut [Tally; 2]| {
            let film = anywhere(random, resolution);
            let d = probe.camera_ray(film, DVec2::splat(0.5)).d;
            let mirrored = if sign < 0.0 { DVec2::new(640.0 - film.x, film.y) } else { film };
            tallies[0].error(angle(d, exact.direction(mirrored)).max((d.length() - 1.0).abs()));
            // pbrt-v3 applies the matrix and leaves the length (PBR 6.1).
            tallies[1].error(f64::abs(1.0 / scale - 1.0));
        });
        found.add(Some(scale), &[LOOKAT, "pbrt-v3"], &tallies);
    }
    found
}
