//! Screen windows that stretch the picture or show next to nothing, and lenses that blur everything.

use lookat_scene::glam::{DVec2, DVec3};
use lookat_scene::syntax::{Diagnostic, ParamType, Span};
use lookat_scene::{Lens, Projection};

use crate::{Sight, corners, short};

/// Pixels may differ from squares by so much.
const TOLERANCE: f64 = 0.01;

/// A window without `screenwindow` is small where the scene is so many times as large.
const SMALL: f64 = 10.0;
/// The least share of the picture that shapes fill.
const FILLED: f64 = 0.95;
/// The width of the margin around the scene, in sizes of the scene.
const MARGIN: f64 = 0.05;

/// The edges are left, bottom, right and top.
pub fn other_order(sight: &Sight) -> Option<Diagnostic> {
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
pub fn stretched(sight: &Sight) -> Option<Diagnostic> {
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

/// An orthographic camera without a window shows a small part of one shape, or of several large ones.
pub fn small(sight: &Sight) -> Option<Diagnostic> {
    let camera = sight.places.camera.filter(|_| is_orthographic(sight) && sight.is_whole())?;
    let edges = of_scene(sight).filter(|_| sight.places.screen_window.is_none())?;
    let screen = sight.scene.view.camera.screen;
    let (size, shown) =
        (DVec2::new(edges[1] - edges[0], edges[3] - edges[2]), (screen.max - screen.min).abs());
    let seen: Vec<_> = sight.shapes_in_view().collect();
    let is_filled = seen.iter().map(|shape| shape.share).sum::<f64>() >= FILLED;
    let is_large = |bounds: [DVec3; 2]| (bounds[1] - bounds[0]).max_element() >= SMALL * shown.x;
    let is_part = seen.len() == 1 || seen.iter().all(|shape| is_large(shape.bounds));
    if !is_filled || !is_part || size.x < SMALL * shown.x {
        return None;
    }
    let what = if seen.len() == 1 { "one shape fills" } else { "large shapes fill" };
    let message = format!(
        "an orthographic camera without screenwindow shows {} x {} units, and {what} them: the whole scene needs {} x {}",
        short(shown.x),
        short(shown.y),
        short(size.x),
        short(size.y)
    );
    let words = edges.map(short);
    let warning = Diagnostic::warning(camera, message)
        .help(format!("write \"float screenwindow\" [{}] in Camera", words.join(" ")));
    Some(sight.propose(warning, camera, ParamType::Float, "screenwindow", &words))
}

pub fn is_orthographic(sight: &Sight) -> bool {
    matches!(sight.scene.view.camera.projection, Projection::Orthographic { .. })
}

/// The edges of a window of an orthographic camera that shows all shapes, in the shape of the film.
pub fn of_scene(sight: &Sight) -> Option<[f64; 4]> {
    let shown = corners(sight.bounds()?).map(|p| sight.in_camera(p).truncate());
    let low = shown.into_iter().fold(DVec2::INFINITY, DVec2::min);
    let high = shown.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max);
    let resolution = sight.scene.view.film.resolution.map(f64::from);
    let half = (high - low) * (0.5 + MARGIN);
    // As many units along both sides of a pixel.
    let per_pixel = (half.x / resolution[0]).max(half.y / resolution[1]);
    let half = DVec2::from(resolution) * per_pixel;
    let (low, high) = ((low + high) * 0.5 - half, (low + high) * 0.5 + half);
    Some([low.x, high.x, low.y, high.y])
}

/// The place of a screen window that has an effect.
fn place(sight: &Sight) -> Option<Span> {
    sight.places.screen_window.filter(|_| !sight.is_all_around())
}

/// Circles of confusion above this share of the shorter side hide what is shown.
const BLURRED: f64 = 0.05;
/// The least share of what is in view that is to be sharp, and the most blur, in pixels, that counts as sharp.
const LEAST_SHARP: f64 = 0.005;
const SHARP: f64 = 3.0;

/// Nothing in view is sharp.
pub fn blurred(sight: &Sight) -> Option<Diagnostic> {
    let focus = sight.focus?;
    let mut blur: Vec<f64> = sight.facts.depths.iter().map(|depth| focus.blur(*depth)).collect();
    blur.sort_by(f64::total_cmp);
    let sharp = blur.partition_point(|blur| *blur <= SHARP) as f64;
    let median = *blur.get(blur.len() / 2)?;
    if sharp >= LEAST_SHARP * blur.len() as f64 || median < BLURRED * sight.short_side() {
        return None;
    }
    let focal = sight.scene.view.camera.lens?.focal_distance;
    // Reading the file has said that there is none.
    if focal == Lens::UNFOCUSED && sight.places.focal_distance.is_none() {
        return None;
    }
    let message = format!(
        "the lens blurs everything in view: it focuses at {}, and points in view have circles of confusion of {} pixels or more",
        short(focal),
        short(blur[0].floor())
    );
    let depth = sight.facts.center_depth.or_else(|| sight.facts.median_depth())?;
    let [near, far] = [sight.facts.depths.first()?, sight.facts.depths.last()?];
    let camera = &sight.scene.view.camera;
    let opening = if camera.lens_system().is_some() { "aperturediameter" } else { "lensradius" };
    let help = format!(
        "everything in view is {} to {} units away; for a picture that is sharp everywhere, make {opening} smaller",
        short(*near),
        short(*far)
    );
    let place = sight.places.focal_distance.or(sight.places.lens_radius);
    let place = place.unwrap_or_else(|| sight.camera_place());
    let warning = Diagnostic::warning(place, message).help(help);
    Some(match sight.places.focal_distance {
        Some(at) => warning.fix(at, short(depth)),
        None => warning,
    })
}
