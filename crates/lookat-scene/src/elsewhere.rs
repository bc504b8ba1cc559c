//! Names that are used where they are not defined: where else they are.

use std::collections::HashMap;

use lookat_syntax::{Diagnostic, Span, Text, nearest};

/// What has a name.
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
    /// That of textures with values of a type.
    pub fn of_texture(values: &str) -> Option<Kind> {
        match values {
            "float" => Some(Kind::FloatTexture),
            "spectrum" | "color" => Some(Kind::SpectrumTexture),
            _ => None,
        }
    }

    /// In words.
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

    /// The directive that defines one.
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

/// Definitions of all blocks, and uses that are not in the right one.
#[derive(Debug, Default)]
pub(crate) struct Elsewhere {
    /// The first and the last definition of each name.
    places: HashMap<(Kind, String), [Span; 2]>,
    undefined: Vec<Undefined>,
}

#[derive(Debug)]
struct Undefined {
    kind: Kind,
    name: String,
    /// Which diagnostic tells of it.
    diagnostic: usize,
    /// Where it is defined before, in a block that has ended.
    before: Option<Span>,
}

impl Elsewhere {
    pub fn define(&mut self, kind: Kind, name: &Text) {
        let places = self.places.entry((kind, name.value.clone())).or_insert([name.span; 2]);
        places[1] = name.span;
    }

    /// A name that is used where it is not defined.
    pub fn undefined(&mut self, kind: Kind, name: &Text, diagnostic: usize) {
        let key = (kind, name.value.clone());
        let before = self.places.get(&key).map(|[_, last]| *last);
        self.undefined.push(Undefined { kind, name: key.1, diagnostic, before });
    }

    /// Tells where else the names are defined, in place of what else they might be.
    pub fn explain(self, diagnostics: &mut [Diagnostic]) {
        for Undefined { kind, name, diagnostic, before } in &self.undefined {
            let (error, definer) = (&mut diagnostics[*diagnostic], kind.definer());
            let first = self.places.get(&(*kind, name.clone())).map(|[first, _]| first);
            let (place, text, help) = match (before, first) {
                (Some(place), _) => (
                    *place,
                    "it is defined here, in a block that has ended",
                    format!("what a block defines ends with it: {definer} belongs before the block"),
                ),
                // Not by the very directive that uses it.
                (None, Some(place)) if !is_before(*place, error.span()) => (
                    *place,
                    "it is defined here, too late",
                    format!("{definer} belongs before the first use"),
                ),
                (None, None) if error.fix.is_none() => match self.nearest(*kind, name) {
                    Some((near, place)) => (
                        place,
                        "one of this name is defined here, too late or in a block that has ended",
                        format!(
                            "did you mean \"{near}\"? {definer} belongs before its use, outside of blocks that end before it"
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

    /// The name, of any block, that was most likely meant.
    fn nearest(&self, kind: Kind, name: &str) -> Option<(&str, Span)> {
        let of_kind = || self.places.iter().filter(|((of, _), _)| *of == kind);
        let names = in_order(of_kind().map(|((_, name), _)| name.as_str()))?;
        let near = nearest(name, names)?;
        of_kind().find(|((_, name), _)| name == near).map(|(_, [first, _])| (near, *first))
    }
}

/// Names in order, so that what is said of them is always the same. Among very many none is looked for.
pub(crate) fn in_order<'n>(names: impl Iterator<Item = &'n str>) -> Option<Vec<&'n str>> {
    const MOST: usize = 10_000;
    let mut names: Vec<&str> = names.take(MOST + 1).collect();
    names.sort_unstable();
    (names.len() <= MOST).then_some(names)
}

fn is_before(a: Span, b: Span) -> bool {
    a.file == b.file && a.start < b.start
}
