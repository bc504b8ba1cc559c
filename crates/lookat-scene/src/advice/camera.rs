//! Scales before the camera, which pbrt-v3 handles badly.

use glam::DVec3;

use super::{Evidence, warn};
use crate::report::Report;
use crate::{Integrator, MaterialKind, Transform};

/// Warns of a large world: pbrt-v3 loses hits at small distances in camera units.
pub(super) fn advise_large_world(evidence: &Evidence, report: &mut Report) {
    const LARGE: f64 = 1000.0;
    let Some((at, world_from_camera)) = evidence.facts.camera else { return };
    let unit = world_from_camera.vector(DVec3::Z).length();
    if unit * LARGE < 1.0 {
        let times = (1.0 / unit).round();
        let message = format!("pbrt-v3 may miss near surfaces: the camera transform scales by {times}");
        warn(report, at, message, "remove the scale before Camera");
    }
}

/// Warns of a scale before Camera: pbrt-v3 then passes the BSDF of the first surface a direction that is not
/// normalized.
pub(super) fn advise_scale(evidence: &Evidence, report: &mut Report) {
    if !matches!(evidence.integrator(), Some(Integrator::Path { .. })) {
        return;
    }
    let is_seen = evidence.drawn.iter().any(|primitive| is_glossy(&primitive.material.kind));
    let camera = evidence.facts.camera.as_ref();
    if let Some((at, _)) = camera.filter(|(_, transform)| is_seen && is_scaled(transform)) {
        let message = "a scale before Camera: pbrt-v3 renders glossy and transparent surfaces too dark or too bright, or crashes";
        let help =
            "lookat renders them correctly; for equal pictures, scale the world after WorldBegin instead";
        warn(report, *at, message, help);
    }
}

/// True if the camera transformation scales lengths.
fn is_scaled(world_from_camera: &Transform) -> bool {
    let is_other = |axis: &DVec3| (world_from_camera.vector(*axis).length() - 1.0).abs() > 1e-3;
    [DVec3::X, DVec3::Y, DVec3::Z].iter().any(is_other)
}

/// True if a material has glossy lobes.
fn is_glossy(material: &MaterialKind) -> bool {
    match material {
        MaterialKind::None | MaterialKind::Matte(_) | MaterialKind::Mirror(_) => false,
        MaterialKind::Mix(mix) => mix.materials.iter().any(|material| is_glossy(&material.kind)),
        _ => true,
    }
}
