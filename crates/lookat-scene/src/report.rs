//! Collects diagnostics while a scene is resolved.

use std::collections::{HashMap, HashSet};

use lookat_syntax::{Diagnostic, Label, Severity, Span, Text};

use crate::sources::Sources;
use crate::symbols::{Symbol, SymbolKind, Symbols, Undefined, explain, undefined, with_help};

/// Diagnostics so far.
#[derive(Debug, Default)]
pub(crate) struct Report {
    diagnostics: Vec<Diagnostic>,
    /// The diagnostic that stands for all places with a problem.
    known: HashMap<Problem, usize>,
    /// Places of all diagnostics together.
    places: usize,
    /// Definitions and uses so far.
    pub symbols: Symbols,
    undefined: Vec<Undefined>,
    /// Places of pbrt-v4 features.
    v4_marks: Vec<Span>,
    /// True if an included file is missing. Its definitions are then missing too, which is not another error.
    pub incomplete: bool,
    /// True if the memory limit ended reading. Then no part of the scene stands for all of it.
    pub exhausted: bool,
    /// True if the last directive of a file is incomplete and may have swallowed the text after it.
    pub incomplete_end: bool,
    /// The reason why an override of the caller does not fit this scene.
    pub override_error: Option<String>,
    /// True if a part of the current directive is unreadable. Then only problems that do not depend on this part are
    /// reported.
    pub partial: bool,
}

impl Report {
    /// Adds a diagnostic. If the same problem is already known, adds only its places.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.places += diagnostic.all_places().count();
        let next = self.diagnostics.len();
        match *self.known.entry(Problem::of(&diagnostic)).or_insert(next) {
            index if index < next => self.diagnostics[index].places.extend(diagnostic.all_places()),
            _ => self.diagnostics.push(diagnostic),
        }
    }

    pub fn extend(&mut self, diagnostics: impl IntoIterator<Item = Diagnostic>) {
        for diagnostic in diagnostics {
            self.push(diagnostic);
        }
    }

    /// The number of places reported so far.
    pub fn count(&self) -> usize {
        self.places
    }

    /// Reports an undefined name, unless a missing file may define it. `finish` adds definitions in other places.
    pub fn undefined<'n>(&mut self, kind: SymbolKind, name: &Text, known: impl Iterator<Item = &'n String>) {
        self.symbols.use_undefined(kind, name);
        if self.incomplete {
            return;
        }
        let warning = undefined(kind, name);
        if self.is_long() {
            self.push(warning);
            return;
        }
        self.places += 1;
        let (diagnostic, symbols) = (self.diagnostics.len(), self.symbols.list.len());
        self.undefined.push(Undefined { kind, name: name.value.clone(), diagnostic, symbols });
        self.diagnostics.push(with_help(warning, kind, name, known));
    }

    /// A warning about a feature that is not rendered.
    pub fn unsupported(&mut self, span: Span, message: String) {
        self.push(Diagnostic::warning(span, message));
    }

    /// Stores places of pbrt-v4 features.
    pub fn v4_marks(&mut self, places: impl IntoIterator<Item = Span>) {
        self.v4_marks.extend(places);
    }

    /// True for a pbrt-v4 scene, which has at least two pbrt-v4 features: one alone may be a typing mistake.
    pub fn is_v4(&self, sources: &Sources) -> bool {
        self.v4_places(sources).len() > 1
    }

    /// The places of pbrt-v4 features in reading order, each once.
    fn v4_places(&self, sources: &Sources) -> Vec<Span> {
        in_reading_order(self.v4_marks.clone(), None, sources)
    }

    /// True if there are so many diagnostics that the search for advice takes too long.
    pub fn is_long(&self) -> bool {
        self.places > 100
    }

    /// True if the same file has an error before a place.
    pub fn has_errors_before(&self, at: Span) -> bool {
        let before = |span: Span| span.file == at.file && span.start < at.start;
        self.errors().any(|error| error.all_places().any(before))
    }

    fn errors(&self) -> impl Iterator<Item = &Diagnostic> {
        self.diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error)
    }

    /// Returns all diagnostics in the order in which the scene is read, and the symbols. A place that an Include repeats
    /// counts once.
    pub fn finish(mut self, sources: &Sources) -> (Vec<Diagnostic>, Vec<Symbol>) {
        explain(&self.undefined, &self.symbols.list, &mut self.diagnostics);
        // Explanations can make two problems equal, so merge them again.
        self.known.clear();
        for diagnostic in std::mem::take(&mut self.diagnostics).into_iter() {
            self.push(diagnostic);
        }
        for diagnostic in self.diagnostics.iter_mut().filter(|diagnostic| !diagnostic.places.is_empty()) {
            order_places(diagnostic, sources);
        }
        self.diagnostics.sort_by_cached_key(|diagnostic| sources.reading_order(diagnostic.span()));
        let v4_places = self.v4_places(sources);
        if let [first, _, ..] = v4_places[..] {
            // Report one problem instead of one for each feature.
            let replaced: HashSet<Span> =
                v4_places.iter().copied().filter(|place| place.file == first.file).collect();
            self.diagnostics.retain(|diagnostic| !replaced.contains(&diagnostic.span()));
            self.diagnostics.insert(0, v4_scene(&v4_places, sources));
        }
        (self.diagnostics, self.symbols.list)
    }

    pub fn has_errors(&self) -> bool {
        self.errors().next().is_some()
    }
}

/// The identity of a problem. Diagnostics with the same words, the same edit and the same related places are one
/// problem.
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

/// The most lines named for a pbrt-v4 scene.
const MOST_LINES: usize = 20;

/// The single diagnostic of a pbrt-v4 scene.
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
        .note(format!("the first of {count} pbrt-v4 features{others}"))
        .help("pbrt-v4 changed directives, types and parameters: use a pbrt-v3 version of the scene")
}

/// Sorts the places of a problem. Its place is the first in its file, unless its fix belongs to another one.
fn order_places(diagnostic: &mut Diagnostic, sources: &Sources) {
    let mut places: Vec<Span> = diagnostic.all_places().collect();
    if diagnostic.fix.is_none() {
        let at = diagnostic.span();
        let of_file = places.iter().filter(|place| place.file == at.file);
        diagnostic.labels[0].span = *of_file.min_by_key(|place| place.start).unwrap_or(&at);
    }
    places.retain(|place| *place != diagnostic.span());
    diagnostic.places = in_reading_order(places, Some(diagnostic.span()), sources);
}

/// Sorts places in the order in which the scene is read, and removes `left_out`. A place in a file that is included
/// again counts once.
fn in_reading_order(mut places: Vec<Span>, left_out: Option<Span>, sources: &Sources) -> Vec<Span> {
    places.sort_by_cached_key(|place| sources.reading_order(*place));
    let key = |place: &Span| (&sources.file(place.file).path, place.start);
    let mut seen: HashSet<_> = left_out.iter().map(key).collect();
    places.retain(|place| seen.insert(key(place)));
    places
}
