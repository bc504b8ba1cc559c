//! Transformations before `Camera` that map the camera to the world: `Camera` takes the inverse.

use lookat_render::ViewFacts;
use lookat_scene::glam::{DMat3, DMat4, DVec3};
use lookat_scene::syntax::{Diagnostic, Directive, FileId, Span, parse};
use lookat_scene::{Transform, View};

use super::Sight;

/// The least of the picture that shapes fill from a camera that is proposed.
const LEAST_SEEN: f64 = 0.01;

/// The views from cameras that the inverse places. Cameras of Blender and glTF look along -z.
pub(super) fn views(view: &View) -> Vec<View> {
    let camera_from_world = view.camera.world_from_camera.inverse();
    if camera_from_world == Transform::IDENTITY {
        return Vec::new();
    }
    let backward = Transform::scale(DVec3::new(1.0, 1.0, -1.0));
    let all = [Some(camera_from_world), backward.map(|backward| camera_from_world * backward)];
    let placed = |world_from_camera| {
        let mut view = view.clone();
        view.camera.world_from_camera = world_from_camera;
        view
    };
    all.into_iter().flatten().map(placed).collect()
}

/// Proposes the inverse if it shows more shapes.
pub(super) fn propose(sight: &Sight, found: Diagnostic) -> Diagnostic {
    let seen = |facts: &ViewFacts| facts.shapes.iter().filter(|shape| shape.share > 0.0).count();
    let now = seen(&sight.facts).max(usize::from(sight.facts.inside.is_some()));
    let shows = |facts: &ViewFacts| {
        facts.inside.is_none() && facts.shape_share + facts.emitter_share >= LEAST_SEEN && seen(facts) > now
    };
    let shown = sight.inverses.iter().filter(|(_, facts)| shows(facts));
    // Of two that show as much, the first.
    let best = shown.reduce(|best, other| if seen(&other.1) > seen(&best.1) { other } else { best });
    let Some((place, text)) = best.and_then(|(view, _)| edit(sight, view)) else { return found };
    let help = "transformations before Camera map the world to the camera: to move the camera by them, write their inverse";
    found.help(help).fix(place, text)
}

/// The edit that places the camera of a view.
fn edit(sight: &Sight, view: &View) -> Option<(Span, String)> {
    let at = sight.directive_start(sight.places.camera?)?;
    let text = &sight.sources.files.get(at.file.0 as usize)?.text[..at.start as usize];
    let matrix = view.camera.world_from_camera.inverse_matrix();
    let before = parse(at.file, text).statements;
    let mut places = before.iter().filter(|statement| !matches!(statement.directive, Directive::Entity(..)));
    // In place of the only transformation, or else after all, where Transform replaces them.
    Some(match (places.next(), places.next()) {
        (Some(only), None) if only.directive.is_transformation() && at.file == FileId(0) => {
            (only.span, written(&matrix))
        }
        _ => (at, format!("{}\n", as_matrix(&matrix))),
    })
}

/// The directive of a transformation.
fn written(matrix: &DMat4) -> String {
    let is_translation = DMat3::from_mat4(*matrix) == DMat3::IDENTITY;
    match is_translation {
        true => format!("Translate {}", numbers(&matrix.w_axis.truncate().to_array())),
        false => as_matrix(matrix),
    }
}

/// A matrix as a Transform directive.
pub(super) fn as_matrix(matrix: &DMat4) -> String {
    format!("Transform [{}]", numbers(&matrix.to_cols_array()))
}

/// Numbers with the digits of `f32`, and no -0.
fn numbers(values: &[f64]) -> String {
    values.iter().map(|value| (*value as f32 + 0.0).to_string()).collect::<Vec<_>>().join(" ")
}
