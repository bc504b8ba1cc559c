//! The error for an undefined name.

use std::collections::HashMap;

use lookat_syntax::{Diagnostic, Span, Text, nearest};

use crate::symbols::{Symbol, SymbolKind};

/// The error for an undefined name, without advice.
pub(crate) fn undefined(kind: SymbolKind, name: &Text) -> Diagnostic {
    Diagnostic::error(name.span, format!("there is no {} \"{}\"", kind.name(), name.value))
}

/// Adds how to define the name, or a similar one of the `known` names.
pub(crate) fn with_help<'n>(
    error: Diagnostic,
    kind: SymbolKind,
    name: &Text,
    known: impl Iterator<Item = &'n String>,
) -> Diagnostic {
    let definer = kind.definer();
    let Some(known) = in_order(known.map(String::as_str)) else {
        return error.help(format!("define it with {definer}"));
    };
    match nearest(&name.value, known.iter().copied()) {
        Some(near) => error.help(format!("did you mean \"{near}\"?")).fix(name.span, format!("\"{near}\"")),
        None if known.is_empty() => {
            error.help(format!("define it with {definer}; none is defined at this point"))
        }
        None => error.help(format!("define it with {definer}; defined here: {}", listed(&known))),
    }
}

/// Lists names for a message, and counts the rest.
fn listed(names: &[&str]) -> String {
    let shown = names.iter().take(8).map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
    if names.len() > 8 { format!("{shown} and {} more", names.len() - 8) } else { shown }
}

/// The use of an undefined name.
#[derive(Debug)]
pub(crate) struct Undefined {
    pub kind: SymbolKind,
    pub name: String,
    /// The index of its diagnostic.
    pub diagnostic: usize,
    /// The number of symbols before it.
    pub symbols: usize,
}

/// Adds the places of definitions in other blocks to the diagnostics, instead of similar names.
pub(crate) fn explain(undefined: &[Undefined], symbols: &[Symbol], diagnostics: &mut [Diagnostic]) {
    if undefined.is_empty() {
        return;
    }
    let elsewhere = Elsewhere::new(symbols);
    for Undefined { kind, name, diagnostic, symbols } in undefined {
        let (error, definer) = (&mut diagnostics[*diagnostic], kind.definer());
        let definitions = elsewhere.of(*kind, name);
        let before = definitions.iter().rfind(|(index, _)| index < symbols);
        let (place, text, help) = match (before, definitions.first()) {
            (Some((_, place)), _) => (
                *place,
                "it is defined here, in a block that has ended",
                format!("a definition lasts until the end of its block: move {definer} before the block"),
            ),
            // Skip the directive that uses the name.
            (None, Some((_, place))) if !is_before(*place, error.span()) => {
                (*place, "it is defined here, too late", format!("move {definer} before the first use"))
            }
            (None, None) if error.fix.is_none() => match elsewhere.nearest(*kind, name) {
                Some((near, place)) => (
                    place,
                    "this name is defined here, too late or in a block that has ended",
                    format!(
                        "did you mean \"{near}\"? move {definer} before its use, and out of blocks that end earlier"
                    ),
                ),
                None => continue,
            },
            _ => continue,
        };
        *error = error.clone().related(place, text).help(help);
        error.fix = None;
    }
}

/// The definitions in all blocks: the index of the symbol and its place.
struct Elsewhere<'s> {
    definitions: HashMap<(SymbolKind, &'s str), Vec<(usize, Span)>>,
}

impl<'s> Elsewhere<'s> {
    fn new(symbols: &'s [Symbol]) -> Self {
        let mut definitions: HashMap<_, Vec<(usize, Span)>> = HashMap::new();
        for (index, symbol) in symbols.iter().enumerate() {
            if let Some(place) = symbol.definition {
                definitions.entry((symbol.kind, &symbol.name[..])).or_default().push((index, place));
            }
        }
        Elsewhere { definitions }
    }

    fn of<'a>(&'a self, kind: SymbolKind, name: &'a str) -> &'a [(usize, Span)] {
        self.definitions.get(&(kind, name)).map_or(&[], |places| places)
    }

    /// The most similar name in any block.
    fn nearest(&self, kind: SymbolKind, name: &str) -> Option<(&'s str, Span)> {
        let names = self.definitions.keys().filter(|(of, _)| *of == kind).map(|(_, name)| *name);
        let near = nearest(name, in_order(names)?)?;
        self.of(kind, near).first().map(|(_, place)| (near, *place))
    }
}

/// Names in sorted order, so that messages are deterministic. `None` for more than 10,000 names.
fn in_order<'n>(names: impl Iterator<Item = &'n str>) -> Option<Vec<&'n str>> {
    const MOST: usize = 10_000;
    let mut names: Vec<&str> = names.take(MOST + 1).collect();
    names.sort_unstable();
    (names.len() <= MOST).then_some(names)
}

fn is_before(a: Span, b: Span) -> bool {
    a.file == b.file && a.start < b.start
}
