//! Rays from the camera: C1 to C20.

mod exact;
mod film;
mod lens;
mod look_at;
mod messages;
mod perspective;

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::case::{Axis, Case, Family};

pub(super) fn cases() -> Vec<Case> {
    [perspective::cases(), look_at::cases(), lens::cases(), film::cases(), messages::cases()].concat()
}

/// A case that measures nothing, or one to be completed.
fn case(
    id: &'static str,
    name: &'static str,
    claim: &'static str,
    run: fn(&super::Effort) -> super::Found,
) -> Case {
    Case { id, name, family: Family::Camera, claim, axis: Axis::None, error: "", limit: 0.0, run }
}

/// The text of a scene in which only the camera matters; `options` begin on its second line.
fn text(options: &str) -> String {
    format!(
        "# A camera.\n{options}\nSampler \"sobol\" Integrator \"path\"\nWorldBegin\nLightSource \"infinite\"\nWorldEnd\n"
    )
}

/// The directive for an eye, a point looked at and an up vector.
fn look_at(points: [DVec3; 3]) -> String {
    format!("LookAt {}", points.map(|p| format!("{} {} {}", p.x, p.y, p.z)).join("  "))
}

/// A film of which few pixels are rendered, so that it may be of any size.
fn film(resolution: [u32; 2]) -> String {
    let [width, height] = resolution;
    format!(
        "Film \"image\" \"integer xresolution\" {width} \"integer yresolution\" {height} \"float cropwindow\" [.5 .51 .5 .51]"
    )
}

/// Anywhere on the film.
fn anywhere(random: &mut Pcg64Mcg, resolution: [u32; 2]) -> DVec2 {
    DVec2::from(resolution.map(f64::from)) * square(random)
}

/// Anywhere in the unit square.
fn square(random: &mut Pcg64Mcg) -> DVec2 {
    DVec2::new(random.random(), random.random())
}
