//! Words of other programs (Mitsuba, Blender, POV-Ray, Arnold) and other versions of pbrt for types and parameters of
//! pbrt-v3.

use std::collections::{HashMap, HashSet};
use std::sync::LazyLock;

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

/// Words that become one name.
struct Row {
    directive: &'static str,
    /// The types whose parameters the words are for; none: all. `["type"]`: the words are types themselves.
    kinds: Vec<&'static str>,
    words: Vec<&'static str>,
    name: &'static str,
    advice: &'static str,
}

/// The rows of `synonyms.txt`, which describes itself.
static ROWS: LazyLock<Vec<Row>> = LazyLock::new(|| {
    let (mut rows, mut texts, mut directive) = (Vec::new(), HashMap::new(), "");
    for line in include_str!("synonyms.txt").lines().filter(|line| !line.starts_with('#')) {
        if let Some(section) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
            directive = section;
        } else if let Some((name, text)) = line.strip_prefix('$').and_then(|line| line.split_once(" = ")) {
            texts.insert(name, text);
        } else if let Some((kinds, rest)) = line.split_once(": ")
            && let Some((words, rest)) = rest.split_once(" ->")
        {
            let (name, advice) = rest.split_once(": ").unwrap_or((rest, ""));
            let text = advice.strip_prefix('$').and_then(|name| texts.get(name).copied());
            let kinds = if kinds == "*" { Vec::new() } else { kinds.split(' ').collect() };
            let (words, name) = (words.split(' ').collect(), name.trim());
            rows.push(Row { directive, kinds, words, name, advice: text.unwrap_or(advice) });
        }
    }
    rows
});

/// The synonym of a type of `directive`.
pub fn type_synonym(directive: &str, word: &str) -> Option<Synonym> {
    let plain = plain(word);
    rows(directive).filter(|row| row.kinds == ["type"]).find_map(|row| row.synonym(&plain))
}

/// The synonyms of a parameter of a `directive` of type `kind`, in order of preference.
pub fn parameter_synonyms<'a>(
    directive: &'a str,
    kind: &'a str,
    word: &str,
) -> impl Iterator<Item = Synonym> + use<'a> {
    let plain = plain(word);
    rows(directive).filter(move |row| row.is_of(kind)).filter_map(move |row| row.synonym(&plain))
}

/// The words that mean the parameter `name`, each once.
pub(super) fn words_for(directive: &str, kind: &str, name: &str) -> Vec<&'static str> {
    let of_name = rows(directive).filter(|row| row.is_of(kind) && row.name == name);
    let mut seen = HashSet::new();
    of_name.flat_map(|row| &row.words).copied().filter(|word| seen.insert(*word)).collect()
}

fn rows(directive: &str) -> impl Iterator<Item = &'static Row> + use<'_> {
    let directive = if directive == "MakeNamedMaterial" { "Material" } else { directive };
    ROWS.iter().filter(move |row| row.directive == directive)
}

impl Row {
    /// True for words of parameters of a type.
    fn is_of(&self, kind: &str) -> bool {
        self.kinds.is_empty() || self.kinds.contains(&kind)
    }

    fn synonym(&self, plain: &str) -> Option<Synonym> {
        let word = self.words.iter().find(|word| **word == plain)?;
        Some(Synonym { word, name: self.name, advice: self.advice })
    }
}

/// The advice for a type that another one replaces.
pub(crate) const OLDER: &str = "a type of an older pbrt";

/// A word as the tables write it.
fn plain(word: &str) -> String {
    word.to_ascii_lowercase()
        .replace(['_', '-', ' '], "")
        .replace("colour", "color")
        .replace("centre", "center")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds;

    #[test]
    fn every_line_is_read() {
        let text = include_str!("synonyms.txt");
        let lines = text.lines().filter(|line| !line.starts_with(['#', '[', '$']) && !line.is_empty());
        assert_eq!(ROWS.len(), lines.count());
        assert!(
            ROWS.iter().any(|row| row.advice == OLDER) && !ROWS.iter().any(|row| row.advice.contains('$'))
        );
    }

    #[test]
    fn words_are_written_as_they_are_looked_up() {
        for Row { words, name, advice, .. } in &*ROWS {
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
        for row @ Row { directive, kinds: of_kinds, words, name, .. } in &*ROWS {
            let of = || kinds().filter(|kind| kind.directive == *directive);
            let is_type = |name: &str| of().any(|kind| kind.name == name);
            if *of_kinds == ["type"] {
                assert!(name.is_empty() || is_type(name), "{directive}: {words:?} become {name}");
                continue;
            }
            assert!(of_kinds.iter().all(|kind| is_type(kind)), "{directive} {of_kinds:?}");
            let has = |kind: &crate::schema::Kind| kind.parameters().any(|it| it.name == *name);
            let mut named = of().filter(|kind| row.is_of(kind.name));
            assert!(name.is_empty() || named.any(has), "{directive}: {words:?} become {name}");
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
