//! AreaLightSources that no shape follows.

use lookat_syntax::Span;

use super::{Evidence, warn};
use crate::draft::Slot;
use crate::report::Report;

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    let is_lit =
        |slot: &Slot| evidence.built.primitive(*slot).is_some_and(|primitive| !primitive.shape.is_empty());
    let idle = evidence.facts.emissions.iter().filter(|(_, shapes)| !shapes.iter().any(is_lit));
    let mut idle: Vec<Span> = idle.map(|(at, _)| *at).collect();
    idle.sort_by_key(|at| (at.file, at.start));
    for at in idle {
        let help = "put it before the shape that emits light, in the same block";
        warn(report, at, "no shape follows this AreaLightSource: it emits no light", help);
    }
}
