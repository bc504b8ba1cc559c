//! Advice about surfaces that light enters to leave them at other points.

use std::sync::Arc;

use glam::{BVec3, Vec3};

use crate::advice::{Summary, short, warn};
use crate::report::Report;
use crate::scene::around;
use crate::{Integrator, Interior, Material, MaterialKind, Primitive, Shape};

/// Between these mean free paths, relative to the size of a body, light gets in and out of it elsewhere.
const SMALLEST: f64 = 1e-6;
const LARGEST: f64 = 10.0;
/// The most materials whose bodies are compared: each comparison looks at all.
const MOST_COMPARED: usize = 100;

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
    for at in
        drawn().filter(|primitive| insides(primitive) > 1).filter_map(|primitive| primitive.material.span)
    {
        let message = "two parts of this mix have a medium inside: the colors of both are used with the model of the first";
        warn(report, at, message, "mix the colors with a texture, in one material");
    }
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
    sizes(summary, report);
    for at in drawn().filter(is_inside_out).filter_map(|primitive| primitive.span) {
        let message = "the normals of this shape point inside: in pbrt-v3 no light leaves its material";
        let help = "ReverseOrientation, or a mirroring transformation, turns normals; with one more, lookat and pbrt-v3 agree";
        warn(report, at, message, help);
    }
}

/// The number of the parts of a material with a medium inside.
fn insides(primitive: &Primitive) -> usize {
    let is_body = |part: &&Material| !matches!(part.kind, MaterialKind::Mix(_)) && part.inside().is_some();
    primitive.material.all().into_iter().filter(|part| is_body(part)).count()
}

/// Compares mean free paths with the sizes of bodies: who writes millimeters in a world of meters gets no light out.
fn sizes(summary: &Summary, report: &mut Report) {
    let mut by_material: Vec<(&Arc<Material>, Vec<&Primitive>)> = Vec::new();
    for primitive in summary.built.world.primitives.iter().filter(|it| it.material.inside().is_some()) {
        let is_full = by_material.len() == MOST_COMPARED;
        match by_material.iter_mut().find(|(material, _)| Arc::ptr_eq(material, &primitive.material)) {
            Some((_, all)) => all.push(primitive),
            None if is_full => {}
            None => by_material.push((&primitive.material, vec![primitive])),
        }
    }
    for (material, primitives) in by_material {
        let Some(at) = material.span else { continue };
        if let Some(paths) = mean_free_path(material)
            && paths.cmple(Vec3::ZERO).any()
        {
            let message = format!(
                "no light that enters these shapes leaves them in {}: its mean free path there is 0",
                named(paths.cmple(Vec3::ZERO))
            );
            warn(report, at, message, "write more than 0");
        }
        let bounds = around(primitives.into_iter().filter_map(Primitive::bounds));
        let Some(([shortest, longest], [low, high])) = mean_free_paths(material).zip(bounds) else {
            continue;
        };
        let size = (high - low).max_element();
        let message = |path: f64, what: &str| {
            format!(
                "the mean free path of light inside is {}, and all shapes of this material are {} wide: {what}",
                short(path),
                short(size)
            )
        };
        if shortest > LARGEST * size {
            let help = "nearly no light leaves them again: check the unit, and \"float scale\"";
            warn(report, at, message(shortest, "they are nearly black"), help);
        } else if longest < SMALLEST * size {
            let help = "check the unit and \"float scale\"; if it is meant, \"plastic\" looks the same and has less noise";
            warn(report, at, message(longest, "light leaves where it enters"), help);
        }
    }
}

/// The shortest and the longest mean free path of the channels of a medium that is everywhere the same. `None` if no light scatters in it.
fn mean_free_paths(material: &Material) -> Option<[f64; 2]> {
    let paths = mean_free_path(material)?;
    let paths = || paths.to_array().into_iter().map(f64::from).filter(|path| *path > 0.0 && path.is_finite());
    Some([paths().reduce(f64::min)?, paths().reduce(f64::max)?])
}

/// The channels of a mask in words.
fn named(channels: BVec3) -> String {
    let names = [(channels.x, "red"), (channels.y, "green"), (channels.z, "blue")];
    names.into_iter().filter(|(is_in, _)| *is_in).map(|(_, name)| name).collect::<Vec<_>>().join(", ")
}

/// The mean free path of each channel of a medium that is everywhere the same.
fn mean_free_path(material: &Material) -> Option<Vec3> {
    Some(match material.inside()? {
        MaterialKind::Subsurface(of) => match &of.interior {
            Interior::Coefficients([absorption, scattering]) => {
                (absorption.constant()? + scattering.constant()?).recip()
            }
            Interior::Color([_, path]) => path.constant()?,
        },
        MaterialKind::Disney(disney) => disney.scatter_distance.constant().filter(|it| *it != Vec3::ZERO)?,
        _ => return None,
    })
}
