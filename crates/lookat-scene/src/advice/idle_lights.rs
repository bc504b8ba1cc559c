//! AreaLightSources without a shape that can be drawn.

use lookat_syntax::Span;

use super::{Evidence, warn};
use crate::draft::Slot;
use crate::report::Report;

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    let is_drawn = |slot: &Slot| {
        evidence.built.primitive(*slot).is_some_and(|primitive| !primitive.shape.is_invisible())
    };
    let idle = evidence.facts.emissions.iter().filter(|(_, shapes)| !shapes.iter().any(is_drawn));
    let mut idle: Vec<(Span, bool)> = idle.map(|(at, shapes)| (*at, shapes.is_empty())).collect();
    idle.sort_by_key(|(at, _)| (at.file, at.start));
    for (at, is_alone) in idle {
        let (message, help) = match is_alone {
            true => (
                "no shape follows this AreaLightSource: it emits no light",
                "put it before the shape that emits light, in the same block",
            ),
            false => (
                "this AreaLightSource emits no light: nothing of its shapes can be drawn",
                "it needs a shape with an area",
            ),
        };
        warn(report, at, message, help);
    }
}
