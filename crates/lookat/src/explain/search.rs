//! Finds types and parameters by their names, or by words of other programs.

use std::collections::HashSet;

use lookat_scene::schema::{Kind, Parameter, Synonym, parameter_synonyms, type_synonym};
use serde_json::json;

use super::{Answer, show};

/// What a word names: a type, or a parameter of a type. Without a meaning, there is only advice about the directive or the type.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Use {
    directive: &'static str,
    kind: Option<&'static str>,
    parameter: Option<&'static str>,
    meaning: &'static str,
    /// Other necessary changes, or what to write instead.
    advice: &'static str,
}

impl Use {
    /// True for what Material says of MakeNamedMaterial: all but the types.
    pub fn repeats_material(&self) -> bool {
        self.directive == "MakeNamedMaterial" && (self.parameter.is_some() || self.meaning.is_empty())
    }
}

/// The types and parameters with this name.
pub(super) fn named(word: &str, kinds: &[&Kind]) -> Vec<Use> {
    found(kinds, |kind| named_of(word, kind))
}

/// The types and parameters that a word means, also as a word of other programs.
pub(super) fn uses(word: &str, kinds: &[&Kind]) -> Vec<Use> {
    found(kinds, |kind| {
        let mut found = named_of(word, kind);
        found.extend(kind_synonym(word, kind));
        if found.is_empty() {
            found.extend(parameter_synonym(word, kind));
        }
        found
    })
}

/// What is found of each type, each once. Advice about most types of a directive is advice about the directive.
fn found(kinds: &[&Kind], find: impl Fn(&Kind) -> Vec<Use>) -> Vec<Use> {
    let mut found: Vec<Use> = kinds.iter().flat_map(|kind| find(kind)).collect();
    let (types, all) = (kinds.iter().map(|kind| kind.directive), found.clone());
    for it in found.iter_mut().filter(|it| it.meaning.is_empty()) {
        let equal = all.iter().filter(|other| (other.directive, other.advice) == (it.directive, it.advice));
        if 2 * equal.count() > types.clone().filter(|directive| *directive == it.directive).count() {
            it.kind = None;
        }
    }
    let mut seen = HashSet::new();
    found.retain(|it| seen.insert(*it));
    found
}

fn named_of(word: &str, kind: &Kind) -> Vec<Use> {
    let of_kind = kind.name.eq_ignore_ascii_case(word).then(|| of_kind(kind, ""));
    let parameters = kind.parameters().filter_map(|parameter| {
        let Parameter { name, meaning, range, .. } = &parameter;
        let mut values = range.strip_prefix("one of ").into_iter().flat_map(|values| values.split(", "));
        match name.eq_ignore_ascii_case(word) {
            true => Some(of_parameter(kind, name, meaning, "")),
            false => values
                .any(|value| value.eq_ignore_ascii_case(word))
                .then(|| of_parameter(kind, name, meaning, "this is one of its values")),
        }
    });
    of_kind.into_iter().chain(parameters).collect()
}

fn of_kind(kind: &Kind, advice: &'static str) -> Use {
    let Kind { directive, name, meaning, .. } = *kind;
    Use { directive, kind: Some(name), parameter: None, meaning, advice }
}

fn of_parameter(kind: &Kind, name: &'static str, meaning: &'static str, advice: &'static str) -> Use {
    Use { directive: kind.directive, kind: Some(kind.name), parameter: Some(name), meaning, advice }
}

fn advice(kind: &Kind, advice: &'static str) -> Use {
    Use { meaning: "", ..of_kind(kind, advice) }
}

/// A type that a word of other programs means.
fn kind_synonym(word: &str, kind: &Kind) -> Option<Use> {
    let synonym = type_synonym(kind.directive, word)?;
    match synonym.name {
        "" => Some(advice(kind, synonym.advice)),
        name => (name == kind.name).then(|| of_kind(kind, synonym.advice)),
    }
}

/// A parameter that a word of other programs means.
fn parameter_synonym(word: &str, kind: &Kind) -> Option<Use> {
    parameter_synonyms(kind.directive, kind.name, word).find_map(|Synonym { name, advice: words, .. }| {
        if name.is_empty() {
            return Some(advice(kind, words));
        }
        let parameter = kind.parameters().find(|parameter| parameter.name == name)?;
        Some(of_parameter(kind, name, parameter.meaning, words))
    })
}

/// A line for each use, after a remark.
pub(super) fn answer(remark: &str, uses: &[Use]) -> Answer {
    let lines: Vec<(String, String)> = uses.iter().map(line).collect();
    let remark_line = if remark.is_empty() { String::new() } else { format!("{remark}\n") };
    let uses = uses.iter().map(|Use { directive, kind, parameter, meaning, advice }| {
        json!({
            "directive": directive,
            "type": kind,
            "parameter": parameter,
            "meaning": meaning,
            "advice": advice,
        })
    });
    let json = json!({"remark": remark, "found": uses.collect::<Vec<_>>()});
    Answer { text: remark_line + &show::columns(&lines), json }
}

/// What to write, and what it means.
fn line(Use { directive, kind, parameter, meaning, advice }: &Use) -> (String, String) {
    let kind = kind.map(|kind| if kind.is_empty() { "\"\"" } else { kind });
    let words: Vec<&str> = [Some(*directive), kind, *parameter].into_iter().flatten().collect();
    let texts: Vec<&str> = [*meaning, advice].into_iter().filter(|text| !text.is_empty()).collect();
    (words.join(" "), texts.join("; "))
}
