//! Finds definitions in other places for names that are undefined at their use.

use std::collections::HashMap;

use lookat_syntax::{Diagnostic, Span, Text, nearest};

/// The kinds of named things.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Kind {
    Material,
    FloatTexture,
    SpectrumTexture,
    Object,
    Medium,
    CoordinateSystem,
}

impl Kind {
    /// The kind of textures with this value type.
    pub fn of_texture(values: &str) -> Option<Kind> {
        match values {
            "float" => Some(Kind::FloatTexture),
            "spectrum" | "color" => Some(Kind::SpectrumTexture),
            _ => None,
        }
    }

    /// The kind in words.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Material => "named material",
            Kind::FloatTexture => "float texture",
            Kind::SpectrumTexture => "spectrum texture",
            Kind::Object => "object",
            Kind::Medium => "medium",
            Kind::CoordinateSystem => "coordinate system",
        }
    }

    /// The directive that defines this kind.
    pub fn definer(self) -> &'static str {
        match self {
            Kind::Material => "MakeNamedMaterial",
            Kind::FloatTexture | Kind::SpectrumTexture => "Texture",
            Kind::Object => "ObjectBegin",
            Kind::Medium => "MakeNamedMedium",
            Kind::CoordinateSystem => "CoordinateSystem",
        }
    }
}

/// The definitions in all blocks, and uses outside their blocks.
#[derive(Debug, Default)]
pub(crate) struct Elsewhere {
    /// The first and last definition of each name.
    places: HashMap<(Kind, String), [Span; 2]>,
    undefined: Vec<Undefined>,
}

#[derive(Debug)]
struct Undefined {
    kind: Kind,
    name: String,
    /// The index of its diagnostic.
    diagnostic: usize,
    /// An earlier definition in a closed block.
    before: Option<Span>,
}

impl Elsewhere {
    pub fn define(&mut self, kind: Kind, name: &Text) {
        let places = self.places.entry((kind, name.value.clone())).or_insert([name.span; 2]);
        places[1] = name.span;
    }

    /// Stores the use of an undefined name.
    pub fn undefined(&mut self, kind: Kind, name: &Text, diagnostic: usize) {
        let key = (kind, name.value.clone());
        let before = self.places.get(&key).map(|[_, last]| *last);
        self.undefined.push(Undefined { kind, name: key.1, diagnostic, before });
    }

    /// Adds the places of other definitions to the diagnostics, instead of similar names.
    pub fn explain(self, diagnostics: &mut [Diagnostic]) {
        for Undefined { kind, name, diagnostic, before } in &self.undefined {
            let (error, definer) = (&mut diagnostics[*diagnostic], kind.definer());
            let first = self.places.get(&(*kind, name.clone())).map(|[first, _]| first);
            let (place, text, help) = match (before, first) {
                (Some(place), _) => (
                    *place,
                    "it is defined here, in a block that has ended",
                    format!("a definition lasts until the end of its block: move {definer} before the block"),
                ),
                // Skip the directive that uses the name.
                (None, Some(place)) if !is_before(*place, error.span()) => {
                    (*place, "it is defined here, too late", format!("move {definer} before the first use"))
                }
                (None, None) if error.fix.is_none() => match self.nearest(*kind, name) {
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

    /// The most similar name in any block.
    fn nearest(&self, kind: Kind, name: &str) -> Option<(&str, Span)> {
        let of_kind = || self.places.iter().filter(|((of, _), _)| *of == kind);
        let names = in_order(of_kind().map(|((_, name), _)| name.as_str()))?;
        let near = nearest(name, names)?;
        of_kind().find(|((_, name), _)| name == near).map(|(_, [first, _])| (near, *first))
    }
}

/// Names in sorted order, so that messages are deterministic. `None` for more than 10,000 names.
pub(crate) fn in_order<'n>(names: impl Iterator<Item = &'n str>) -> Option<Vec<&'n str>> {
    const MOST: usize = 10_000;
    let mut names: Vec<&str> = names.take(MOST + 1).collect();
    names.sort_unstable();
    (names.len() <= MOST).then_some(names)
}

fn is_before(a: Span, b: Span) -> bool {
    a.file == b.file && a.start < b.start
}
