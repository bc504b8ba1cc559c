//! The messages about directives: what parameters they have, and other values for them.

use std::path::Path;

use lookat_scene::Sources;
use lookat_scene::syntax::{FileId, Span};
use serde::{Deserialize, Serialize};

use crate::report;

/// A place of the text, as pages name it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct At {
    /// Counts how often the scene has been read. Another text has other places.
    pub reading: u32,
    pub file: u32,
    pub start: u32,
}

impl At {
    pub fn span(self) -> Span {
        Span { file: FileId(self.file), start: self.start, end: self.start.saturating_add(1) }
    }
}

/// A place of the text, as pages show it.
#[derive(Debug, Serialize)]
pub struct Place {
    pub at: At,
    /// file:line:column
    pub text: String,
    /// The absolute path of the file.
    pub path: String,
    pub line: usize,
    pub column: usize,
}

impl Place {
    pub fn new(span: Span, sources: &Sources, reading: u32) -> Place {
        let found = sources.location(span);
        let path = std::path::absolute(found.path);
        Place {
            at: At { reading, file: span.file.0, start: span.start },
            text: report::place(span, sources),
            path: path.as_deref().unwrap_or(Path::new("")).display().to_string(),
            line: found.line,
            column: found.column,
        }
    }
}

/// A directive with its parameters.
#[derive(Debug, Serialize)]
pub struct Described {
    pub directive: &'static str,
    /// The type, such as `matte`.
    pub kind: &'static str,
    /// The name of a named material.
    pub name: Option<String>,
    pub place: Place,
    pub parameters: Vec<Parameter>,
}

#[derive(Debug, Serialize)]
pub struct Parameter {
    /// As in the schema that `explain --json` prints.
    pub facts: serde_json::Value,
    /// What the text gives it. `None` for the default.
    pub given: Option<Given>,
}

/// A parameter in the text.
#[derive(Debug, Serialize)]
pub struct Given {
    #[serde(rename = "type")]
    pub ty: &'static str,
    pub values: Values,
}

/// Numbers, or words: strings, names of textures and files, `true` and `false`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Values {
    Numbers(Vec<f64>),
    Words(Vec<String>),
}

/// Asks to give a parameter other values, without writing the file.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Change {
    pub by: u32,
    pub number: u32,
    /// The directives that the page shows: the answer describes them again.
    pub shown: Vec<At>,
    pub at: At,
    pub name: String,
    /// The type of the values, as the text spells it.
    pub value_type: String,
    pub values: Values,
}

/// The answer to a change.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Changed {
    pub by: u32,
    pub number: u32,
    pub directives: Vec<Described>,
    /// Why nothing has changed.
    pub refused: Option<String>,
}

/// Asks to open a place in the editor.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Open {
    pub by: u32,
    pub at: At,
}
