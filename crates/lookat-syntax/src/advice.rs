//! Help for unknown words: the nearest known name, words of other programs, and marks of other languages.

use std::sync::LazyLock;

use crate::Directive;
use crate::directive::NAME;
use crate::token::{Input, is_unseen};

/// Directives that pbrt-v4 added.
pub(crate) const V4_DIRECTIVES: [&str; 4] = ["Option", "ColorSpace", "Attribute", "Import"];

/// Help for a word that is not a directive.
pub(crate) fn advice(word: Input) -> Option<String> {
    let text = String::from_utf8_lossy(word);
    match text.chars().find(|c| is_unseen(*c)).map(u32::from) {
        Some(code) => Some(format!(
            "pbrt does not treat the character U+{code:04X} as white space: replace it by a space, or delete it"
        )),
        None => directive_advice(&text).or_else(|| foreign(word)).map(str::to_owned),
    }
}

/// Help for marks of other languages and tools.
fn foreign(word: Input) -> Option<&'static str> {
    let starts = |prefix: &str| word.starts_with(prefix.as_bytes());
    Some(match word {
        b"," => "separate parameters by spaces only",
        b"{" | b"}" => "delete it: a block is AttributeBegin ... AttributeEnd",
        _ if starts("//") || starts("--") || starts(";") || starts("%") || starts("/*") => {
            "a comment starts with #"
        }
        _ if starts("<<<<<<<") || starts("=======") || starts(">>>>>>>") => {
            "this is an unresolved merge conflict: keep one side, and delete the markers"
        }
        _ if starts("```") => "this is Markdown: delete the line",
        _ if starts("(") || starts("{") => "write lists in square brackets: [1 2 3]",
        _ if starts("\u{201c}") || starts("'") || starts("\u{2018}") => {
            "write names in straight double quotes"
        }
        [b'a'..=b'z', ..] => {
            "directives begin with a capital letter; write a parameter as \"float radius\" 3"
        }
        _ => return None,
    })
}

/// The meaning of the quoted string after a keyword or after a part of a Texture, and an example.
pub(crate) fn quoted_after(keyword: Input) -> (&'static str, &'static str) {
    let (keyword, part) = match keyword {
        b"the name of a Texture" => (b"Texture".as_slice(), Some("type of values")),
        b"the value type of a Texture" => (b"Texture".as_slice(), Some("type")),
        _ => (keyword, None),
    };
    let (arguments, example) =
        Directive::form(keyword).map_or((NAME, ""), |form| (form.arguments, form.example));
    let what = if arguments.starts_with("\"type\"") { "type" } else { "name" };
    (part.unwrap_or(what), example)
}

/// The message for a value after a directive that takes no parameters.
pub(crate) fn surplus(directive: &Directive) -> Option<String> {
    let form = Directive::form(directive.keyword().as_bytes())?;
    let takes = match (form.keyword, form.arguments) {
        ("NamedMaterial", _) => "a name only; parameters belong to MakeNamedMaterial",
        ("MediumInterface", _) => "one name or two",
        ("ActiveTransform", _) => "All, StartTime or EndTime, and nothing else",
        (_, NAME) => "a name only",
        (_, "") => "no values",
        _ => return None,
    };
    Some(format!("{} takes {takes}", form.keyword))
}

/// What to write instead of a word from elsewhere that stands in place of a directive.
pub fn directive_advice(word: &str) -> Option<&'static str> {
    synonym(word).map(|synonym| synonym.advice)
}

pub(crate) fn synonym(word: &str) -> Option<&'static Synonym> {
    let plain: String = word.to_ascii_lowercase().replace(['_', '-', ' '], "");
    SYNONYMS.iter().find(|synonym| synonym.words.contains(&&plain[..]))
}

/// Words that mean a directive.
pub(crate) struct Synonym {
    words: Vec<&'static str>,
    /// The directive with the same arguments, or an empty text.
    pub directive: &'static str,
    pub advice: &'static str,
}

/// The lines of `synonyms.txt`, which describes itself.
static SYNONYMS: LazyLock<Vec<Synonym>> = LazyLock::new(|| {
    let synonym = |line: &'static str| {
        let (words, rest) = line.split_once(" ->")?;
        let (directive, advice) = rest.split_once(": ")?;
        Some(Synonym { words: words.split(' ').collect(), directive: directive.trim(), advice })
    };
    include_str!("synonyms.txt").lines().filter_map(synonym).collect()
});

/// The name in `known` nearest to `name`, by the optimal string alignment distance without case. `None` if more than a
/// third of its letters are changed, missing, added or swapped with a neighbor.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // A file can contain names of any length.
    let cut = |name: &str| name.to_lowercase().chars().take(64).collect::<String>();
    let (lower, letters) = (cut(name), name.chars().count());
    let slips = |candidate: &str| candidate.chars().count().max(2) / 3;
    known
        .into_iter()
        .filter(|candidate| *candidate != name && !candidate.is_empty())
        .filter(|candidate| candidate.chars().count().abs_diff(letters) <= slips(candidate))
        .map(|candidate| (strsim::osa_distance(&lower, &cut(candidate)), candidate))
        .filter(|(edits, candidate)| *edits <= slips(candidate))
        .min_by_key(|(edits, _)| *edits)
        .map(|(_, candidate)| candidate)
}

/// The only name in `known` that starts with `name`, without case. `None` if several names do, or if `name` has fewer
/// than three letters.
pub fn begun<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    const FEWEST: usize = 3;
    let begins = |candidate: &&str| {
        candidate.len() > name.len()
            && candidate.get(..name.len()).is_some_and(|start| start.eq_ignore_ascii_case(name))
    };
    let mut longer = known.into_iter().filter(begins);
    longer.next().filter(|_| name.chars().count() >= FEWEST && longer.next().is_none())
}

/// True if two names have the same digits in the same order. `wood1` is not a misspelling of `wood2`.
pub fn same_digits(a: &str, b: &str) -> bool {
    let digits = |name: &str| name.bytes().filter(u8::is_ascii_digit).collect::<Vec<u8>>();
    digits(a) == digits(b)
}

#[cfg(test)]
mod tests {
    mod synonyms {
        use super::super::*;
        use crate::Directive;

        #[test]
        fn words_are_written_as_they_are_looked_up() {
            assert!(SYNONYMS.len() > 30);
            for Synonym { words, directive: keyword, advice } in &*SYNONYMS {
                assert!(keyword.is_empty() || Directive::KEYWORDS.contains(keyword), "{keyword}");
                assert!(!advice.is_empty() && advice.contains(keyword), "{words:?}");
                for word in words {
                    assert!(
                        word.bytes().all(|byte| byte.is_ascii_lowercase() || byte.is_ascii_digit()),
                        "{word}"
                    );
                }
            }
            assert!(directive_advice("PointLight").is_some_and(|advice| advice.contains("LightSource")));
        }
    }
    mod nearest {
        use super::super::{begun, nearest};

        #[test]
        fn finds_slips_and_refuses_strangers() {
            let known = ["sphere", "trianglemesh", "plymesh", "disk", "cone"];
            let check = |name, expected| assert_eq!(nearest(name, known), expected, "{name}");
            check("sphrere", Some("sphere"));
            check("Sphere", Some("sphere"));
            check("triangelmesh", Some("trianglemesh"));
            check("plymehs", Some("plymesh"));
            check("dsik", Some("disk"));
            check("teapot", None);
            check("", None);
        }

        #[test]
        fn finds_the_only_name_that_is_begun() {
            let known = ["perspective", "orthographic", "orbit", "environment"];
            let check = |name, expected| assert_eq!(begun(name, known), expected, "{name}");
            check("persp", Some("perspective"));
            check("Ortho", Some("orthographic"));
            check("or", None);
            check("orb", Some("orbit"));
            check("pe", None);
            check("environment", None);
            check("\u{e9}\u{e9}\u{e9}", None);
            assert_eq!(begun("ort", ["orthographic", "ortho"]), None);
        }
    }
}
