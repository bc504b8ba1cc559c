//! Transformations without the effect that people expect.

use lookat_syntax::{Diagnostic, Span};

use super::{Evidence, warn};
use crate::Transform;
use crate::report::Report;

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    let facts = evidence.facts;
    match (facts.idle_transform, facts.world_begin, facts.camera) {
        (Some(idle), Some(_), Some(_)) => {
            let help = "move it before Camera to place the camera, or after WorldBegin to place shapes";
            warn(report, idle, "a transformation after Camera has no effect", help);
        }
        (Some(idle), Some(world_begin), None) => {
            let message = "a transformation without Camera has no effect: the default camera stands at the origin and looks along +z";
            let before = Span { end: world_begin.start, ..world_begin };
            let warning = Diagnostic::warning(idle, message).help("write Camera after it");
            report.push(warning.fix(before, "Camera \"perspective\"\n"));
        }
        _ => {}
    }
    // One that follows a camera in its place, or stands in a block, places shapes or lights.
    let is_unplaced = facts.camera.is_none_or(|(_, placed)| placed == Transform::IDENTITY);
    if let Some(at) = facts.look_at_in_world.filter(|_| is_unplaced) {
        let message = "LookAt inside the world block moves shapes, not the camera";
        warn(report, at, message, "to place the camera, move LookAt before Camera");
    }
    for (keyword, at) in &facts.motion {
        let message = format!(
            "{keyword}: lookat does not render motion; it uses the transformations at the start time"
        );
        report.unsupported(*at, message);
    }
}
