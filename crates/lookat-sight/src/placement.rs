//! Cameras inside a shape, behind the ground, far away, or turned away from everything; shapes of the wrong size.

use std::collections::BTreeSet;

use lookat_scene::glam::{DMat3, DMat4, DVec3};
use lookat_scene::syntax::{Diagnostic, Directive, FileId, Span, parse};
use lookat_scene::{CameraPlacement, Projection, Transform, View};

use crate::{LightFacts, ShapeFacts, Sight, ViewFacts, corners, exchanged, point, short, union, window};

/// Shapes that fill less of the shorter side than this are hardly seen.
const HARDLY_SEEN: f64 = 0.02;
/// The most of the picture that other shapes fill where one hides them.
const HIDDEN: f64 = 0.01;
/// The angle of view, in degrees, from which on sizes in the middle of the picture mean little.
const WIDEST: f64 = 170.0;
/// The least of the picture that the ground fills where it hides the others.
const HIDING: f64 = 0.1;

/// What is odd about the place of the camera.
pub fn odd(sight: &Sight) -> Option<Diagnostic> {
    let found = inside(sight).or_else(|| behind_ground(sight)).or_else(|| far_away(sight));
    let found = found.or_else(|| nothing_in_view(sight));
    let found = found.map(|found| propose_inverse(sight, with_turn(sight, found)));
    found.or_else(|| other_way(sight))
}

/// The eye is in a closed shape, which no light comes into.
fn inside(sight: &Sight) -> Option<Diagnostic> {
    let shape = &sight.facts.shapes[sight.facts.inside?];
    // A light in the shape may come by way of several surfaces.
    let is_lit =
        sight.facts.lights.iter().any(|light| light.irradiance.reaches || is_in(shape.bounds, light));
    let is_small = shape.size() < 0.5 * sight.world_size();
    let is_meant = shape.is_emitter || (shape.is_opaque && is_lit) || (!shape.is_opaque && !is_small);
    if is_meant {
        return None;
    }
    let message = if shape.is_opaque {
        "the camera is inside this shape, and no light comes in: the picture is black"
    } else {
        "the camera is inside this shape"
    };
    let place = shape.span.unwrap_or_else(|| sight.camera_place());
    let help = if shape.is_opaque {
        "move the eye out of the shape, or a light into it"
    } else {
        "move the eye, or make the shape smaller"
    };
    Some(Diagnostic::warning(place, message).related(sight.camera_place(), sight.eye()).help(help))
}

/// Whether a light is within a box.
pub fn is_in([low, high]: [DVec3; 2], light: &LightFacts) -> bool {
    light.position.is_some_and(|p| p.cmpgt(low).all() && p.cmplt(high).all())
}

/// A plane hides all other shapes.
fn behind_ground(sight: &Sight) -> Option<Diagnostic> {
    let (ground, flat) = sight
        .shapes_in_view()
        .filter(|shape| shape.share >= HIDING && shape.is_opaque && !shape.is_emitter)
        .find_map(|shape| Some((shape, shape.flat?)))?;
    let others = || {
        let all = sight.facts.shapes.iter();
        all.filter(|shape| !std::ptr::eq(*shape, ground) && !shape.is_emitter)
    };
    if others().map(|shape| shape.share).sum::<f64>() > HIDDEN {
        return None;
    }
    let tolerance = 1e-6 * sight.world_size();
    let is_behind = |p: DVec3| (p - flat.p).dot(flat.n) <= tolerance;
    let is_hidden = |shape: &ShapeFacts| corners(shape.bounds).into_iter().all(is_behind);
    if others().next().is_none() || !others().all(is_hidden) {
        return None;
    }
    let up = sight.scene.view.camera.middle().vector(DVec3::Y).normalize_or_zero();
    let where_it_is = if flat.n.dot(up) < -0.5 { "below" } else { "behind" };
    let message = format!("the camera is {where_it_is} this shape, which hides all others");
    let place = ground.span.unwrap_or_else(|| sight.camera_place());
    Some(
        Diagnostic::warning(place, message)
            .related(sight.camera_place(), sight.eye())
            .help("move the eye to the other side"),
    )
}

/// No shape is in view.
fn nothing_in_view(sight: &Sight) -> Option<Diagnostic> {
    let bounds = sight.bounds()?;
    // Of media, only what they scatter is seen.
    let has_media = !sight.scene.world.media.is_empty();
    if has_media || sight.shapes_in_view().next().is_some() || sight.is_all_around() {
        return None;
    }
    let crop = sight.places.crop_window.filter(|_| !sight.is_whole());
    let shapes = sight.facts.shapes.iter().filter(|shape| !shape.is_emitter);
    let sides: BTreeSet<&str> = shapes.map(|shape| side(sight, middle(shape.bounds))).collect();
    let is_behind = sides.iter().all(|side| *side == BEHIND);
    if let Some(crop) = crop.filter(|_| !is_behind) {
        let help = "choose a part of the picture that shows a shape";
        return Some(Diagnostic::warning(crop, "no shape is in this part of the picture").help(help));
    }
    let help = if is_behind {
        "turn the camera around"
    } else if sides.contains(AHEAD) {
        "look at them from another side or from nearer"
    } else {
        "point the camera at them"
    };
    let sides: Vec<&str> = sides.into_iter().collect();
    let where_they_are = match sides[..] {
        [side] => format!("all are {side}"),
        [a, b] => format!("some are {a}, others {b}"),
        _ => "they are on several sides of the picture".to_owned(),
    };
    let help = format!("{help}: the middle of all shapes is at {}", point(middle(bounds)));
    let message = format!("no shape is in view: {where_they_are}");
    Some(Diagnostic::warning(sight.camera_place(), message).note(sight.eye()).help(help))
}

const BEHIND: &str = "behind the camera";
const AHEAD: &str = "ahead, but edge-on or too small to be seen";

/// Where a point of the world is, seen from the camera.
fn side(sight: &Sight, p: DVec3) -> &'static str {
    let p = sight.in_camera(p);
    if -p.z > p.truncate().abs().max_element() {
        return BEHIND;
    }
    if sight.is_in_picture(p) {
        return AHEAD;
    }
    match (p.x.abs() > p.y.abs(), p.x > 0.0, p.y > 0.0) {
        (true, true, _) => "to the right of the picture",
        (true, false, _) => "to the left of the picture",
        (false, _, true) => "above the picture",
        (false, _, false) => "below the picture",
    }
}

/// The middle of a box.
fn middle([low, high]: [DVec3; 2]) -> DVec3 {
    (low + high) * 0.5
}

/// All shapes together are only a few pixels large.
fn far_away(sight: &Sight) -> Option<Diagnostic> {
    let [low, high] = sight.bounds()?;
    let at = sight.in_camera(middle([low, high]));
    let unit = sight.scene.view.camera.middle().vector(DVec3::Z).length();
    let apparent = sight.world_size() / (sight.extent_at(at.z)? * unit);
    // The widest angles show everything small in the middle and large at the edge.
    let is_wide =
        matches!(sight.scene.view.camera.projection, Projection::Perspective { fov } if fov > WIDEST);
    if is_wide || !(at.z > 0.0 && apparent < HARDLY_SEEN && at.truncate().length() < at.z) {
        return None;
    }
    let message = format!(
        "all shapes together are {} wide: they are {} units away, and {} units large",
        match (apparent * sight.short_side()).round() {
            ..=1.0 => "a pixel".to_owned(),
            pixels => format!("{pixels} pixels"),
        },
        short(sight.distance()?),
        short(sight.world_size())
    );
    if let Some(place) = sight.places.screen_window.filter(|_| window::is_orthographic(sight)) {
        let warning = Diagnostic::warning(place, message).help("make screenwindow smaller");
        return Some(match window::of_scene(sight) {
            Some(edges) => warning.fix(place, format!("[{}]", edges.map(short).join(" "))),
            None => warning,
        });
    }
    let has_lenses = sight.scene.view.camera.lens_system().is_some();
    let smaller = if has_lenses { "diagonal of Film" } else { "fov" };
    let help = format!("move the camera closer, or make {smaller} smaller");
    Some(Diagnostic::warning(sight.camera_place(), message).note(sight.eye()).help(help))
}

/// Nothing but planes is in view, and other shapes are the other way round.
fn other_way(sight: &Sight) -> Option<Diagnostic> {
    let turned = sight.turned.as_ref()?;
    let bodies = |facts: &ViewFacts| {
        let is_body = |shape: &&ShapeFacts| shape.share > HIDDEN && shape.flat.is_none() && !shape.is_emitter;
        facts.shapes.iter().filter(is_body).count()
    };
    let bodies_in_all =
        sight.facts.shapes.iter().filter(|shape| !shape.is_thin() && !shape.is_emitter).count();
    let is_odd = bodies(&sight.facts) == 0 && turned.inside.is_none() && 2 * bodies(turned) > bodies_in_all;
    let (span, look_at) = sight.look_at.filter(|_| is_odd)?;
    let message = "far more is in view in the opposite direction: eye and target may be swapped";
    let help = "the first three numbers are the eye, the next three the target";
    Some(exchange(Diagnostic::warning(span, message).note(sight.eye()), help, span, &look_at))
}

/// Proposes to exchange eye and target if more is in view then.
fn with_turn(sight: &Sight, found: Diagnostic) -> Diagnostic {
    let (Some(turned), Some((span, look_at))) = (&sight.turned, sight.look_at) else { return found };
    if turned.inside.is_some() || turned.shape_share < HIDDEN || seen(turned) <= seen_now(sight) {
        return found;
    }
    let help = found.help.as_deref().unwrap_or_default();
    let help = format!("{help}; if eye and target are swapped, write them in this order");
    exchange(found, &help, span, &look_at)
}

/// The number of shapes in view.
fn seen(facts: &ViewFacts) -> usize {
    facts.shapes.iter().filter(|shape| shape.share > 0.0).count()
}

/// The number of shapes that the camera of the scene sees, or 1 from within one.
fn seen_now(sight: &Sight) -> usize {
    seen(&sight.facts).max(usize::from(sight.facts.inside.is_some()))
}

/// Adds the `LookAt` with eye and target exchanged.
fn exchange(found: Diagnostic, help: &str, span: Span, look_at: &CameraPlacement) -> Diagnostic {
    found.help(help).fix(span, text(&exchanged(look_at)))
}

/// The directive, as in a scene file.
fn text(look_at: &CameraPlacement) -> String {
    let vectors = look_at.points.chunks(3).map(|xyz| format!("{} {} {}", xyz[0], xyz[1], xyz[2]));
    format!("LookAt {}", vectors.collect::<Vec<_>>().join("  "))
}

/// The least of the picture that shapes fill from a camera that is proposed.
const LEAST_SEEN: f64 = 0.01;

/// The views from cameras that the inverse places. Cameras of Blender and glTF look along -z.
pub fn inverse_views(view: &View) -> Vec<View> {
    let camera_from_world = view.camera.middle().inverse();
    if camera_from_world == Transform::IDENTITY {
        return Vec::new();
    }
    let backward = Transform::scale(DVec3::new(1.0, 1.0, -1.0));
    let all = [Some(camera_from_world), backward.map(|backward| camera_from_world * backward)];
    let placed = |world_from_camera| {
        let mut view = view.clone();
        view.camera = view.camera.placed(world_from_camera);
        view
    };
    all.into_iter().flatten().map(placed).collect()
}

/// Proposes the inverse if it shows more shapes.
pub fn propose_inverse(sight: &Sight, found: Diagnostic) -> Diagnostic {
    let now = seen_now(sight);
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
    let matrix = view.camera.middle().inverse_matrix();
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
    if is_translation {
        format!("Translate {}", numbers(&matrix.w_axis.truncate().to_array()))
    } else {
        as_matrix(matrix)
    }
}

/// A matrix as a Transform directive.
pub fn as_matrix(matrix: &DMat4) -> String {
    format!("Transform [{}]", numbers(&matrix.to_cols_array()))
}

/// Numbers with the digits of `f32`, and no -0.
fn numbers(values: &[f64]) -> String {
    values.iter().map(|value| (*value as f32 + 0.0).to_string()).collect::<Vec<_>>().join(" ")
}

/// A shape that is so many times as large as all others together is a mistake, unless it is a plane or a light.
const GIANT: f64 = 100.0;

/// A shape that dwarfs all others.
pub fn giant(sight: &Sight) -> Option<Diagnostic> {
    let shapes = &sight.facts.shapes;
    let (number, largest) =
        shapes.iter().enumerate().max_by(|(_, a), (_, b)| a.size().total_cmp(&b.size()))?;
    let others = shapes.iter().enumerate().filter(|(other, shape)| *other != number && !shape.is_emitter);
    let [low, high] = union(others.map(|(_, shape)| shape.bounds))?;
    let rest = (high - low).max_element();
    if !(rest > 0.0 && rest.is_finite())
        || largest.is_thin()
        || largest.is_emitter
        || largest.size() < GIANT * rest
    {
        return None;
    }
    // A ground is meant to be large: other shapes are in view in front of it.
    if sight.facts.inside != Some(number) && sight.shapes_in_view().count() > 1 {
        return None;
    }
    let message =
        format!("this shape is {} times as large as all others together", short(largest.size() / rest));
    let help = "check Scale before it, and its own size";
    Some(Diagnostic::warning(largest.span?, message).help(help))
}
