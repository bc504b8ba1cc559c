//! Shapes of another order of size than the others.

use lookat_scene::glam::DVec3;
use lookat_scene::syntax::Diagnostic;

use super::{Sight, short};

/// A shape that is so many times as large as all others together is a mistake, unless it is a plane or a light.
const GIANT: f64 = 100.0;

/// A shape that dwarfs all others.
pub(super) fn giant(sight: &Sight) -> Option<Diagnostic> {
    let shapes = &sight.facts.shapes;
    let (number, largest) =
        shapes.iter().enumerate().max_by(|(_, a), (_, b)| a.size().total_cmp(&b.size()))?;
    let others = shapes.iter().enumerate().filter(|(other, shape)| *other != number && !shape.is_emitter);
    let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let [low, high] =
        others.fold(nothing, |[low, high], (_, shape)| [low.min(shape.bounds[0]), high.max(shape.bounds[1])]);
    let rest = (high - low).max_element();
    if !(rest > 0.0 && rest.is_finite())
        || largest.is_thin()
        || largest.is_emitter
        || largest.size() < GIANT * rest
    {
        return None;
    }
    // A ground is meant to be large: other shapes are in view in front of it.
    let is_ground = sight.facts.inside != Some(number) && sight.shapes_in_view().count() > 1;
    if is_ground {
        return None;
    }
    let message =
        format!("this shape is {} times as large as all others together", short(largest.size() / rest));
    let help = "check Scale before it, and its own size";
    Some(Diagnostic::warning(largest.span?, message).help(help))
}
