//! Advice about shapes and their materials.

use std::collections::HashSet;
use std::ptr;
use std::sync::Arc;

use lookat_syntax::Diagnostic;

use crate::advice::{Summary, warn};
use crate::report::Report;
use crate::{CurveKind, Integrator, Light, Primitive, Shape, Texture, Varying};

/// The most shapes that are named.
const MOST_NAMED: usize = 3;

pub(super) fn emptiness(summary: &Summary, report: &mut Report) {
    if summary.resolved.is_none() || !summary.drawn.is_empty() {
        return;
    }
    if let Some(passed) = summary.facts.passed {
        let help =
            "this Integrator ignores shapes without a material: write Material \"matte\" before the shapes";
        warn(report, passed, "no shape has a material: all shapes are invisible", help);
        return;
    }
    let world = &summary.built.world;
    let ignores_lights = matches!(summary.integrator(), Some(Integrator::AmbientOcclusion { .. }));
    let picture = if ignores_lights || world.lights.iter().all(Light::is_delta) {
        "the picture is black"
    } else {
        "only infinite lights are visible"
    };
    let Some(first) = world.shapes().next() else {
        let help = if summary.facts.objects.is_empty() {
            "add a shape: Shape \"sphere\" is a sphere of radius 1 at the origin of the current transformation"
        } else {
            "shapes in an object are definitions: place them with ObjectInstance"
        };
        warn(report, summary.world(), format!("the world has no shapes: {picture}"), help);
        return;
    };
    let message = format!("no shape of the world can be drawn: {picture}");
    let warning = Diagnostic::warning(summary.world(), message);
    let named =
        world.shapes().take(MOST_NAMED).filter_map(|primitive| Some((primitive.span?, why(primitive))));
    let warning = named.fold(warning, |warning, (at, why)| warning.related(at, why));
    report.push(warning.help(if first.shape.is_empty() {
        "give the mesh triangles"
    } else {
        "check the corners and the indices: three corners of a triangle lie on a line or coincide"
    }));
}

/// Why a mesh cannot be drawn.
fn why(primitive: &Primitive) -> String {
    match &primitive.shape {
        Shape::TriangleMesh(mesh) if mesh.triangles() == 1 => "its triangle has zero area".into(),
        Shape::TriangleMesh(mesh) if mesh.triangles() > 0 => {
            format!("all of its {} triangles have zero area", mesh.triangles())
        }
        _ => "it has no triangles".into(),
    }
}

// Curves, which pbrt-v3 draws differently. `docs/differences.md` lists all differences.

pub(super) fn curves(summary: &Summary, report: &mut Report) {
    for primitive in &summary.drawn {
        let (Shape::Curve(curve), Some(at)) = (&primitive.shape, primitive.span) else { continue };
        // A note: every curve has it, and no parameter makes both pictures equal.
        let message = "pbrt-v3 draws curves up to 5 % thinner where they bend, and omits shadows of surfaces closer than 3.5 curve widths";
        let help = "to reduce the difference in width, increase \"splitdepth\"";
        report.push(Diagnostic::note_at(at, message).help(help));
        if let CurveKind::Ribbon(normals) = &curve.kind
            && normals.windows(2).any(|pair| pair[0] == pair[1])
        {
            let message = "pbrt-v3 may abort or miss parts where successive normals of a ribbon are equal";
            warn(report, at, message, "rotate one of the two normals by a thousandth of a radian");
        }
    }
}

/// Warns of pictures of indices of refraction with values that are an error as a constant.
pub(super) fn indices(summary: &Summary, report: &mut Report) {
    let mut known = HashSet::new();
    let used = summary.drawn.iter().filter(|primitive| known.insert(Arc::as_ptr(&primitive.material)));
    let mut reported = HashSet::new();
    for material in used.flat_map(|primitive| primitive.material.all()) {
        let Some(Texture::Varying(node)) = material.kind.index() else { continue };
        let (Varying::ImageMap(image), Some(at)) = (&node.texture, material.span) else { continue };
        if reported.insert(ptr::from_ref(material)) && image.map.texels().any(|index| index <= 0.0) {
            let message =
                "the picture of the index of refraction has values of 0 or less: they are used as 0.001";
            warn(report, at, message, "use a picture of values above 0, such as 1.5 for glass");
        }
    }
}
