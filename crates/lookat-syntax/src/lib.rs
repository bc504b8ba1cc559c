//! The text format of pbrt-v3 scene files.
//!
//! [`parse`] turns the bytes of one file into a flat list of [`Statement`]s, each with its [`Span`], and reports every
//! violation of the grammar. It opens no file, looks up no name and knows no default. A [`Directive`] prints itself as
//! pbrt text that parses to the same directive.
//!
//! ```
//! use lookat_syntax::{Directive, FileId, parse};
//!
//! let parsed = parse(FileId(0), b"Translate 0 1.5 0");
//! assert!(parsed.diagnostics.is_empty());
//! assert_eq!(parsed.statements[0].directive, Directive::Translate([0.0, 1.5, 0.0]));
//! assert_eq!(parsed.statements[0].directive.to_string(), "Translate 0 1.5 0");
//! ```

mod advice;
mod arguments;
mod diagnostic;
mod directive;
mod format;
mod grammar;
mod numbers;
mod param;
mod recovery;
mod token;
mod values;

pub use advice::{begun, directive_advice, nearest, same_digits};
pub use diagnostic::{Diagnostic, FileId, Fix, Label, Severity, Span, Spanned, Text};
pub use directive::{ActiveTransform, Directive, DirectiveForm, Entity, EntityKind, Statement};
pub use grammar::{KnownList, LongList, Parsed, Parser, number_bytes, parse, read_list, statement_at};
pub use numbers::{decimal, digits};
pub use param::{Param, ParamType, Values};
pub use token::{shown, value_span};
