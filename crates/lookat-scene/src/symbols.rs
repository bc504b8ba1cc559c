//! Named things: where each is defined and used, and errors for undefined names.

use std::collections::hash_map::Entry;
use std::collections::{BTreeSet, HashMap};
use std::ops::Index;

use lookat_syntax::{Diagnostic, Span, Text, nearest};

/// The kinds of named things. Each kind has its own names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SymbolKind {
    /// A material of `MakeNamedMaterial`.
    Material,
    /// A `Texture` with float values.
    FloatTexture,
    /// A `Texture` with spectrum values.
    SpectrumTexture,
    /// An object of `ObjectBegin`.
    Object,
    /// A medium of `MakeNamedMedium`.
    Medium,
    /// A transformation of `CoordinateSystem`.
    CoordinateSystem,
    /// A file of `Include`.
    Include,
}

impl SymbolKind {
    /// The kind in words.
    pub fn name(self) -> &'static str {
        self.words().0
    }

    /// The directive that defines this kind, or includes the file.
    pub fn definer(self) -> &'static str {
        self.words().1
    }

    /// What is rendered where a name of this kind is undefined.
    fn without(self) -> &'static str {
        match self {
            SymbolKind::Material => "the material before it, or matte in a mix, is used, as in pbrt-v3",
            SymbolKind::FloatTexture | SymbolKind::SpectrumTexture => {
                "the parameter has its default, as in pbrt-v3"
            }
            SymbolKind::Object => "nothing is placed here, as in pbrt-v3",
            SymbolKind::Medium => "it counts as empty space",
            SymbolKind::CoordinateSystem => "the transformation stays what it is, as in pbrt-v3",
            SymbolKind::Include => "it is left out, as in pbrt-v3",
        }
    }

    fn words(self) -> (&'static str, &'static str) {
        match self {
            SymbolKind::Material => ("named material", "MakeNamedMaterial"),
            SymbolKind::FloatTexture => ("float texture", "Texture"),
            SymbolKind::SpectrumTexture => ("spectrum texture", "Texture"),
            SymbolKind::Object => ("object", "ObjectBegin"),
            SymbolKind::Medium => ("medium", "MakeNamedMedium"),
            SymbolKind::CoordinateSystem => ("coordinate system", "CoordinateSystem"),
            SymbolKind::Include => ("included file", "Include"),
        }
    }
}

/// A named thing. A name that is defined again is another symbol. The coordinate systems `camera` and `world`, which
/// pbrt-v3 defines itself, are no symbols.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Symbol {
    /// What it is.
    pub kind: SymbolKind,
    /// Its name as written; the path of an included file.
    pub name: String,
    /// The name in its definition; the start of an included file. `None` if the name is undefined where it is used, or
    /// the file is unreadable.
    pub definition: Option<Span>,
    /// The names that refer to this definition, in reading order.
    pub uses: Vec<Span>,
}

/// The number of a symbol.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SymbolId(usize);

/// The symbols so far.
#[derive(Debug, Default)]
pub(crate) struct Symbols {
    /// All symbols in the order of their definition, or of the first use of an undefined name.
    pub list: Vec<Symbol>,
    /// Undefined names and included files.
    global: HashMap<(SymbolKind, String), SymbolId>,
}

impl Symbols {
    /// Adds a definition.
    pub fn define(&mut self, kind: SymbolKind, name: &Text) -> SymbolId {
        self.add(Symbol { kind, name: name.value.clone(), definition: Some(name.span), uses: Vec::new() })
    }

    /// Adds a use of a definition.
    pub fn use_at(&mut self, symbol: SymbolId, at: Span) {
        self.list[symbol.0].uses.push(at);
    }

    /// Adds a use of a name without a definition.
    pub fn use_undefined(&mut self, kind: SymbolKind, name: &Text) {
        let symbol = self.global(kind, name.value.clone());
        self.use_at(symbol, name.span);
    }

    /// Adds an `Include` at `name`, of a file that begins at `start`.
    pub fn include(&mut self, path: String, start: Span, name: Span) {
        let symbol = self.global(SymbolKind::Include, path);
        self.list[symbol.0].definition.get_or_insert(start);
        self.use_at(symbol, name);
    }

    fn add(&mut self, symbol: Symbol) -> SymbolId {
        self.list.push(symbol);
        SymbolId(self.list.len() - 1)
    }

    /// The symbol that stands for all uses of a name.
    fn global(&mut self, kind: SymbolKind, name: String) -> SymbolId {
        match self.global.entry((kind, name)) {
            Entry::Occupied(known) => *known.get(),
            Entry::Vacant(new) => {
                let name = new.key().1.clone();
                let symbol = SymbolId(self.list.len());
                self.list.push(Symbol { kind, name, definition: None, uses: Vec::new() });
                *new.insert(symbol)
            }
        }
    }
}

impl Index<SymbolId> for Symbols {
    type Output = Symbol;

    fn index(&self, symbol: SymbolId) -> &Symbol {
        &self.list[symbol.0]
    }
}

/// The warning about an undefined name, without advice. Scenes with such names exist, also among those that come with pbrt-v3, which reports
/// an error and goes on.
pub(crate) fn undefined(kind: SymbolKind, name: &Text) -> Diagnostic {
    let message = format!("there is no {} \"{}\": {}", kind.name(), name.value, kind.without());
    Diagnostic::warning(name.span, message)
}

/// Adds how to define the name, or a similar one of the `known` names.
pub(crate) fn with_help<'n>(
    warning: Diagnostic,
    kind: SymbolKind,
    name: &Text,
    known: impl Iterator<Item = &'n String>,
) -> Diagnostic {
    let definer = kind.definer();
    let Some(known) = in_order(known.map(String::as_str)) else {
        return warning.help(format!("define it with {definer}"));
    };
    match nearest(&name.value, known.iter().copied()) {
        Some(near) => warning.help(format!("did you mean \"{near}\"?")).fix(name.span, format!("\"{near}\"")),
        None if known.is_empty() => {
            warning.help(format!("define it with {definer}; none is defined at this point"))
        }
        None => warning.help(format!("define it with {definer}; defined here: {}", listed(&known))),
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
    let defined =
        symbols.iter().enumerate().filter_map(|(at, symbol)| Some((at, symbol, symbol.definition?)));
    for Undefined { kind, name, diagnostic, symbols } in undefined {
        let (warning, definer) = (&mut diagnostics[*diagnostic], kind.definer());
        let of_kind = defined.clone().filter(|(_, symbol, _)| symbol.kind == *kind);
        let of_name = |name: &str| {
            let of_name = of_kind.clone().filter(|(_, symbol, _)| symbol.name == name);
            of_name.map(|(at, _, place)| (at, place)).collect::<Vec<_>>()
        };
        let definitions = of_name(name);
        let before = definitions.iter().rfind(|(at, _)| at < symbols);
        let (place, text, help) = match (before, definitions.first()) {
            (Some((_, place)), _) => (
                *place,
                "it is defined here, in a block that has ended",
                format!("a definition lasts until the end of its block: move {definer} before the block"),
            ),
            // Skip the directive that uses the name.
            (None, Some((_, place))) if !is_before(*place, warning.span()) => {
                (*place, "it is defined here, too late", format!("move {definer} before the first use"))
            }
            (None, None) if warning.fix.is_none() => {
                // The most similar name in any block.
                let names = of_kind.clone().map(|(_, symbol, _)| &symbol.name[..]);
                let near = in_order(names).and_then(|names| nearest(name, names));
                let Some((near, (_, place))) = near.and_then(|near| Some((near, *of_name(near).first()?)))
                else {
                    continue;
                };
                (
                    place,
                    "this name is defined here, too late or in a block that has ended",
                    format!(
                        "did you mean \"{near}\"? move {definer} before its use, and out of blocks that end earlier"
                    ),
                )
            }
            _ => continue,
        };
        *warning = warning.clone().related(place, text).help(help);
        warning.fix = None;
    }
}

/// Names in sorted order, each once, so that messages are deterministic. `None` for more than 10,000.
fn in_order<'n>(names: impl Iterator<Item = &'n str>) -> Option<Vec<&'n str>> {
    const MOST: usize = 10_000;
    let names: BTreeSet<&str> = names.collect();
    (names.len() <= MOST).then(|| names.into_iter().collect())
}

fn is_before(a: Span, b: Span) -> bool {
    a.file == b.file && a.start < b.start
}

#[cfg(test)]
mod tests {
    use std::io::ErrorKind;
    use std::path::Path;

    use crate::{LoadOptions, Loaded, SymbolKind, load};

    const HEAD: &str =
        "Camera \"perspective\" Film \"image\" Sampler \"sobol\" Integrator \"path\" WorldBegin\n";

    fn loaded(files: &[(&str, &str)]) -> Loaded {
        let read = |path: &Path| match files.iter().find(|(name, _)| Path::new(name) == path) {
            Some((_, text)) => Ok(text.as_bytes().to_vec()),
            None => Err(ErrorKind::NotFound.into()),
        };
        load(Path::new("a.pbrt"), &read, &LoadOptions::default())
    }

    /// Each symbol as its kind, name, and the lines of its definition (0 for none) and its uses.
    fn symbols(files: &[(&str, &str)]) -> Vec<(SymbolKind, String, usize, Vec<usize>)> {
        let Loaded { symbols, sources, .. } = loaded(files);
        let line = |span| sources.location(span).line;
        let lines = |symbol: crate::Symbol| {
            let uses = symbol.uses.iter().map(|at| line(*at)).collect();
            (symbol.kind, symbol.name, symbol.definition.map_or(0, line), uses)
        };
        symbols.into_iter().map(lines).collect()
    }

    #[test]
    fn every_kind_has_its_definition_and_uses() {
        let world = "MakeNamedMaterial \"m\" \"string type\" \"matte\"
            Texture \"t\" \"float\" \"constant\" Texture \"t\" \"color\" \"constant\"
            MakeNamedMedium \"fog\" CoordinateSystem \"here\"
            ObjectBegin \"o\" Shape \"sphere\" ObjectEnd
            NamedMaterial \"m\" Material \"matte\" \"texture Kd\" \"t\" \"texture sigma\" \"t\"
            MediumInterface \"fog\" \"\" CoordSysTransform \"here\" CoordSysTransform \"camera\"
            ObjectInstance \"o\" ObjectInstance \"o\"
            Material \"mix\" \"string namedmaterial1\" \"m\" \"string namedmaterial2\" \"m\" WorldEnd";
        let found = symbols(&[("a.pbrt", &format!("{HEAD}{world}"))]);
        let expected = [
            (SymbolKind::Material, "m", 2, vec![6, 9, 9]),
            (SymbolKind::FloatTexture, "t", 3, vec![6]),
            (SymbolKind::SpectrumTexture, "t", 3, vec![6]),
            (SymbolKind::Medium, "fog", 4, vec![7]),
            (SymbolKind::CoordinateSystem, "here", 4, vec![7]),
            (SymbolKind::Object, "o", 5, vec![8, 8]),
        ];
        assert_eq!(
            found,
            expected.map(|(kind, name, definition, uses)| (kind, name.into(), definition, uses))
        );
    }

    #[test]
    fn a_use_belongs_to_the_definition_in_scope() {
        let define = "MakeNamedMaterial \"m\" \"string type\" \"matte\"";
        let world = format!(
            "{define}\nAttributeBegin {define}\nNamedMaterial \"m\" AttributeEnd\nNamedMaterial \"m\"
            NamedMaterial \"n\" NamedMaterial \"n\" WorldEnd"
        );
        let found = symbols(&[("a.pbrt", &format!("{HEAD}{world}"))]);
        let material = |name: &str, line, uses| (SymbolKind::Material, name.to_owned(), line, uses);
        let expected = [material("m", 2, vec![5]), material("m", 3, vec![4]), material("n", 0, vec![6, 6])];
        assert_eq!(found, expected);
    }

    #[test]
    fn a_file_included_twice_is_one_symbol() {
        let scene = format!("{HEAD}Include \"b.pbrt\"\nInclude \"b.pbrt\"\nInclude \"gone.pbrt\"\nWorldEnd");
        let files = [("a.pbrt", &scene[..]), ("b.pbrt", "Shape \"sphere\"")];
        let include = |name: &str, line, uses| (SymbolKind::Include, name.to_owned(), line, uses);
        assert_eq!(symbols(&files), [include("b.pbrt", 1, vec![2, 3]), include("gone.pbrt", 0, vec![4])]);
        let loaded = loaded(&files);
        assert_eq!(loaded.symbols[0].definition.map(|start| start.file.0), Some(1));
    }
}
