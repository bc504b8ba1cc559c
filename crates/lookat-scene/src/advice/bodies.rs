//! Advice about surfaces that light enters to leave them at other points.

use crate::advice::{Summary, warn};
use crate::report::Report;
use crate::{Integrator, MaterialKind, Primitive, Shape};

pub(super) fn bodies(summary: &Summary, report: &mut Report) {
    let has_inside = |primitive: &&&Primitive| primitive.material.inside().is_some();
    let drawn = || summary.drawn.iter().filter(has_inside);
    match summary.integrator() {
        Some(Integrator::Path { .. }) => {}
        Some(Integrator::DirectLighting { .. }) => {
            if let Some(at) = drawn().find_map(|primitive| primitive.material.span) {
                let message =
                    "this integrator does not look inside of surfaces, as in pbrt-v3: it renders clear glass";
                warn(report, at, message, "write Integrator \"path\"");
            }
            return;
        }
        _ => return,
    }
    let is_mix = |primitive: &&&Primitive| matches!(primitive.material.kind, MaterialKind::Mix(_));
    let mut mixes: Vec<_> = drawn().filter(is_mix).filter_map(|primitive| primitive.material.span).collect();
    mixes.dedup();
    for at in mixes {
        let message =
            "pbrt-v3 loses the light that enters a mix with subsurface scattering, or lets it through";
        warn(report, at, message, "mix the colors with a texture: lookat and pbrt-v3 then agree");
    }
    let is_inside_out = |primitive: &&&Primitive| {
        matches!(primitive.shape, Shape::Quadric(_)) && primitive.reverse_orientation != primitive.mirrored
    };
    for at in drawn().filter(is_inside_out).filter_map(|primitive| primitive.span) {
        let message = "the normals of this shape point inside: in pbrt-v3 no light leaves its material";
        let help = "ReverseOrientation, or a mirroring transformation, turns normals; with one more, lookat and pbrt-v3 agree";
        warn(report, at, message, help);
    }
}
