//! Screen windows that stretch the picture, or are written in another order.

use lookat_scene::glam::DVec2;
use lookat_scene::syntax::{Diagnostic, Span};

use super::{Sight, short};

/// Pixels may differ from squares by so much.
const TOLERANCE: f64 = 0.01;

/// The edges are left, bottom, right and top.
pub(super) fn other_order(sight: &Sight) -> Option<Diagnostic> {
    let at = place(sight)?;
    let [a, b, c, d] = sight.scene.view.camera.screen.edges();
    let is_reversed = b < a || d < c;
    if !(is_reversed && a < c && b < d) {
        return None;
    }
    let message = "the screen window is reversed: its edges may be in the order xmin ymin xmax ymax";
    let help = "write the edges as xmin xmax ymin ymax";
    Some(Diagnostic::warning(at, message).help(help).fix(at, format!("[{a} {c} {b} {d}]")))
}

/// Pixels are not square.
pub(super) fn stretched(sight: &Sight) -> Option<Diagnostic> {
    let at = place(sight)?;
    let (screen, film) = (sight.scene.view.camera.screen, &sight.scene.view.film);
    let size = screen.max - screen.min;
    let resolution = DVec2::new(f64::from(film.resolution[0]), f64::from(film.resolution[1]));
    let pixel = (size / resolution).abs();
    let ratio = pixel.x / pixel.y;
    if (ratio - 1.0).abs() <= TOLERANCE {
        return None;
    }
    let (longer, way) = if ratio > 1.0 { (ratio, "high") } else { (1.0 / ratio, "wide") };
    let message = format!(
        "pixels are not square: the picture shows everything {} times as {way} as it is",
        short(longer)
    );
    // The edges along the shorter side stay.
    let (mut low, mut high) = (screen.min, screen.max);
    let middle = (low + high) * 0.5;
    if resolution.x >= resolution.y {
        let half = 0.5 * size.y.abs() * resolution.x / resolution.y * size.x.signum();
        (low.x, high.x) = (middle.x - half, middle.x + half);
    } else {
        let half = 0.5 * size.x.abs() * resolution.y / resolution.x * size.y.signum();
        (low.y, high.y) = (middle.y - half, middle.y + half);
    }
    let edges = [low.x, high.x, low.y, high.y].map(short).join(" ");
    let help =
        format!("the film is {} x {} pixels: choose a window of the same shape", resolution.x, resolution.y);
    Some(Diagnostic::warning(at, message).help(help).fix(at, format!("[{edges}]")))
}

/// The place of a screen window that has an effect.
fn place(sight: &Sight) -> Option<Span> {
    sight.places.screen_window.filter(|_| !sight.is_all_around())
}
