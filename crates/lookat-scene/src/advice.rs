//! Advice: each pass turns facts about a scene into messages. Here: the facts, and passes about blocks, options and names.

mod bodies;
mod lights;
mod media;
mod placement;
mod shapes;

use std::collections::BTreeMap;

use lookat_syntax::{Diagnostic, EntityKind, Severity, Span, shown};

use crate::draft::Built;
use crate::facts::{Block, BlockStart, Facts};
use crate::options::ResolvedOptions;
use crate::report::Report;
use crate::schema::number;
use crate::sources::Sources;
use crate::symbols::{SymbolKind, Symbols};
use crate::{Emission, Integrator, Primitive};

/// A scene after reading: what advice is based on.
pub(crate) struct Summary<'e> {
    pub facts: &'e Facts,
    pub symbols: &'e Symbols,
    /// The options. `None` without `WorldBegin`.
    pub resolved: Option<&'e ResolvedOptions>,
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

type Pass = fn(&Summary, &mut Report);

/// The passes for any scene.
const ALWAYS: &[Pass] = &[
    world_block,
    blocks,
    missing_options,
    placement::transformations,
    placement::rotations,
    names,
    media::ignored,
    placement::motion,
    placement::advise_large_world,
    lights::caustics,
    lights::hidden_lights,
    shapes::indices,
    shapes::curves,
    lights::mesh_lights,
    lights::quadric_lights,
];

/// The passes for a scene without errors, because a shape or light with an error still counts as present.
const WITHOUT_ERRORS: &[Pass] = &[
    lights::idle_lights,
    unused_objects,
    lights::darkness,
    shapes::emptiness,
    placement::advise_scale,
    lights::shadow_alpha,
    bodies::bodies,
    media::unseen,
    media::dark_sky,
    media::grids,
];

/// Runs all passes.
pub(crate) fn advise(summary: &Summary, report: &mut Report) {
    for pass in ALWAYS {
        pass(summary, report);
    }
    if !report.has_errors() {
        for pass in WITHOUT_ERRORS {
            pass(summary, report);
        }
    }
}

impl Summary<'_> {
    fn integrator(&self) -> Option<&Integrator> {
        self.resolved.map(|resolved| &resolved.view.integrator)
    }

    /// The shapes of the world that are lights, with the places of their types.
    fn shape_lights(&self) -> impl Iterator<Item = (&Primitive, &Emission, Span)> {
        let of_world = self.built.world.primitives.iter();
        let lights = of_world.filter_map(|primitive| Some((primitive, primitive.light()?, primitive.span?)));
        lights.filter(|(primitive, ..)| !primitive.shape.is_invisible())
    }

    /// The start of the world block, for what is said about the world as a whole.
    fn world(&self) -> Span {
        self.facts.world_begin.unwrap_or(self.end)
    }
}

/// A size to three digits.
fn short(size: f64) -> String {
    number(format!("{size:.2e}").parse().unwrap_or(size))
}

fn warn(report: &mut Report, at: Span, message: impl Into<String>, help: impl Into<String>) {
    report.push(Diagnostic::warning(at, message).help(help));
}

pub(super) fn blocks(summary: &Summary, report: &mut Report) {
    // Unread text may contain the missing ends.
    let unclosed = if report.incomplete_end { &[] } else { &summary.facts.unclosed[..] };
    for BlockStart { kind, at } in unclosed {
        let (begin, end) = kind.keywords();
        let help = format!("add {end} before the end of the world block");
        warn(report, *at, format!("this {begin} is not closed"), help);
    }
}

fn world_block(summary: &Summary, report: &mut Report) {
    match (summary.facts.part, summary.facts.world_begin) {
        (Some((block, first)), None) => part(summary, block, first, report),
        (None, None) => no_world(summary, report),
        (_, Some(_)) => {}
    }
    // pbrt-v4 has no WorldEnd.
    let is_excused = report.is_v4(summary.sources) || report.incomplete || report.incomplete_end;
    if let Some(end) = summary.facts.missing_end.filter(|_| !is_excused) {
        let help = "add WorldEnd: without it, pbrt-v3 renders nothing";
        warn(report, end, "the file ends without WorldEnd", help);
    }
}

fn part(summary: &Summary, block: Block, first: Span, report: &mut Report) {
    let without = match block {
        Block::Options => "WorldBegin",
        _ => "Camera, Film or WorldBegin",
    };
    let message = format!("this file is a part of a scene: it has no {without}");
    report.push(if summary.accept_part {
        Diagnostic::note_at(first, message).help("the scene that includes it may define the missing names")
    } else {
        Diagnostic::error(first, message).help("check or render the scene that includes it")
    });
}

fn no_world(summary: &Summary, report: &mut Report) {
    if report.incomplete {
        return;
    }
    report.push(match summary.facts.early.first() {
        None => Diagnostic::error(summary.end, "the file has no WorldBegin: there is nothing to render")
            .help("put the lights and shapes between WorldBegin and WorldEnd; if another scene includes this file, check that scene"),
        Some((keyword, at)) => {
            let before = Span { end: at.start, ..*at };
            Diagnostic::error(*at, format!("{keyword} without WorldBegin"))
                .help("put the lights and shapes between WorldBegin and WorldEnd")
                .fix(before, "WorldBegin\n")
        }
    });
}

fn missing_options(summary: &Summary, report: &mut Report) {
    let Facts { missing_options, idle_transform, .. } = summary.facts;
    // A transformation that waits for a Camera has its own warning.
    let is_told = |kind: &&EntityKind| **kind == EntityKind::Camera && idle_transform.is_some();
    let missing: Vec<&EntityKind> = missing_options.iter().filter(|kind| !is_told(kind)).collect();
    let Some(world_begin) = summary.facts.world_begin.filter(|_| !missing.is_empty()) else { return };
    let names: Vec<_> = missing.iter().map(|kind| kind.keyword()).collect();
    let defaults: Vec<_> = missing.iter().map(|kind| default(**kind)).collect();
    // A scene needs its own view and size. It can use the default sampler and integrator of pbrt-v3.
    let severity = if missing.iter().any(|kind| matches!(kind, EntityKind::Camera | EntityKind::Film)) {
        Severity::Warning
    } else {
        Severity::Note
    };
    let (names, applies) = match &names[..] {
        [several @ .., last] if !several.is_empty() => {
            (format!("{} or {last}", several.join(", ")), "the defaults apply")
        }
        _ => (names.concat(), "the default applies"),
    };
    let message = format!("no {names} before WorldBegin");
    let help = format!("{applies}: {}", defaults.join("; "));
    report.push(Diagnostic::new(severity, world_begin, message).help(help));
}

fn default(kind: EntityKind) -> &'static str {
    match kind {
        EntityKind::Camera => "a perspective camera at the origin that looks along +z, fov 90",
        EntityKind::Film => "1280 x 720 pixels, written to pbrt.exr",
        EntityKind::Sampler => "halton with 16 samples",
        _ => "path with maxdepth 5",
    }
}

pub(super) fn names(summary: &Summary, report: &mut Report) {
    for (kind, name, at) in &summary.facts.redefined {
        let (what, name) = (what(*kind), shown(name.as_bytes()));
        let message = format!("{what} \"{name}\" is defined again: the new definition applies from here on");
        report.push(Diagnostic::note_at(*at, message));
    }
}

fn what(kind: SymbolKind) -> &'static str {
    match kind {
        SymbolKind::Material => "material",
        SymbolKind::FloatTexture | SymbolKind::SpectrumTexture => "texture",
        kind => kind.name(),
    }
}

fn unused_objects(summary: &Summary, report: &mut Report) {
    let symbols = summary.facts.objects.iter().map(|(at, symbol)| (*at, &summary.symbols[*symbol]));
    // A note says where a name is defined again.
    let last: BTreeMap<&str, _> = symbols.map(|(at, symbol)| (&symbol.name[..], (at, symbol))).collect();
    for (name, (at, _)) in last.into_iter().filter(|(_, (_, symbol))| symbol.uses.is_empty()) {
        let message = format!("object \"{}\" is defined and never used", shown(name.as_bytes()));
        warn(report, at, message, "place it with ObjectInstance");
    }
}
