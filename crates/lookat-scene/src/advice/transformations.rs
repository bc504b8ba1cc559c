//! Transformations without the effect that people expect.

use super::{Evidence, warn};
use crate::report::Report;

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    let facts = evidence.facts;
    if let Some(idle) = facts.idle_transform.filter(|_| facts.world_begin.is_some()) {
        let help = "move it before Camera to place the camera, or after WorldBegin to place shapes";
        warn(report, idle, "a transformation after Camera has no effect", help);
    }
    for at in &facts.look_ats {
        let message = "LookAt inside the world block moves shapes, not the camera";
        warn(report, *at, message, "to place the camera, move LookAt before Camera");
    }
    for (keyword, at) in &facts.motion {
        let message = format!(
            "{keyword}: lookat does not render motion; it uses the transformations at the start time"
        );
        report.unsupported(*at, message);
    }
}
