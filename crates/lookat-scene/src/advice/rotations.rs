//! Rotations whose angle looks like radians or stands in the last place.

use lookat_syntax::Diagnostic;

use super::Evidence;
use crate::angle;
use crate::facts::Rotation;
use crate::report::Report;

/// The most rotations for which doubtful ones are reported. Among more, some look doubtful by chance.
const MANY: usize = 20;

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    let rotations = &evidence.facts.rotations;
    rotations.iter().filter_map(angle_last).for_each(|warning| report.push(warning));
    let doubtful = || rotations.iter().filter_map(radians);
    if rotations.len() < MANY * doubtful().count() {
        doubtful().for_each(|doubt| report.push(doubt));
    }
}

fn radians(rotation: &Rotation) -> Option<Diagnostic> {
    let (severity, message, help) = angle::doubt("the angle of Rotate", rotation.angle)?;
    let doubt = Diagnostic::warning(rotation.at, message).help(help);
    Some(Diagnostic { severity, ..doubt })
}

fn angle_last(Rotation { angle, axis: [x, y, z], at }: &Rotation) -> Option<Diagnostic> {
    let is_axis = [angle, x, y].into_iter().all(|number| [-1.0, 0.0, 1.0].contains(number));
    if !is_axis || !(10.0..=720.0).contains(&z.abs()) {
        return None;
    }
    let message = format!("the angle of Rotate is {angle}: did you write the angle last?");
    let warning = Diagnostic::warning(*at, message).help("write the angle first, then the axis");
    Some(warning.fix(*at, format!("Rotate {z} {angle} {x} {y}")))
}
