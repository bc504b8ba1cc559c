//! Advice about participating media.

use glam::{DVec3, Vec3};
use lookat_syntax::{Span, shown};

use crate::advice::{Summary, short, warn};
use crate::report::Report;
use crate::scene::{around, transformed};
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
        let is_within = bounds.is_some_and(|bounds| contains(bounds, eye));
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
            let help = format!(
                "MediumInterface is for the shapes that follow it in its block, and one name alone counts on both sides: write \"{name}\" \"\""
            );
            warn(report, symbol.uses[0], message, help);
        }
    }
}

fn contains([low, high]: [DVec3; 2], p: DVec3) -> bool {
    p.cmpge(low).all() && p.cmple(high).all()
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
    let is_even = |light: &Light| matches!(light, Light::Infinite { .. });
    let eye = summary.resolved.map(|resolved| resolved.view.camera.middle().point(DVec3::ZERO));
    let ends_at = |primitive: &Primitive| {
        let is_around = |[low, high]: [DVec3; 2]| eye.is_some_and(|eye| contains([low, high], eye));
        !is_opaque(primitive) && primitive.bounds().is_some_and(is_around)
    };
    if medium.density != Density::Uniform
        || !world.lights.iter().any(is_far)
        || summary.boundaries()[index as usize].iter().any(|primitive| ends_at(primitive))
    {
        return;
    }
    let Some([low, high]) = world.bounds() else { return };
    let extinction = f64::from((medium.absorption + medium.scattering).min_element());
    let size = (high - low).length();
    let help = "end the medium at a shape with Material \"\" around the scene, write a smaller scale, or use lamps inside the medium";
    if extinction * size > OPTICAL_DEPTH {
        let message = format!(
            "light from infinity does not get through the medium around the camera: its mean free path is {}, and the way around the world {}",
            short(1.0 / extinction),
            short(size)
        );
        warn(report, summary.world(), message, help);
    } else if extinction > 0.0 && world.lights.iter().any(is_even) {
        let message =
            "a constant infinite light is dark in a medium that has no end, as the one around the camera";
        let help = "end the medium at a shape with Material \"\" around the scene, or use distant lights, or lamps inside the medium";
        warn(report, summary.world(), message, help);
    }
}

/// Grids that rays do not meet, or stay in for long.
pub(super) fn grids(summary: &Summary, report: &mut Report) {
    /// After so many, the renderer ends a ray.
    const COLLISIONS: f64 = 1e4;
    let world = &summary.built.world;
    let all = summary.boundaries();
    for (index, (symbol, definition)) in summary.media().enumerate() {
        let Some(medium) = world.media.get(index) else { continue };
        let Density::Grid(grid) = &medium.density else { continue };
        let name = shown(symbol.name.as_bytes());
        let world_from_grid = grid.grid_from_world.inverse();
        let [low, high] = transformed([DVec3::ZERO, DVec3::ONE], &world_from_grid);
        let bounds = around(all[index].iter().filter_map(|primitive| primitive.bounds()));
        // Shapes of objects are wherever these are placed.
        let is_placed = all[index].iter().all(|it| world.primitives.iter().any(|own| std::ptr::eq(own, *it)));
        let is_around = world.camera_medium == Some(index as u32);
        if let Some([from, to]) = bounds.filter(|_| is_placed && !is_around)
            && (from.cmpgt(high).any() || to.cmplt(low).any())
        {
            let message = format!(
                "the grid of medium \"{name}\" is outside of all shapes that it is in: they are empty"
            );
            let help = "p0 and p1 are in the coordinates at MakeNamedMedium: move it behind the transformations of the shape";
            warn(report, definition, message, help);
            continue;
        }
        let densest = grid.values.iter().fold(0.0, |most: f32, density| most.max(*density));
        let extinction = f64::from((medium.absorption + medium.scattering).max_element() * densest);
        let collisions = extinction
            * DVec3::AXES.map(|axis| world_from_grid.vector(axis).length()).into_iter().fold(0.0, f64::max);
        if collisions > COLLISIONS {
            let message = format!(
                "medium \"{name}\" is very dense: where it is densest, a ray across has {} collisions, and rendering is slow",
                short(collisions)
            );
            warn(
                report,
                definition,
                message,
                "write a smaller scale, or a shape in place of what lets no light in",
            );
        }
    }
}
