//! Lights that light nothing.

use std::collections::HashMap;
use std::f64::consts::TAU;

use lookat_render::LightPlace;
use lookat_scene::glam::DVec3;
use lookat_scene::syntax::{Diagnostic, Directive, FileId, ParamType, Parser, Span, Statement};
use lookat_scene::{CameraPlacement, Emission, Integrator, Light, QuadricForm, Shape, Sphere};

use crate::placement::{as_matrix, is_in};
use crate::{LightFacts, ShapeFacts, Sight, point, short};

/// A light with less than this share of the light is too far away, if it is farther than so many sizes of the world.
const NO_SHARE: f64 = 1e-5;
const FAR: f64 = 30.0;
/// A light that `LookAt` moves is misplaced if it has less than this part of the mean of all lights or, alone, sends less than this part of
/// its own radiance to what is in view.
const MISPLACED: f64 = 0.01;

/// Lights that light nothing in view.
pub fn idle(sight: &Sight) -> Vec<Diagnostic> {
    let uses_lights = !matches!(sight.scene.view.integrator, Integrator::AmbientOcclusion { .. });
    // Light from behind comes through others.
    let is_opaque = sight.shapes_in_view().all(|shape| shape.is_opaque || shape.is_emitter);
    // The back of a lamp is a surface as any other.
    let is_lit = sight.shapes_in_view().any(|shape| !shape.glows);
    let all = sight.facts.lights.iter().filter(|_| uses_lights && is_opaque && is_lit);
    let (mut found, mut look_ats): (Vec<Diagnostic>, _) = (Vec::new(), LookAts::new());
    for warning in all.filter_map(|light| {
        let misplaced = misplaced(sight, light, &mut look_ats).or_else(|| enclosed(sight, light));
        misplaced.or_else(|| turned_away(sight, light)).or_else(|| far(sight, light))
    }) {
        // A lamp may be of many shapes.
        match found.iter_mut().find(|known| known.message == warning.message && known.help == warning.help) {
            Some(known) => known.places.push(warning.span()),
            None => found.push(warning),
        }
    }
    found
}

/// A light that a `LookAt` of its block puts where it gives next to nothing.
fn misplaced(sight: &Sight, light: &LightFacts, look_ats: &mut LookAts) -> Option<Diagnostic> {
    let usual = match sight.facts.lights.len() {
        1 => emission_of(sight, light).map_or(0.0, |it| f64::from(it.radiance.max_element())),
        count => sight.irradiance() / count as f64,
    };
    let place = sight.light_place(light).filter(|_| light.irradiance.mean <= MISPLACED * usual)?;
    let LookAt { span: at, points, .. } = *look_at_of(sight, place, look_ats)?;
    let placed = CameraPlacement::new(points).world_from_camera().ok()?;
    let message = match light.position {
        Some(position) => {
            format!(
                "LookAt puts this light at {}, where it illuminates almost nothing in view",
                point(position)
            )
        }
        None => "LookAt turns this light, and it illuminates almost nothing in view".into(),
    };
    let eye = DVec3::from_slice(&points[..3]);
    let help =
        format!("LookAt maps the world to a camera: to put the light at {}, write the inverse", point(eye));
    let inverse = format!("Concat{}", as_matrix(&placed.matrix()));
    Some(Diagnostic::warning(place, message).related(at, "this moves the light").help(help).fix(at, inverse))
}

/// A `LookAt` of the world.
#[derive(Clone, Copy)]
struct LookAt {
    span: Span,
    points: [f64; 9],
    /// Where its block ends.
    end: u32,
}

/// The `LookAt`s of the world of each file, once they have been asked for.
type LookAts = HashMap<FileId, Vec<LookAt>>;

/// The only `LookAt` that moves what a directive makes.
fn look_at_of<'l>(sight: &Sight, place: Span, known: &'l mut LookAts) -> Option<&'l LookAt> {
    let all = known.entry(place.file).or_insert_with(|| look_ats(sight, place.file));
    let mut moving = all.iter().filter(|look_at| (look_at.span.end..look_at.end).contains(&place.start));
    moving.next().filter(|_| moving.next().is_none())
}

/// The `LookAt`s in the world of a file.
fn look_ats(sight: &Sight, file: FileId) -> Vec<LookAt> {
    let Some(source) = sight.sources.files.get(file.0 as usize) else { return Vec::new() };
    let text = &source.text[..];
    let find = |text: &[u8], word: &[u8]| text.windows(word.len()).position(|part| part == word);
    let world = find(text, b"WorldBegin").unwrap_or(0);
    // Most worlds have none, and need not be read again.
    if find(&text[world..], b"LookAt").is_none() {
        return Vec::new();
    }
    let nothing_known = &mut |_, _| None;
    let mut parser = Parser::new(file, text, nothing_known);
    let (mut blocks, mut ended) = (vec![Vec::new()], Vec::new());
    while let Some(parsed) = parser.next_block(1, u64::MAX) {
        for Statement { directive, span, .. } in parsed.statements {
            match directive {
                Directive::WorldBegin => blocks = vec![Vec::new()],
                Directive::AttributeBegin | Directive::TransformBegin | Directive::ObjectBegin(_) => {
                    blocks.push(Vec::new());
                }
                Directive::AttributeEnd | Directive::TransformEnd | Directive::ObjectEnd => {
                    let all = blocks.pop().into_iter().flatten();
                    ended.extend(all.map(|look_at| LookAt { end: span.start, ..look_at }));
                }
                Directive::LookAt(points) => {
                    let look_at = LookAt { span, points, end: u32::MAX };
                    if let Some(block) = blocks.last_mut() {
                        block.push(look_at);
                    }
                }
                _ => {}
            }
        }
    }
    ended.into_iter().chain(blocks.into_iter().flatten()).collect()
}

/// A light in an opaque shape.
fn enclosed(sight: &Sight, light: &LightFacts) -> Option<Diagnostic> {
    // Light may come to an eye in the same shape by way of several surfaces.
    let around = light.inside.filter(|around| sight.facts.inside != Some(*around))?;
    let shape = &sight.facts.shapes[around];
    let warning = Diagnostic::warning(
        sight.light_place(light)?,
        "this light is inside a shape and illuminates nothing in view",
    );
    let warning = match shape.span {
        Some(span) => warning.related(span, "this shape is around it"),
        None => warning,
    };
    Some(warning.help("move the light out of the shape"))
}

/// A light that shines away from everything.
fn turned_away(sight: &Sight, light: &LightFacts) -> Option<Diagnostic> {
    // What is in view may hide the light in it, as the walls of a room do from outside.
    let hides = |shape: &ShapeFacts| !shape.is_emitter && is_in(shape.bounds, light);
    if light.irradiance.faces || sight.shapes_in_view().any(hides) {
        return None;
    }
    let (message, help) = match light.irradiance.light {
        LightPlace::Primitive(number) => return dark_side(sight, number),
        LightPlace::Light(number) => match sight.scene.world.lights[number] {
            Light::Spot { world_from_light, .. } | Light::Projection { world_from_light, .. } => (
                "nothing in view is in the cone of this light",
                format!(
                    "it shines from {} towards {}: turn it",
                    point(world_from_light.point(DVec3::ZERO)),
                    point(world_from_light.point(DVec3::Z))
                ),
            ),
            Light::Distant { direction, .. } => (
                "this light shines on the back of everything in view",
                format!("it shines along {}: turn it", point(-direction)),
            ),
            _ => return None,
        },
    };
    Some(Diagnostic::warning(sight.light_place(light)?, message).help(help))
}

/// A shape that shines on the other side.
fn dark_side(sight: &Sight, number: usize) -> Option<Diagnostic> {
    let primitive = &sight.scene.world.primitives[number];
    let (emission, place) = (primitive.emission.as_deref().filter(|it| !it.is_black())?, primitive.span?);
    // A whole sphere shines in all directions: what is wrong is not its side.
    if !primitive.reverse_orientation && is_whole_sphere(&primitive.shape) {
        return None;
    }
    // A lamp of several shapes also has some that are turned away.
    let is_same = |other: &LightFacts| emission_of(sight, other) == Some(emission);
    if sight.facts.lights.iter().any(|other| other.irradiance.faces && is_same(other)) {
        return None;
    }
    let back = sight.shapes_in_view().any(|shape| shape.span == Some(place) && !shape.glows);
    let warning = Diagnostic::warning(
        place,
        if back {
            "this light faces away: the camera sees its back, and its front illuminates nothing in view"
        } else {
            "this light shines away from everything in view"
        },
    );
    Some(match (primitive.reverse_orientation, sight.directive_start(place)) {
        (false, Some(start)) => warning
            .help("it shines on the side of its normal: turn it around, or write \"bool twosided\" \"true\" in AreaLightSource")
            .fix(start, "ReverseOrientation "),
        (false, None) => warning.help("it shines on the side of its normal: write ReverseOrientation before the shape, or \"bool twosided\" \"true\" in AreaLightSource"),
        (true, _) => {
            let warning = warning.help("ReverseOrientation turns it around: remove that, or let both sides shine");
            match emission.span {
                Some(at) => sight.propose(warning, at, ParamType::Bool, "twosided", &["\"true\"".into()]),
                None => warning,
            }
        }
    })
}

fn is_whole_sphere(shape: &Shape) -> bool {
    let Shape::Quadric(quadric) = shape else { return false };
    let QuadricForm::Sphere(Sphere { radius, z_min, z_max }) = quadric.form else { return false };
    z_min == -radius && z_max == radius && quadric.phi_max == TAU
}

/// A light so far away that it gives next to nothing.
fn far(sight: &Sight, light: &LightFacts) -> Option<Diagnostic> {
    let [low, high] = sight.bounds()?;
    // From the middle of all shapes that are no lights. Some lights are everywhere.
    let distance = light.position?.distance((low + high) * 0.5);
    let share = light.irradiance.mean / sight.irradiance();
    let is_alone = sight.facts.lights.len() == 1 && light.irradiance.mean < NO_SHARE;
    if !(distance > FAR * sight.world_size() && light.irradiance.reaches && (share < NO_SHARE || is_alone)) {
        return None;
    }
    let message = format!(
        "this light has almost no effect: it is {} units away, and the shapes are {} units large",
        short(distance),
        short(sight.world_size())
    );
    Some(Diagnostic::warning(sight.light_place(light)?, message).help("move it closer, or make it brighter"))
}

fn emission_of<'s>(sight: &Sight<'s>, light: &LightFacts) -> Option<&'s Emission> {
    match light.irradiance.light {
        LightPlace::Primitive(number) => sight.scene.world.primitives[number].emission.as_deref(),
        LightPlace::Light(_) => None,
    }
}
