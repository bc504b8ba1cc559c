//! Lights that light nothing.

use lookat_render::{LightFacts, LightPlace, ShapeFacts};
use lookat_scene::syntax::{Diagnostic, ParamType};
use lookat_scene::{Emission, Integrator, Light};

use super::placement::is_in;
use super::{Sight, short};

/// A light with less than this share of the light is too far away, if it is farther than so many sizes of the world.
const NO_SHARE: f64 = 1e-5;
const FAR: f64 = 30.0;

/// Lights that light nothing in view.
pub(super) fn idle(sight: &Sight) -> Vec<Diagnostic> {
    let uses_lights = !matches!(sight.scene.view.integrator, Integrator::AmbientOcclusion { .. });
    // Light from behind comes through others.
    let is_opaque = sight.shapes_in_view().all(|shape| shape.is_opaque || shape.is_emitter);
    // The back of a lamp is a surface as any other.
    let is_lit = sight.shapes_in_view().any(|shape| !shape.glows);
    let all = sight.facts.lights.iter().filter(|_| uses_lights && is_opaque && is_lit);
    let mut found: Vec<Diagnostic> = Vec::new();
    for warning in all.filter_map(|light| {
        enclosed(sight, light).or_else(|| turned_away(sight, light)).or_else(|| far(sight, light))
    }) {
        // A lamp may be of many shapes.
        match found.iter_mut().find(|known| known.message == warning.message && known.help == warning.help) {
            Some(known) => known.places.push(warning.span()),
            None => found.push(warning),
        }
    }
    found
}

/// A light in an opaque shape.
fn enclosed(sight: &Sight, light: &LightFacts) -> Option<Diagnostic> {
    // Light may come to an eye in the same shape by way of several surfaces.
    let around = light.inside.filter(|around| sight.facts.inside != Some(*around))?;
    let shape = &sight.facts.shapes[around];
    let warning = Diagnostic::warning(
        sight.light_place(light)?,
        "this light is inside a shape, and lights nothing in view",
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
    if light.faces || sight.shapes_in_view().any(hides) {
        return None;
    }
    let (message, help) = match light.place {
        LightPlace::Primitive(number) => return dark_side(sight, number),
        LightPlace::Light(number) => match sight.scene.world.lights[number] {
            Light::Spot { .. } | Light::Projection { .. } => (
                "nothing in view is in the cone of this light",
                "it shines from \"from\" towards \"to\": check both",
            ),
            Light::Distant { .. } => (
                "this light shines on the back of everything in view",
                "it shines from \"from\" towards \"to\": check both",
            ),
            _ => return None,
        },
    };
    Some(Diagnostic::warning(sight.light_place(light)?, message).help(help))
}

/// A shape that shines on the other side.
fn dark_side(sight: &Sight, number: usize) -> Option<Diagnostic> {
    let primitive = &sight.scene.world.primitives[number];
    let (emission, place) = (primitive.emission.filter(|it| !it.is_black())?, primitive.span?);
    // A lamp of several shapes also has some that are turned away.
    let is_same = |other: &LightFacts| emission_of(sight, other) == Some(emission);
    if sight.facts.lights.iter().any(|other| other.faces && is_same(other)) {
        return None;
    }
    let back = sight.shapes_in_view().any(|shape| shape.span == Some(place) && !shape.glows);
    let warning = Diagnostic::warning(
        place,
        match back {
            true => "this light faces away: the camera sees its back, and its front lights nothing in view",
            false => "this light shines away from everything in view",
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
                Some(at) => sight.propose(warning, at, (ParamType::Bool, "twosided"), &["\"true\"".into()]),
                None => warning,
            }
        }
    })
}

/// A light so far away that it gives next to nothing.
fn far(sight: &Sight, light: &LightFacts) -> Option<Diagnostic> {
    let all: f64 = sight.facts.lights.iter().map(|light| light.irradiance).sum();
    let distance = sight.light_distance(light)?;
    let share = light.irradiance / all;
    let is_alone = sight.facts.lights.len() == 1 && light.irradiance < NO_SHARE;
    if !(distance > FAR * sight.world_size() && light.reaches && (share < NO_SHARE || is_alone)) {
        return None;
    }
    let message = format!(
        "this light gives next to nothing: it is {} units away, and the shapes are {} units large",
        short(distance),
        short(sight.world_size())
    );
    Some(Diagnostic::warning(sight.light_place(light)?, message).help("move it closer, or make it brighter"))
}

fn emission_of(sight: &Sight, light: &LightFacts) -> Option<Emission> {
    match light.place {
        LightPlace::Primitive(number) => sight.scene.world.primitives[number].emission,
        LightPlace::Light(_) => None,
    }
}
