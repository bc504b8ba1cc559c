//! The error for an undefined name.

use lookat_syntax::{Diagnostic, Text, nearest};

use crate::elsewhere::{Kind, in_order};
use crate::report::Report;

/// Reports an undefined name, unless a missing file may define it.
pub(crate) fn undefined<'n>(
    report: &mut Report,
    kind: Kind,
    name: &Text,
    known: impl Iterator<Item = &'n String>,
) {
    if report.incomplete {
        return;
    }
    let error = Diagnostic::error(name.span, format!("there is no {} \"{}\"", kind.name(), name.value));
    if report.is_long() {
        report.push(error);
        return;
    }
    let definer = kind.definer();
    let Some(known) = in_order(known.map(String::as_str)) else {
        report.undefined(kind, name, error.help(format!("define it with {definer}")));
        return;
    };
    let error = match nearest(&name.value, known.iter().copied()) {
        Some(near) => error.help(format!("did you mean \"{near}\"?")).fix(name.span, format!("\"{near}\"")),
        None if known.is_empty() => {
            error.help(format!("define it with {definer}; none is defined at this point"))
        }
        None => error.help(format!("define it with {definer}; defined here: {}", listed(&known))),
    };
    report.undefined(kind, name, error);
}

/// Lists names for a message, and counts the rest.
fn listed(names: &[&str]) -> String {
    let shown = names.iter().take(8).map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
    if names.len() > 8 { format!("{shown} and {} more", names.len() - 8) } else { shown }
}
