//! Worlds without shapes, where only infinite lights are visible.

use super::{Evidence, warn};
use crate::Light;
use crate::report::Report;

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    let world = &evidence.built.world;
    if evidence.settled.is_none() || !world.primitives.is_empty() || !world.instances.is_empty() {
        return;
    }
    if let Some(passed) = evidence.facts.passed {
        let help =
            "this Integrator ignores shapes without a material: write Material \"matte\" before the shapes";
        warn(report, passed, "no shape has a material: all shapes are invisible", help);
    } else if !world.lights.is_empty() && world.lights.iter().all(Light::is_delta) {
        let at = evidence.facts.world_begin.unwrap_or(evidence.end);
        let help = "add a shape: Shape \"sphere\" is a sphere of radius 1 at the origin of the current transformation";
        warn(report, at, "the world has no shapes: the picture is black", help);
    }
}
