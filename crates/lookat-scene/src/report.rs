//! Collects what is wrong while a scene is resolved.

use std::collections::{HashMap, HashSet};

use lookat_syntax::{Diagnostic, Severity, Span, Text};

use crate::elsewhere::{Elsewhere, Kind};
use crate::sources::Sources;

/// Diagnostics so far.
#[derive(Debug, Default)]
pub(crate) struct Report {
    diagnostics: Vec<Diagnostic>,
    /// For messages that are said once: the diagnostic and how many places it stands for.
    once: HashMap<String, (usize, usize)>,
    elsewhere: Elsewhere,
    /// What only pbrt-v4 has.
    v4_marks: Vec<Span>,
    /// A file could not be included: what it defines is missing, which is no other mistake.
    pub incomplete: bool,
    /// The last directive of a file could not be read: what should follow it may be part of it.
    pub incomplete_end: bool,
    /// Why what the caller asks for does not fit this scene.
    pub misfit: Option<String>,
    /// A part of the directive could not be read: of its parameters only what holds whatever that was is told.
    pub partial: bool,
}

/// Of one message at most this many are told; the last says how many more there are.
const MOST_ALIKE: usize = 10;

impl Report {
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    pub fn extend(&mut self, diagnostics: Vec<Diagnostic>) {
        self.diagnostics.extend(diagnostics);
    }

    /// Keeps the place where a name is defined.
    pub fn define(&mut self, kind: Kind, name: &Text) {
        self.elsewhere.define(kind, name);
    }

    /// The error for a name that is not defined where it is used. Where else it is defined is told in the end.
    pub fn undefined(&mut self, kind: Kind, name: &Text, error: Diagnostic) {
        self.elsewhere.undefined(kind, name, self.diagnostics.len());
        self.diagnostics.push(error);
    }

    /// A warning about a feature: said at the first place, counted at the others.
    pub fn unsupported(&mut self, span: Span, message: String) {
        self.once(Diagnostic::warning(span, message));
    }

    /// Says a message at its first place only.
    pub fn once(&mut self, diagnostic: Diagnostic) {
        let next = self.diagnostics.len();
        let (_, places) = self.once.entry(diagnostic.message.clone()).or_insert((next, 0));
        *places += 1;
        if *places == 1 {
            self.diagnostics.push(diagnostic);
        }
    }

    /// Keeps places of what only pbrt-v4 has.
    pub fn v4_marks(&mut self, places: impl IntoIterator<Item = Span>) {
        self.v4_marks.extend(places);
    }

    /// Whether this is a scene for pbrt-v4: one mark alone may be a slip.
    pub fn is_v4(&self, sources: &Sources) -> bool {
        self.v4_places(sources).len() > 1
    }

    /// What only pbrt-v4 has, in the order in which the scene is read; what an Include repeats counts once.
    fn v4_places(&self, sources: &Sources) -> Vec<Span> {
        let mut places = self.v4_marks.clone();
        places.sort_by_cached_key(|place| sources.reading_order(*place));
        let mut seen = HashSet::new();
        places.retain(|place| seen.insert((&sources.file(place.file).path, place.start)));
        places
    }

    /// Whether there is so much to tell that searching for advice is no longer worth the time.
    pub fn is_long(&self) -> bool {
        self.diagnostics.len() > 100
    }

    /// Whether there is an error in front of a place of the same file.
    pub fn has_errors_before(&self, at: Span) -> bool {
        let before = |span: Span| span.file == at.file && span.start < at.start;
        self.errors().any(|error| before(error.span()))
    }

    fn errors(&self) -> impl Iterator<Item = &Diagnostic> {
        self.diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error)
    }

    /// Everything in the order in which the scene is read; of what an Include repeats, the first.
    pub fn finish(mut self, sources: &Sources) -> Vec<Diagnostic> {
        for (index, places) in std::mem::take(&mut self.once).into_values() {
            if places > 1 {
                let others = places - 1;
                let noun = if others == 1 { "place" } else { "places" };
                self.diagnostics[index].labels[0].text = format!("and at {others} other {noun}");
            }
        }
        std::mem::take(&mut self.elsewhere).explain(&mut self.diagnostics);
        self.diagnostics.sort_by_cached_key(|diagnostic| sources.reading_order(diagnostic.span()));
        let mut seen = HashSet::new();
        self.diagnostics.retain(|diagnostic| {
            let span = diagnostic.span();
            seen.insert((sources.file(span.file).path.clone(), span.start, diagnostic.message.clone()))
        });
        cut_alike(&mut self.diagnostics);
        let v4_places = self.v4_places(sources);
        if let [first, _, ..] = v4_places[..] {
            // One thing is wrong with the scene, not as many as its file has marks.
            let told: HashSet<Span> =
                v4_places.iter().copied().filter(|place| place.file == first.file).collect();
            self.diagnostics.retain(|diagnostic| !told.contains(&diagnostic.span()));
            self.diagnostics.insert(0, v4_scene(&v4_places, sources));
        }
        self.diagnostics
    }

    pub fn has_errors(&self) -> bool {
        self.errors().next().is_some()
    }
}

/// Of a scene for pbrt-v4 at most so many lines are named.
const MOST_LINES: usize = 20;

/// The diagnostic of a scene for another program: it stands for those of all its marks.
fn v4_scene(marks: &[Span], sources: &Sources) -> Diagnostic {
    let (first, count) = (marks[0], marks.len());
    let here = marks.iter().filter(|mark| mark.file == first.file);
    let mut lines: Vec<usize> = here.map(|mark| sources.line(*mark)).collect();
    lines.dedup();
    let mut others: Vec<String> = lines[1..].iter().take(MOST_LINES).map(usize::to_string).collect();
    if lines.len() > 1 + MOST_LINES {
        others.push("more".into());
    }
    let others = match &others[..] {
        [] => String::new(),
        [line] => format!("; see line {line}"),
        lines => format!("; see lines {}", lines.join(", ")),
    };
    Diagnostic::error(first, "this is a pbrt-v4 scene; lookat reads the pbrt-v3 format")
        .note(format!("the first of {count} things that only pbrt-v4 has{others}"))
        .help("pbrt-v4 changed directives, types and parameters: look for a pbrt-v3 version of the scene")
}

/// Leaves out what is said over and over.
fn cut_alike(diagnostics: &mut Vec<Diagnostic>) {
    let mut alike: HashMap<String, usize> = HashMap::new();
    diagnostics.iter().for_each(|d| *alike.entry(d.message.clone()).or_default() += 1);
    let mut told: HashMap<String, usize> = HashMap::new();
    diagnostics.retain_mut(|diagnostic| {
        let (all, told) = (alike[&diagnostic.message], told.entry(diagnostic.message.clone()).or_default());
        *told += 1;
        if *told == MOST_ALIKE && all > MOST_ALIKE {
            diagnostic.more = all - MOST_ALIKE;
            diagnostic.labels[0].text = format!("and at {} more places", diagnostic.more);
        }
        *told <= MOST_ALIKE
    });
}
