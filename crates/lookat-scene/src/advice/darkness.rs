//! Scenes whose picture is black.

use super::{Evidence, warn};
use crate::report::Report;
use crate::{Emission, Integrator, Light};

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    let Some(integrator) = evidence.integrator() else { return };
    if matches!(integrator, Integrator::AmbientOcclusion { .. }) {
        return;
    }
    let world = &evidence.built.world;
    let emissions: Vec<Emission> = evidence.drawn.iter().filter_map(|primitive| primitive.emission).collect();
    let shows_emission_alone = matches!(integrator, Integrator::Path { max_depth: 0, .. });
    let (message, help) = if world.lights.is_empty() && emissions.is_empty() {
        let help = "add a light: LightSource \"infinite\" illuminates a scene from all directions";
        ("the scene has no lights: the picture is black", help)
    } else if world.lights.iter().all(Light::is_black) && emissions.iter().all(Emission::is_black) {
        let help = "give them a color and a scale above 0";
        ("all lights of the scene are black: the picture is black", help)
    } else if shows_emission_alone && emissions.is_empty() && world.lights.iter().all(Light::is_delta) {
        let help = "write \"integer maxdepth\" 1 or more, so that surfaces are lit";
        ("maxdepth 0 shows lights alone, and no light of the scene is visible: the picture is black", help)
    } else {
        return;
    };
    warn(report, evidence.world(), message, help);
}
