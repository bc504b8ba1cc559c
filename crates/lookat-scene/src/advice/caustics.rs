//! Integrators that `path` replaces. The picture is the same, except for caustics of delta lights.

use glam::Vec3;
use lookat_syntax::Diagnostic;

use super::Evidence;
use crate::report::Report;
use crate::texture::Texture;
use crate::{Light, MaterialKind};

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    let Some(kind) = evidence.settled.and_then(|settled| settled.substituted.as_ref()) else { return };
    let message = format!("lookat renders Integrator \"{}\" with \"path\"", kind.value);
    let casts_caustics = evidence.built.world.lights.iter().any(Light::is_delta)
        && evidence.drawn.iter().any(|primitive| is_specular(&primitive.material.kind));
    report.push(match casts_caustics {
        true => Diagnostic::warning(kind.span, message).help(
            "\"path\" does not find caustics of point, spot and distant lights; for caustics, use a shape with an AreaLightSource",
        ),
        false => Diagnostic::note_at(kind.span, message).help("the picture is the same apart from its noise"),
    });
}

/// True if a material has specular lobes, which reflect or refract light in single directions.
fn is_specular(material: &MaterialKind) -> bool {
    match material {
        MaterialKind::Mirror(_) | MaterialKind::Glass(_) => true,
        MaterialKind::Uber(uber) => {
            let is_black = |share: &Texture<Vec3>| share.constant() == Some(Vec3::ZERO);
            !is_black(&uber.kr) || !is_black(&uber.kt) || uber.opacity.constant() != Some(Vec3::ONE)
        }
        MaterialKind::Mix(mix) => mix.materials.iter().any(|material| is_specular(&material.kind)),
        _ => false,
    }
}
