//! Words of other programs (Mitsuba, Blender, POV-Ray, Arnold) and other versions of pbrt for types and parameters of
//! pbrt-v3, as plain data.

mod light;
mod material;
mod options;
mod shape;
mod texture;

use std::collections::HashSet;

/// A word from elsewhere, and what to write instead.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Synonym {
    /// The word as written in its table: lower case, without `_`, `-` and spaces, in American spelling.
    pub word: &'static str,
    /// The pbrt-v3 name that replaces it; empty if no name does.
    pub name: &'static str,
    /// Other necessary changes, or the reason why no name replaces the word; empty for a plain rename.
    pub advice: &'static str,
}

/// The words for the types of a directive, and for its parameters.
struct Table {
    directive: &'static str,
    types: &'static [TypeRow],
    parameters: &'static [Row],
}

/// A row for words that all become the type `name`: the words, the name, the advice.
type TypeRow = (&'static [&'static str], &'static str, &'static str);

/// A row for words that all become the parameter `name`: the types (empty: all), the words, the name, the advice.
type Row = (&'static [&'static str], &'static [&'static str], &'static str, &'static str);

const TABLES: &[Table] = &[
    options::CAMERA,
    options::FILM,
    options::PIXEL_FILTER,
    options::SAMPLER,
    options::INTEGRATOR,
    options::ACCELERATOR,
    shape::TABLE,
    material::TABLE,
    light::LIGHT_SOURCE,
    light::AREA_LIGHT_SOURCE,
    texture::TABLE,
];

/// The synonym of a type of `directive`.
pub fn type_synonym(directive: &str, word: &str) -> Option<Synonym> {
    let plain = plain(word);
    let rows = table(directive)?.types.iter();
    rows.filter_map(|(words, name, advice)| found(&plain, words, name, advice)).next()
}

/// The synonyms of a parameter of a `directive` of type `kind`, in order of preference.
pub fn parameter_synonyms<'a>(
    directive: &str,
    kind: &'a str,
    word: &str,
) -> impl Iterator<Item = Synonym> + use<'a> {
    let plain = plain(word);
    rows(directive, kind).filter_map(move |(_, words, name, advice)| found(&plain, words, name, advice))
}

/// The words that mean the parameter `name`, each once.
pub(super) fn words_for(directive: &str, kind: &str, name: &str) -> Vec<&'static str> {
    let of_name = rows(directive, kind).filter(|(_, _, known, _)| *known == name);
    let mut words: Vec<&str> = of_name.flat_map(|(_, words, ..)| words.iter().copied()).collect();
    let mut seen = HashSet::new();
    words.retain(|word| seen.insert(*word));
    words
}

fn rows<'a>(directive: &str, kind: &'a str) -> impl Iterator<Item = &'static Row> + use<'a> {
    let rows = table(directive).map_or(&[][..], |table| table.parameters);
    rows.iter().filter(move |(kinds, ..)| kinds.is_empty() || kinds.contains(&kind))
}

fn table(directive: &str) -> Option<&'static Table> {
    let directive = if directive == "MakeNamedMaterial" { "Material" } else { directive };
    TABLES.iter().find(|table| table.directive == directive)
}

/// A word as the tables write it.
fn plain(word: &str) -> String {
    word.to_ascii_lowercase()
        .replace(['_', '-', ' '], "")
        .replace("colour", "color")
        .replace("centre", "center")
}

fn found(plain: &str, words: &[&'static str], name: &'static str, advice: &'static str) -> Option<Synonym> {
    let word = words.iter().find(|word| **word == plain)?;
    Some(Synonym { word, name, advice })
}

const SAMPLES: &str = "the Sampler sets the samples per pixel, with \"integer pixelsamples\"";
const PLACE: &str = "to place it, write Translate, Rotate, Scale or Transform before the directive";
/// The advice for a type that another one replaces.
pub(crate) const OLDER: &str = "a type of an older pbrt";
const EMIT: &str =
    "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1], written before the Shape, makes the Shape emit light";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds;

    #[test]
    fn words_are_written_as_they_are_looked_up() {
        let types = TABLES.iter().flat_map(|table| table.types.iter().copied());
        let parameters = TABLES.iter().flat_map(|table| table.parameters);
        let parameters = parameters.map(|(_, words, name, advice)| (*words, *name, *advice));
        for (words, name, advice) in types.chain(parameters) {
            assert!(!name.is_empty() || !advice.is_empty(), "{words:?} lead nowhere");
            for word in words {
                assert!(
                    word.bytes().all(|byte| byte.is_ascii_lowercase() || byte.is_ascii_digit()),
                    "{word}"
                );
            }
        }
    }

    /// Every name is in the schema, and so is every type.
    #[test]
    fn names_exist() {
        for Table { directive, types, parameters } in TABLES {
            let of = || kinds().filter(|kind| kind.directive == *directive);
            let is_type = |name: &str| of().any(|kind| kind.name == name);
            for (words, name, _) in *types {
                assert!(name.is_empty() || is_type(name), "{directive}: {words:?} become {name}");
            }
            for (kinds, words, name, _) in *parameters {
                assert!(kinds.iter().all(|kind| is_type(kind)), "{directive} {kinds:?}");
                let has = |kind: &crate::schema::Kind| kind.parameters().any(|it| it.name == *name);
                let mut named = of().filter(|kind| kinds.is_empty() || kinds.contains(&kind.name));
                assert!(name.is_empty() || named.any(has), "{directive}: {words:?} become {name}");
            }
        }
    }

    #[test]
    fn the_type_decides() {
        let name = |kind, word| parameter_synonyms("Material", kind, word).next().map(|it| it.name);
        assert_eq!(name("matte", "albedo"), Some("Kd"));
        assert_eq!(name("mirror", "base_color"), Some("Kr"));
        assert_eq!(name("matte", "Roughness"), Some(""));
        assert_eq!(name("matte", "teapot"), None);
        assert_eq!(type_synonym("Material", "rough_plastic").map(|it| it.name), Some("plastic"));
        assert!(words_for("Camera", "perspective", "lensradius").contains(&"aperture"));
    }
}
