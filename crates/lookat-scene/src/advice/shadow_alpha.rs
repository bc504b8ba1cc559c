//! `shadowalpha` with light of a sky or a shape. Light of point, spot and distant lights passes by the same amount in
//! pbrt-v3 and lookat.

use super::{Evidence, warn};
use crate::Light;
use crate::report::Report;

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    let world = &evidence.built.world;
    let has_other = !world.lights.iter().all(Light::is_delta)
        || world.primitives.iter().any(|primitive| primitive.light().is_some());
    if let Some(at) = evidence.facts.shadow_alpha.filter(|_| has_other) {
        let message = "light of skies and shapes passes \"shadowalpha\" only partly, and by different amounts in pbrt-v3 and lookat";
        warn(report, at, message, "to make holes for all light, use \"alpha\" instead");
    }
}
