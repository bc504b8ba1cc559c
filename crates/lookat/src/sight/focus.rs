//! Lenses that blur everything.

use lookat_scene::Lens;
use lookat_scene::syntax::Diagnostic;

use super::{Sight, short};

/// Circles of confusion above this share of the shorter side hide what is shown.
const BLURRED: f64 = 0.05;
/// The least share of what is in view that is to be sharp, and the most blur, in pixels, that counts as sharp.
const LEAST_SHARP: f64 = 0.005;
const SHARP: f64 = 3.0;

/// Nothing in view is sharp.
pub(super) fn blurred(sight: &Sight) -> Option<Diagnostic> {
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
    let help = format!(
        "everything in view is {} to {} units away; for a picture that is sharp everywhere, make lensradius smaller",
        short(*near),
        short(*far)
    );
    let warning = Diagnostic::warning(sight.lens_place(), message).help(help);
    Some(match sight.places.focal_distance {
        Some(at) => warning.fix(at, short(depth)),
        None => warning,
    })
}
