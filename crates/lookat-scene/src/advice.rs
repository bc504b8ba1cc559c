//! Advice: each pass turns facts about a scene into messages.

mod blocks;
mod camera;
mod caustics;
mod curves;
mod darkness;
mod emptiness;
mod hidden_lights;
mod idle_lights;
mod indices;
mod mesh_lights;
mod names;
mod options;
mod quadric_lights;
mod rotations;
mod shadow_alpha;
mod transformations;
mod unused_objects;
mod world_block;

use lookat_syntax::{Diagnostic, Span};

use crate::draft::Built;
use crate::facts::Facts;
use crate::options::Settled;
use crate::report::Report;
use crate::sources::Sources;
use crate::symbols::Symbols;
use crate::{Emission, Integrator, Primitive};

/// What is known about a scene after reading.
pub(crate) struct Evidence<'e> {
    pub facts: &'e Facts,
    pub symbols: &'e Symbols,
    /// The options. `None` without `WorldBegin`.
    pub settled: Option<&'e Settled>,
    pub built: &'e Built,
    /// The shapes that a picture can show: no shapes of unused objects, and no meshes without area. Shapes of an object count once,
    /// however many instances it has.
    pub drawn: Vec<&'e Primitive>,
    pub sources: &'e Sources,
    /// The end of the scene file.
    pub end: Span,
    /// True if the caller accepts a part of a scene.
    pub accept_part: bool,
}

type Pass = fn(&Evidence, &mut Report);

/// The passes for any scene.
const ALWAYS: &[Pass] = &[
    world_block::advise,
    blocks::advise,
    options::advise,
    transformations::advise,
    rotations::advise,
    names::advise,
    camera::advise_large_world,
    caustics::advise,
    hidden_lights::advise,
    indices::advise,
    curves::advise,
    mesh_lights::advise,
    quadric_lights::advise,
];

/// The passes for a scene without errors, because a shape or light with an error still counts as present.
const WITHOUT_ERRORS: &[Pass] = &[
    idle_lights::advise,
    unused_objects::advise,
    darkness::advise,
    emptiness::advise,
    camera::advise_scale,
    shadow_alpha::advise,
];

/// Runs all passes.
pub(crate) fn advise(evidence: &Evidence, report: &mut Report) {
    ALWAYS.iter().for_each(|pass| pass(evidence, report));
    if !report.has_errors() {
        WITHOUT_ERRORS.iter().for_each(|pass| pass(evidence, report));
    }
}

impl Evidence<'_> {
    fn integrator(&self) -> Option<&Integrator> {
        self.settled.map(|settled| &settled.view.integrator)
    }

    /// The shapes of the world that are lights, with the places of their types.
    fn shape_lights(&self) -> impl Iterator<Item = (&Primitive, Emission, Span)> {
        let of_world = self.built.world.primitives.iter();
        let lights = of_world.filter_map(|primitive| Some((primitive, primitive.light()?, primitive.span?)));
        lights.filter(|(primitive, ..)| !primitive.shape.is_invisible())
    }

    /// The start of the world block, for what is said about the world as a whole.
    fn world(&self) -> Span {
        self.facts.world_begin.unwrap_or(self.end)
    }
}

fn warn(report: &mut Report, at: Span, message: impl Into<String>, help: impl Into<String>) {
    report.push(Diagnostic::warning(at, message).help(help));
}
