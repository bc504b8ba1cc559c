//! Advice about participating media.

use glam::{DVec3, Vec3};
use lookat_syntax::{Span, shown};

use crate::advice::{Summary, short, warn};
use crate::report::Report;
use crate::scene::around;
use crate::shape::QuadricForm;
use crate::symbols::{Symbol, SymbolKind};
use crate::{Density, Light, Material, MaterialKind, Primitive, Shape};

impl Summary<'_> {
    fn media(&self) -> impl Iterator<Item = (&Symbol, Span)> {
        let media = self.symbols.list.iter().filter(|symbol| symbol.kind == SymbolKind::Medium);
        media.filter_map(|medium| Some((medium, medium.definition?)))
    }

    /// Of each medium: the shapes that have it on one side alone.
    fn boundaries(&self) -> Vec<Vec<&Primitive>> {
        let mut all = vec![Vec::new(); self.built.world.media.len()];
        for primitive in &self.drawn {
            let sides = primitive.medium.map_or([None; 2], |it| [it.inside, it.outside]);
            for medium in sides.into_iter().flatten() {
                all[medium as usize].push(*primitive);
            }
        }
        all
    }
}

/// Media that the integrator ignores.
pub(super) fn ignored(summary: &Summary, report: &mut Report) {
    if summary.resolved.is_some_and(|resolved| resolved.passes_boundaries) {
        return;
    }
    let used = summary.media().flat_map(|(medium, _)| &medium.uses);
    if let Some(place) = used.min_by_key(|place| (place.file.0, place.start)) {
        let message = "this integrator ignores media, as in pbrt-v3: it renders empty space instead";
        warn(report, *place, message, "write Integrator \"volpath\"");
    }
}

/// Media that no path gets into.
pub(super) fn unseen(summary: &Summary, report: &mut Report) {
    let (world, Some(resolved)) = (&summary.built.world, summary.resolved) else { return };
    let eye = resolved.view.camera.middle().point(DVec3::ZERO);
    let all = summary.boundaries();
    for (index, ((symbol, definition), boundaries)) in (0_u32..).zip(summary.media().zip(&all)) {
        let bounds = around(boundaries.iter().filter_map(|primitive| primitive.bounds()));
        // Light that opaque shapes reflect is in the medium on their side.
        let is_within = bounds.is_some_and(|[low, high]| eye.cmpge(low).all() && eye.cmple(high).all());
        let is_hidden = |primitive: &&Primitive| {
            let is_inside = primitive.medium.is_some_and(|it| it.inside == Some(index));
            is_inside && !is_within && is_solid(primitive) && is_opaque(primitive)
        };
        if world.camera_medium == Some(index) || !boundaries.iter().all(is_hidden) {
            continue;
        }
        let name = shown(symbol.name.as_bytes());
        if symbol.uses.is_empty() {
            let message = format!("medium \"{name}\" is defined and never used");
            let help = format!(
                "MediumInterface \"{name}\" \"\" before a Shape fills it; before Camera, \"\" \"{name}\" is where the eye is"
            );
            warn(report, definition, message, help);
        } else if let Some(at) = boundaries.iter().find_map(|primitive| primitive.span) {
            let message = format!("no path gets into medium \"{name}\": the shapes around it are opaque");
            warn(
                report,
                at,
                message,
                "give this shape Material \"\", or one that lets light through, such as \"glass\"",
            );
        } else {
            let message =
                format!("no shape and no camera has medium \"{name}\" on one side alone: it is not seen");
            let help = "MediumInterface is for the shapes that follow it in its block; before Camera, its second name is where the eye is";
            warn(report, symbol.uses[0], message, help);
        }
    }
}

/// True for a shape that may have an inside: not for a wall.
fn is_solid(primitive: &Primitive) -> bool {
    let is_outward = primitive.reverse_orientation == primitive.mirrored;
    match &primitive.shape {
        Shape::Quadric(quadric) => is_outward && matches!(quadric.form, QuadricForm::Sphere(_)),
        Shape::TriangleMesh(mesh) => mesh.triangles() >= 4,
        Shape::Curve(_) => false,
    }
}

/// True if no light gets through a shape.
fn is_opaque(primitive: &Primitive) -> bool {
    let is_opaque = |material: &&Material| match &material.kind {
        MaterialKind::Matte(_)
        | MaterialKind::Plastic(_)
        | MaterialKind::Mirror(_)
        | MaterialKind::Metal(_)
        | MaterialKind::Substrate(_) => true,
        MaterialKind::Uber(uber) => {
            uber.kt.constant() == Some(Vec3::ZERO) && uber.opacity.constant() == Some(Vec3::ONE)
        }
        MaterialKind::Disney(disney) => disney.thin.is_none() && disney.spec_trans.constant() == Some(0.0),
        MaterialKind::Mix(_) => true,
        _ => false,
    };
    primitive.cutout.is_none() && primitive.material.all().iter().all(is_opaque)
}

/// Light from infinity that does not get to the camera.
pub(super) fn dark_sky(summary: &Summary, report: &mut Report) {
    /// As little of usual lights is black.
    const OPTICAL_DEPTH: f64 = 12.0;
    let world = &summary.built.world;
    let Some((index, medium)) = world.camera_medium.and_then(|it| Some((it, world.media.get(it as usize)?)))
    else {
        return;
    };
    let is_far = |light: &Light| {
        matches!(light, Light::Distant { .. } | Light::Infinite { .. } | Light::Environment { .. })
    };
    if medium.density != Density::Uniform
        || !world.lights.iter().any(is_far)
        || summary.boundaries()[index as usize].iter().any(|primitive| !is_opaque(primitive))
    {
        return;
    }
    let Some([low, high]) = world.bounds() else { return };
    let extinction = f64::from((medium.absorption + medium.scattering).min_element());
    let size = (high - low).length();
    if extinction * size > OPTICAL_DEPTH {
        let message = format!(
            "light from infinity does not get through the medium around the camera: its mean free path is {}, and the way around the world {}",
            short(1.0 / extinction),
            short(size)
        );
        let help = "end the medium at a shape with Material \"\" around the scene, write a smaller scale, or use lamps inside the medium";
        warn(report, summary.world(), message, help);
    }
}
