//! Worlds in which nothing can be drawn.

use lookat_syntax::Diagnostic;

use super::{Evidence, warn};
use crate::report::Report;
use crate::{Integrator, Light, Primitive, Shape};

/// The most shapes that are named.
const MOST_NAMED: usize = 3;

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    if evidence.settled.is_none() || !evidence.drawn.is_empty() {
        return;
    }
    if let Some(passed) = evidence.facts.passed {
        let help =
            "this Integrator ignores shapes without a material: write Material \"matte\" before the shapes";
        warn(report, passed, "no shape has a material: all shapes are invisible", help);
        return;
    }
    let world = &evidence.built.world;
    let ignores_lights = matches!(evidence.integrator(), Some(Integrator::AmbientOcclusion { .. }));
    let picture = match ignores_lights || world.lights.iter().all(Light::is_delta) {
        true => "the picture is black",
        false => "only infinite lights are visible",
    };
    let Some(first) = world.shapes().next() else {
        let help = match evidence.facts.objects.is_empty() {
            true => {
                "add a shape: Shape \"sphere\" is a sphere of radius 1 at the origin of the current transformation"
            }
            false => "shapes in an object are definitions: place them with ObjectInstance",
        };
        warn(report, evidence.world(), format!("the world has no shapes: {picture}"), help);
        return;
    };
    let message = format!("no shape of the world can be drawn: {picture}");
    let warning = Diagnostic::warning(evidence.world(), message);
    let named =
        world.shapes().take(MOST_NAMED).filter_map(|primitive| Some((primitive.span?, why(primitive))));
    let warning = named.fold(warning, |warning, (at, why)| warning.related(at, why));
    report.push(warning.help(match first.shape.is_empty() {
        true => "give the mesh triangles",
        false => "check the corners and the indices: three corners of a triangle lie on a line or coincide",
    }));
}

/// Why a mesh cannot be drawn.
fn why(primitive: &Primitive) -> String {
    match &primitive.shape {
        Shape::TriangleMesh(mesh) if mesh.triangles() == 1 => "its triangle has no area".into(),
        Shape::TriangleMesh(mesh) if mesh.triangles() > 0 => {
            format!("none of its {} triangles has an area", mesh.triangles())
        }
        _ => "it has no triangles".into(),
    }
}
