//! Collects what is wrong while a scene is resolved.

use std::collections::{HashMap, HashSet};

use lookat_syntax::{Diagnostic, Label, Severity, Span, Text};

use crate::elsewhere::{Elsewhere, Kind};
use crate::sources::Sources;

/// Diagnostics so far.
#[derive(Debug, Default)]
pub(crate) struct Report {
    diagnostics: Vec<Diagnostic>,
    /// The diagnostic that stands for all places with a problem.
    known: HashMap<Problem, usize>,
    /// Places of all diagnostics together.
    places: usize,
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

impl Report {
    /// Keeps a diagnostic; where there is one for the same problem already, only its places.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.places += 1;
        let next = self.diagnostics.len();
        match *self.known.entry(Problem::of(&diagnostic)).or_insert(next) {
            index if index < next => self.diagnostics[index].places.extend(diagnostic.all_places()),
            _ => self.diagnostics.push(diagnostic),
        }
    }

    pub fn extend(&mut self, diagnostics: impl IntoIterator<Item = Diagnostic>) {
        diagnostics.into_iter().for_each(|diagnostic| self.push(diagnostic));
    }

    /// Keeps the place where a name is defined.
    pub fn define(&mut self, kind: Kind, name: &Text) {
        self.elsewhere.define(kind, name);
    }

    /// The error for a name that is not defined where it is used. Where else it is defined is told in the end.
    pub fn undefined(&mut self, kind: Kind, name: &Text, error: Diagnostic) {
        self.places += 1;
        self.elsewhere.undefined(kind, name, self.diagnostics.len());
        self.diagnostics.push(error);
    }

    /// A warning about a feature that is not rendered.
    pub fn unsupported(&mut self, span: Span, message: String) {
        self.push(Diagnostic::warning(span, message));
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
        in_reading_order(self.v4_marks.clone(), None, sources)
    }

    /// Whether there is so much to tell that searching for advice is no longer worth the time.
    pub fn is_long(&self) -> bool {
        self.places > 100
    }

    /// Whether there is an error in front of a place of the same file.
    pub fn has_errors_before(&self, at: Span) -> bool {
        let before = |span: Span| span.file == at.file && span.start < at.start;
        self.errors().any(|error| error.all_places().any(before))
    }

    fn errors(&self) -> impl Iterator<Item = &Diagnostic> {
        self.diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error)
    }

    /// Everything in the order in which the scene is read; of places that an Include repeats, the first.
    pub fn finish(mut self, sources: &Sources) -> Vec<Diagnostic> {
        std::mem::take(&mut self.elsewhere).explain(&mut self.diagnostics);
        // What is explained now may be the same problem.
        self.known.clear();
        std::mem::take(&mut self.diagnostics).into_iter().for_each(|diagnostic| self.push(diagnostic));
        self.diagnostics.sort_by_cached_key(|diagnostic| sources.reading_order(diagnostic.span()));
        for diagnostic in self.diagnostics.iter_mut().filter(|diagnostic| !diagnostic.places.is_empty()) {
            diagnostic.places =
                in_reading_order(std::mem::take(&mut diagnostic.places), Some(diagnostic.span()), sources);
        }
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

/// What makes diagnostics of several places one: the same words, the same edit and the same related places.
#[derive(Debug, PartialEq, Eq, Hash)]
struct Problem {
    severity: Severity,
    message: String,
    help: Option<String>,
    replacement: Option<String>,
    related: Vec<Label>,
}

impl Problem {
    fn of(diagnostic: &Diagnostic) -> Problem {
        Problem {
            severity: diagnostic.severity,
            message: diagnostic.message.clone(),
            help: diagnostic.help.clone(),
            replacement: diagnostic.fix.as_ref().map(|fix| fix.replacement.clone()),
            related: diagnostic.labels[1..].to_vec(),
        }
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

/// Places in the order in which the scene is read, without the one to leave out. A place in a file that is included again
/// counts once.
fn in_reading_order(mut places: Vec<Span>, left_out: Option<Span>, sources: &Sources) -> Vec<Span> {
    places.sort_by_cached_key(|place| sources.reading_order(*place));
    let key = |place: &Span| (&sources.file(place.file).path, place.start);
    let mut seen: HashSet<_> = left_out.iter().map(key).collect();
    places.retain(|place| seen.insert(key(place)));
    places
}
