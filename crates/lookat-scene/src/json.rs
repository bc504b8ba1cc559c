//! Diagnostics as JSON.

use lookat_syntax::{Diagnostic, Fix, Severity, Span};
use serde::Serialize;

use crate::sources::{Location, Sources};

/// A diagnostic as JSON.
#[derive(Debug, Serialize)]
pub struct JsonDiagnostic<'a> {
    /// `error`, `warning` or `note`.
    severity: &'static str,
    /// The problem.
    message: &'a str,
    /// Places, each with a `text` (or ""). The first is the place of the problem.
    labels: Vec<JsonLabel<'a>>,
    /// Other places of the same problem, in reading order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    places: Vec<JsonPlace>,
    /// What to do.
    #[serde(skip_serializing_if = "Option::is_none")]
    help: Option<&'a str>,
    /// A place, and the `replacement` for its text.
    #[serde(skip_serializing_if = "Option::is_none")]
    fix: Option<JsonFix<'a>>,
}

#[derive(Debug, Serialize)]
struct JsonLabel<'a> {
    #[serde(flatten)]
    place: JsonPlace,
    text: &'a str,
}

#[derive(Debug, Serialize)]
struct JsonFix<'a> {
    #[serde(flatten)]
    place: JsonPlace,
    replacement: &'a str,
}

/// Bytes count from 0.
#[derive(Debug, Serialize)]
struct JsonPlace {
    #[serde(flatten)]
    at: Place,
    start: u32,
    end: u32,
}

/// Lines and columns count from 1, columns in characters.
#[derive(Debug, Clone, Serialize)]
pub struct Place {
    /// The file of its directive.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The column, from 1, in characters.
    pub column: usize,
}

impl Place {
    /// The place of a span.
    pub fn new(span: Span, sources: &Sources) -> Place {
        let Location { path, line, column } = sources.location(span);
        Place { file: path.display().to_string(), line, column }
    }
}

/// The diagnostics of a scene as JSON.
pub fn as_json<'a>(diagnostics: &'a [Diagnostic], sources: &Sources) -> Vec<JsonDiagnostic<'a>> {
    let place = |span: Span| JsonPlace { at: Place::new(span, sources), start: span.start, end: span.end };
    diagnostics
        .iter()
        .map(|diagnostic| JsonDiagnostic {
            severity: match diagnostic.severity {
                Severity::Error => "error",
                Severity::Warning => "warning",
                Severity::Note => "note",
            },
            message: &diagnostic.message,
            labels: diagnostic
                .labels
                .iter()
                .map(|it| JsonLabel { place: place(it.span), text: &it.text })
                .collect(),
            places: diagnostic.places.iter().map(|span| place(*span)).collect(),
            help: diagnostic.help.as_deref(),
            fix: diagnostic
                .fix
                .as_ref()
                .map(|Fix { span, replacement }| JsonFix { place: place(*span), replacement }),
        })
        .collect()
}
