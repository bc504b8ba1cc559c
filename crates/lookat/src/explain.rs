//! `lookat explain`: the directives, types and parameters of the format.

mod search;
pub mod show;

use std::process::ExitCode;

use lookat_scene::kinds;
use lookat_scene::schema::{Kind, Parameter, Synonym, parameter_synonyms, type_synonym};
use lookat_scene::syntax::{Directive, ParamType, directive_advice, nearest};
use serde_json::{Value, json};

use crate::args::Explain;
use search::uses;

/// What the command prints, as text and as JSON.
struct Answer {
    text: String,
    json: Value,
}

/// Runs the command.
pub fn explain(arguments: &Explain) -> ExitCode {
    let printed = match answer(arguments) {
        Ok(Answer { json, .. }) if arguments.json => crate::print_json(&json).map(|()| 0),
        Ok(Answer { text, .. }) => crate::print(&text).map(|()| 0),
        Err(message) => {
            crate::say(&format!("error: {message}"));
            let printed = if arguments.json { crate::print_json(&json!({"error": message})) } else { Ok(()) };
            printed.map(|()| crate::TROUBLE)
        }
    };
    crate::exit_code(printed)
}

fn answer(words: &Explain) -> Result<Answer, String> {
    let Some(word) = &words.directive else {
        return Ok(show::directives(&Directive::FORMS, &kinds().collect::<Vec<_>>()));
    };
    let Some(form) = Directive::FORMS.iter().find(|form| form.keyword == word) else {
        return any(&[word, words.kind.as_deref().unwrap_or(""), words.parameter.as_deref().unwrap_or("")]);
    };
    let kinds: Vec<&Kind> = kinds().filter(|kind| kind.directive == word).collect();
    let Some(name) = &words.kind else { return Ok(show::directives(&[*form], &kinds)) };
    if kinds.is_empty() {
        return Err(format!("{word} has no types: write {word} {}", form.arguments).trim().to_owned());
    }
    let (kind, remark) = match find_kind(&kinds, name) {
        Ok(found) => found,
        Err(message) => {
            let found = uses(name, &kinds);
            return if found.is_empty() { Err(message) } else { Ok(search::answer("", &found)) };
        }
    };
    match &words.parameter {
        Some(parameter) => find_parameter(kind, parameter, remark),
        None => Ok(show::kind(kind, remark)),
    }
}

/// Words without the directive as pbrt writes it: a type, a parameter, a type and its parameter, or words of other programs.
fn any(words: &[&str; 3]) -> Result<Answer, String> {
    let [word, second, _] = *words;
    let phrase = words.join(" ");
    let phrase = phrase.trim_end();
    let kinds: Vec<&Kind> = kinds().collect();
    let mut found = uses(phrase, &kinds);
    if found.is_empty() && !second.is_empty() {
        let named: Vec<&Kind> =
            kinds.iter().copied().filter(|kind| kind.name.eq_ignore_ascii_case(word)).collect();
        found = uses(second, &named);
    }
    // MakeNamedMaterial has the same parameters and the same advice as Material.
    found.retain(|it| !it.repeats_material());
    let advice = directive_advice(phrase).filter(|_| search::named(phrase, &kinds).is_empty());
    let ty = ParamType::SPELLINGS.iter().find(|(name, _)| name.eq_ignore_ascii_case(phrase));
    let ty = ty.map(|(name, ty)| format!("\"{name} NAME\" declares a parameter: {}", ty.meaning()));
    let mut remark = advice.map(str::to_owned).or(ty).unwrap_or_default();
    if let Some(form) = Directive::FORMS.iter().find(|form| form.keyword.eq_ignore_ascii_case(word)) {
        if found.is_empty() || !second.is_empty() {
            let [_, kind, parameter] =
                words.map(|word| Some(word.to_owned()).filter(|word| !word.is_empty()));
            return answer(&Explain { directive: Some(form.keyword.into()), kind, parameter, json: false });
        }
        remark = format!("{}: {}", show::written(form), form.meaning);
    }
    if !remark.is_empty() || !found.is_empty() {
        return Ok(search::answer(&remark, &found));
    }
    let others = kinds.iter().flat_map(|kind| kind.parameters().map(|it| it.name).chain([kind.name]));
    let near = nearest(phrase, Directive::KEYWORDS.into_iter().chain(others));
    Err(unknown("there is no directive", phrase, near, &Directive::KEYWORDS))
}

/// A type by its name, or by a word of other programs and then with a line about that word.
fn find_kind<'k>(kinds: &[&'k Kind], name: &str) -> Result<(&'k Kind, String), String> {
    let lacks = format!("{} has no type", kinds[0].directive);
    let named = |name: &str| kinds.iter().copied().find(|kind| kind.name.eq_ignore_ascii_case(name));
    if let Some(kind) = named(name) {
        return Ok((kind, String::new()));
    }
    let synonym = type_synonym(kinds[0].directive, name).filter(|synonym| !synonym.name.is_empty());
    let renamed = synonym.and_then(|synonym| Some((named(synonym.name)?, rename(name, synonym))));
    renamed.ok_or_else(|| {
        let names: Vec<&str> = kinds.iter().map(|kind| kind.name).collect();
        unknown(&lacks, name, nearest(name, names.iter().copied()), &names)
    })
}

/// A parameter by its name, or by a word of other programs and then with a line about that word.
fn find_parameter(kind: &Kind, name: &str, mut remark: String) -> Result<Answer, String> {
    let parameters: Vec<Parameter> = kind.parameters().collect();
    let named = |name: &str| parameters.iter().find(|it| it.name.eq_ignore_ascii_case(name));
    let lacks = format!("{} has no parameter", show::title(kind));
    if let Some(parameter) = named(name) {
        return Ok(show::parameter(parameter, remark));
    }
    let of_material: Vec<&Kind> = kinds().filter(|kind| kind.directive == "Material").collect();
    let overridden = search::named(name, &of_material);
    if kind.directive == "Shape" && !overridden.is_empty() {
        let remark = format!("a shape can override \"{name}\" of its material:");
        return Ok(search::answer(&remark, &overridden));
    }
    let is_known = |synonym: &Synonym| synonym.name.is_empty() || named(synonym.name).is_some();
    let synonym = parameter_synonyms(kind.directive, kind.name, name).find(is_known);
    if let Some(Synonym { name: "", advice, .. }) = synonym {
        return Err(format!("{lacks} \"{name}\": {advice}"));
    }
    if let Some((synonym, parameter)) = synonym.and_then(|synonym| Some((synonym, named(synonym.name)?))) {
        remark += &rename(name, synonym);
        return Ok(show::parameter(parameter, remark));
    }
    if parameters.is_empty() {
        return Err(format!("{lacks} \"{name}\": it takes no parameters"));
    }
    let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name).collect();
    Err(unknown(&lacks, name, nearest(name, names.iter().copied()), &names))
}

/// A line about a word of other programs.
fn rename(word: &str, Synonym { name, advice, .. }: Synonym) -> String {
    let colon = if advice.is_empty() { "" } else { ": " };
    format!("\"{word}\" is \"{name}\" in pbrt{colon}{advice}\n")
}

/// The message about an unknown name. `lacks` is its beginning.
fn unknown(lacks: &str, name: &str, near: Option<&str>, known: &[&str]) -> String {
    let known: Vec<&str> = known.iter().map(|known| if known.is_empty() { "\"\"" } else { known }).collect();
    let advice = match near {
        Some(near) => format!("did you mean {near}?"),
        None => format!("choose from {}", known.join(", ")),
    };
    format!("{lacks} \"{name}\": {advice}")
}
