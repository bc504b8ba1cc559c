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
mod brackets;
mod commas;
mod decimal;
mod diagnostic;
mod directive;
mod form;
mod format;
mod grammar;
mod lists;
mod nearest;
mod param;
mod quotes;
mod recovery;
mod span;
mod statement_at;
mod synonyms;
mod token;
mod values;
mod words;

pub use decimal::{decimal, digits};
pub use diagnostic::{Diagnostic, Fix, Label, Severity};
pub use directive::{ActiveTransform, Directive, Entity, EntityKind, Statement};
pub use form::Form;
pub use grammar::{KnownList, LongList, Parsed, Parser, number_bytes, parse, read_list};
pub use nearest::{begun, nearest, same_digits};
pub use param::{Param, ParamType, Values};
pub use span::{FileId, Span, Spanned, Text};
pub use statement_at::statement_at;
pub use synonyms::directive_advice;
pub use token::{shown, value_span};
