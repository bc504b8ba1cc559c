//! Advice about the camera and about transformations.

use glam::DVec3;
use lookat_syntax::{Diagnostic, Span};

use crate::advice::{Summary, warn};
use crate::facts::Rotation;
use crate::report::Report;
use crate::{Integrator, Material, MaterialKind, Shutter, Transform, transform};

/// Warns of motion that applies to more or fewer shapes than meant, or at other times.
pub(super) fn motion(summary: &Summary, report: &mut Report) {
    if let Some(at) = summary.facts.active {
        let message = "nothing ends this ActiveTransform: all transformations behind it apply to one of the times alone";
        let help = "write ActiveTransform All before shapes that stand still";
        report.push(Diagnostic::note_at(at, message).help(help));
    }
    let Some(resolved) = summary.resolved else { return };
    let camera = &resolved.view.camera;
    let Shutter { open, close, transform_times: [start, end] } = camera.shutter;
    let is_instant = open == close;
    let is_before = close < start || close == start && !is_instant;
    let is_after = open > end || open == end && !is_instant;
    if (is_before || is_after) && (camera.motion.is_some() || summary.built.world.has_motion()) {
        let [when, what] = if is_before { ["before", "start"] } else { ["after", "end"] };
        let open = if is_instant { format!("at {open}") } else { format!("from {open} to {close}") };
        let message = format!(
            "nothing moves: the shutter is open {open}, {when} all motion, which lasts from {start} to {end}; the picture shows its {what}"
        );
        let help =
            "write shutteropen and shutterclose of Camera, or TransformTimes, so that these times overlap";
        warn(report, summary.facts.camera.as_ref().map_or(summary.world(), |(at, _)| *at), message, help);
    }
}

// Scales before the camera, which pbrt-v3 handles badly.

/// Warns of a large world: pbrt-v3 loses hits at small distances in camera units.
pub(super) fn advise_large_world(summary: &Summary, report: &mut Report) {
    const LARGE: f64 = 1000.0;
    let Some((at, placed)) = &summary.facts.camera else { return };
    let (at, world_from_camera) = (*at, *placed.start);
    let unit = world_from_camera.vector(DVec3::Z).length();
    if unit * LARGE < 1.0 {
        let times = (1.0 / unit).round();
        let message = format!("pbrt-v3 may miss near surfaces: the camera transform scales by {times}");
        warn(report, at, message, "remove the scale before Camera");
    }
}

/// Warns of a scale before Camera: pbrt-v3 then passes the BSDF of the first surface a direction that is not
/// normalized.
pub(super) fn advise_scale(summary: &Summary, report: &mut Report) {
    if !matches!(summary.integrator(), Some(Integrator::Path { .. })) {
        return;
    }
    let is_seen = summary.drawn.iter().any(|primitive| is_glossy(&primitive.material));
    let camera = summary.facts.camera.as_ref();
    if let Some((at, _)) = camera.filter(|(_, placed)| is_seen && is_scaled(&placed.start)) {
        let message = "a scale before Camera: pbrt-v3 renders glossy and transparent surfaces too dark or too bright, or crashes";
        let help =
            "lookat renders them correctly; for equal pictures, scale the world after WorldBegin instead";
        warn(report, *at, message, help);
    }
}

/// True if the camera transformation is more than a rotation and a translation.
fn is_scaled(world_from_camera: &Transform) -> bool {
    !world_from_camera.uniform_scale(1e-3).is_some_and(|scale| (scale - 1.0).abs() < 1e-3)
}

/// True if a material has glossy lobes.
fn is_glossy(material: &Material) -> bool {
    use MaterialKind::{
        Disney, Fourier, Glass, Hair, Matte, Metal, Mirror, Mix, None, Plastic, Substrate, Subsurface,
        Translucent, Uber,
    };
    material.all().iter().any(|part| match part.kind {
        None | Matte(_) | Mirror(_) | Mix(_) => false,
        Disney(_) | Fourier(_) | Glass(_) | Hair(_) | Metal(_) | Plastic(_) | Substrate(_)
        | Subsurface(_) | Translucent(_) | Uber(_) => true,
    })
}

pub(super) fn transformations(summary: &Summary, report: &mut Report) {
    let facts = summary.facts;
    match (facts.idle_transform, facts.world_begin, &facts.camera) {
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
    let is_unplaced = facts.camera.as_ref().is_none_or(|(_, placed)| *placed.start == Transform::IDENTITY);
    if let Some(at) = facts.look_at_in_world.filter(|_| is_unplaced) {
        let message = "LookAt inside the world block moves shapes, not the camera";
        warn(report, at, message, "to place the camera, move LookAt before Camera");
    }
}

/// The most rotations for which doubtful ones are reported. Among more, some look doubtful by chance.
const MANY: usize = 20;

pub(super) fn rotations(summary: &Summary, report: &mut Report) {
    let rotations = &summary.facts.rotations;
    report.extend(rotations.iter().filter_map(angle_last));
    report.extend(rotations.iter().filter_map(half_turn));
    let doubtful: Vec<Diagnostic> = rotations.iter().filter_map(radians).collect();
    if rotations.len() < MANY * doubtful.len() {
        report.extend(doubtful);
    }
}

fn radians(rotation: &Rotation) -> Option<Diagnostic> {
    let (severity, message, help) = transform::doubt("the angle of Rotate", rotation.angle)?;
    Some(Diagnostic::new(severity, rotation.at, message).help(help))
}

/// Motion turns the short way between two matrices, which do not tell how they came about.
fn half_turn(rotation: &Rotation) -> Option<Diagnostic> {
    let is_far = rotation.is_motion && rotation.angle.abs() >= 180.0;
    let warning = is_far.then(|| {
        let message = "motion turns the short way, by at most 180 degrees: after half a turn it goes backwards, after a whole one it stands still";
        Diagnostic::warning(rotation.at, message)
    })?;
    Some(warning.help("write less than 180 degrees, and a shorter shutter or later TransformTimes"))
}

fn angle_last(Rotation { angle, axis: [x, y, z], at, .. }: &Rotation) -> Option<Diagnostic> {
    let is_axis = [angle, x, y].into_iter().all(|number| [-1.0, 0.0, 1.0].contains(number));
    if !is_axis || !(10.0..=720.0).contains(&z.abs()) {
        return None;
    }
    let message = format!("the angle of Rotate is {angle}: did you write the angle last?");
    let warning = Diagnostic::warning(*at, message).help("write the angle first, then the axis");
    Some(warning.fix(*at, format!("Rotate {z} {angle} {x} {y}")))
}
