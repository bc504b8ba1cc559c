//! Lights that light nothing, or only in part, and lights in objects.

use super::{Evidence, warn};
use crate::report::Report;
use crate::{MaterialKind, Primitive, Shape};

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    for at in &evidence.facts.lights_in_objects {
        let message = "a LightSource is not part of an object: it shines once, from where it is defined, and ObjectInstance does not copy it";
        let help = "move it before ObjectBegin; pbrt-v3 renders the same picture";
        warn(report, *at, message, help);
    }
    let of_objects = evidence.built.objects.iter().flat_map(|object| &object.primitives);
    for at in of_objects.filter(|primitive| primitive.light().is_some()).filter_map(|it| it.span) {
        let message = "an emissive shape inside an object is visible, but illuminates nothing: move it out of the object";
        report.unsupported(at, message.into());
    }
    let is_curve = |primitive: &&Primitive| matches!(primitive.shape, Shape::Curve(_));
    let emissive = || evidence.built.world.primitives.iter().filter(|primitive| primitive.light().is_some());
    for at in emissive().filter(is_curve).filter_map(|primitive| primitive.span) {
        let message =
            "an emissive curve is visible, but illuminates nothing: use a mesh or a quadric as a light";
        report.unsupported(at, message.into());
    }
    if !evidence.settled.is_some_and(|settled| settled.passes_boundaries) {
        return;
    }
    let is_boundary = |primitive: &&&Primitive| matches!(primitive.material.kind, MaterialKind::None);
    let emissive = evidence.drawn.iter().filter(|primitive| primitive.light().is_some());
    for at in emissive.filter(is_boundary).filter_map(|primitive| primitive.span) {
        let message = "pbrt-v3 lets shadow rays pass this emissive surface without a material, and finds its light by light samples only";
        let help = "write Material \"matte\" \"rgb Kd\" [0 0 0]: lookat and pbrt-v3 then agree";
        warn(report, at, message, help);
    }
}
