//! Collects what is wrong while a scene is resolved.

use std::collections::{HashMap, HashSet};

use lookat_syntax::{Diagnostic, Severity, Span};

use crate::sources::Sources;

/// Diagnostics so far.
#[derive(Debug, Default)]
pub(crate) struct Report {
    diagnostics: Vec<Diagnostic>,
    /// For messages that are said once: the diagnostic and how many places it stands for.
    once: HashMap<String, (usize, usize)>,
}

impl Report {
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    pub fn extend(&mut self, diagnostics: Vec<Diagnostic>) {
        self.diagnostics.extend(diagnostics);
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

    /// Everything in the order in which the scene is read; of what an Include repeats, the first.
    pub fn finish(mut self, sources: &Sources) -> Vec<Diagnostic> {
        for (index, places) in self.once.into_values() {
            if places > 1 {
                let others = places - 1;
                let noun = if others == 1 { "place" } else { "places" };
                self.diagnostics[index].labels[0].text = format!("and at {others} other {noun}");
            }
        }
        self.diagnostics.sort_by_cached_key(|diagnostic| sources.reading_order(diagnostic.span()));
        let mut seen = HashSet::new();
        self.diagnostics.retain(|diagnostic| {
            let span = diagnostic.span();
            seen.insert((sources.file(span.file).path.clone(), span.start, diagnostic.message.clone()))
        });
        self.diagnostics
    }

    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(|diagnostic| diagnostic.severity == Severity::Error)
    }
}
