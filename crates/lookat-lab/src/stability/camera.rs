//! Rays from the camera: C1 to C20.

mod exact;
mod film;
mod lens;
mod perspective;

use crate::stability::prelude::*;

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("C1", perspective::tele),
    ("C2", perspective::usual),
    ("C3", perspective::wide),
    ("C4", perspective::far_eye),
    ("C5", lens::collapse),
    ("C6", perspective::up_near_view),
    ("C7", |_| refused("C7")),
    ("C8", |_| refused("C8")),
    ("C9", perspective::far_look),
    ("C10", lens::focal_distance),
    ("C11", |_| refused("C11")),
    ("C12", lens::lens_radius),
    ("C13", lens::telecentric),
    ("C14", film::off_center),
    ("C15", film::screen_window),
    ("C16", film::window),
    ("C17", film::portrait),
    ("C18", film::scaled),
    ("C19", film::numbers),
    ("C20", |_| refused("C20")),
];

/// The text of a scene in which only the camera matters. Few pixels of the film are rendered, so that it may be of any size.
fn text(camera: &str, [width, height]: [u32; 2]) -> String {
    let size = format!("\"integer xresolution\" {width} \"integer yresolution\" {height}");
    let film = format!("Film \"image\" {size} \"float cropwindow\" [.5 .51 .5 .51]");
    format!(
        "{camera} {film} Sampler \"sobol\" Integrator \"path\" WorldBegin LightSource \"infinite\" WorldEnd"
    )
}

/// The directive for an eye, a point looked at and an up vector.
fn look_at(points: [DVec3; 3]) -> String {
    format!("LookAt {}", points.map(xyz).join("  "))
}

/// The largest error of the directions of a scene's camera at places of the film.
fn directions(
    effort: &Effort,
    seed: u64,
    (camera, resolution): (&str, [u32; 2]),
    place: fn(&mut Pcg64Mcg, [u32; 2]) -> DVec2,
    error: impl Fn(DVec2, DVec3) -> f64 + Sync,
) -> Tally {
    let probe = probe(&text(camera, resolution));
    tally(effort.rays, seed, |random, tally| {
        let film = place(random, resolution);
        tally.error(error(film, probe.camera_ray(film, DVec2::splat(0.5)).d));
    })
}

/// Anywhere on the film.
fn anywhere(random: &mut Pcg64Mcg, resolution: [u32; 2]) -> DVec2 {
    DVec2::from(resolution.map(f64::from)) * square(random)
}

/// Anywhere in the unit square.
fn square(random: &mut Pcg64Mcg) -> DVec2 {
    DVec2::new(random.random(), random.random())
}
