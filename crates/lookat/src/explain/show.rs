//! Directives, types and parameters as text and as JSON.

use std::fmt::Write;

use lookat_scene::schema::{Count, Effect, Kind, Parameter, REQUIRED};
use lookat_scene::syntax::DirectiveForm;
use serde_json::{Value, json};

use super::Answer;

pub(super) fn title(kind: &Kind) -> String {
    format!("{} \"{}\"", kind.directive, kind.name)
}

/// Pairs of texts in two columns.
pub(super) fn columns(lines: &[(String, String)]) -> String {
    let width = lines.iter().map(|(left, _)| left.chars().count()).max().unwrap_or(0);
    lines.iter().map(|(left, right)| format!("{left:width$}  {right}\n")).collect()
}

/// A line for each type, and for each directive without types. A single type is shown with all its parameters.
pub(super) fn directives(forms: &[DirectiveForm], kinds: &[&Kind]) -> Answer {
    let is_plain = |form: &&DirectiveForm| kinds.iter().all(|kind| kind.directive != form.keyword);
    let plain: Vec<&DirectiveForm> = forms.iter().filter(is_plain).collect();
    if let ([], [only]) = (&plain[..], kinds) {
        return Answer { json: json!([kind_as_json(only)]), ..kind(only, String::new()) };
    }
    let forms = plain.iter().map(|form| (written(form), form.meaning.to_owned()));
    let lines: Vec<(String, String)> =
        forms.chain(kinds.iter().map(|kind| (title(kind), meaning(kind)))).collect();
    let json = plain.iter().map(|form| form_as_json(form)).chain(kinds.iter().map(|kind| kind_as_json(kind)));
    Answer { text: columns(&lines), json: json.collect() }
}

/// A directive without types as a scene writes it.
pub(super) fn written(form: &DirectiveForm) -> String {
    format!("{} {}", form.keyword, form.arguments).trim().to_owned()
}

fn meaning(kind: &Kind) -> String {
    let default = if kind.is_default { "; the default" } else { "" };
    match kind.instead {
        "" => format!("{}{default}", kind.meaning),
        instead => format!("{}; not supported: lookat renders {instead}", kind.meaning),
    }
}

/// A type with all its parameters, after a remark.
pub(super) fn kind(kind: &Kind, remark: String) -> Answer {
    let mut text = format!("{remark}{}: {}\n", title(kind), meaning(kind));
    kind.parameters().for_each(|parameter| text += &format!("\n{}", paragraph(&parameter)));
    Answer { text, json: json!([remarked(kind_as_json(kind), &remark)]) }
}

/// A parameter, after a remark.
pub(super) fn parameter(parameter: &Parameter, remark: String) -> Answer {
    Answer { json: remarked(as_json(parameter), &remark), text: remark + &paragraph(parameter) }
}

fn remarked(mut json: Value, remark: &str) -> Value {
    if !remark.is_empty() {
        json["remark"] = remark.trim_end().into();
    }
    json
}

/// A parameter as a scene declares it, its facts, and its meaning.
fn paragraph(parameter: &Parameter) -> String {
    let Parameter { name, ty, default, range, unit, meaning, .. } = parameter;
    let mut text = format!("\"{} {name}\"", ty.name());
    match parameter.count {
        Count::One if parameter.is_textured => text += " or the name of a texture",
        Count::One => {}
        Count::Exactly(count) => _ = write!(text, ", {count} values"),
        Count::List => text += ", a list",
    }
    text += &match default.as_str() {
        REQUIRED => ", required".into(),
        _ => format!(", default {default}"),
    };
    if !range.is_empty() {
        _ = write!(text, ", {range}");
    }
    if !unit.name().is_empty() {
        _ = write!(text, ", in {}", unit.name());
    }
    let effect = match parameter.effect.words() {
        "" => String::new(),
        words => format!("; {words}"),
    };
    let synonyms = match &parameter.synonyms[..] {
        [] => String::new(),
        words => format!("      elsewhere: {}\n", words.join(", ")),
    };
    format!("  {text}\n      {meaning}{effect}\n{synonyms}")
}

fn form_as_json(form: &DirectiveForm) -> Value {
    json!({
        "directive": form.keyword,
        "type": null,
        "arguments": form.arguments,
        "meaning": form.meaning,
        "parameters": [],
    })
}

fn kind_as_json(kind: &Kind) -> Value {
    let parameters: Vec<Value> = kind.parameters().map(|parameter| as_json(&parameter)).collect();
    json!({
        "directive": kind.directive,
        "type": kind.name,
        "default": kind.is_default,
        "meaning": kind.meaning,
        "instead": (!kind.instead.is_empty()).then_some(kind.instead),
        "parameters": parameters,
    })
}

/// The facts about a parameter.
pub fn as_json(parameter: &Parameter) -> Value {
    let count = match parameter.count {
        Count::One => json!(1),
        Count::Exactly(count) => json!(count),
        Count::List => Value::Null,
    };
    let effect = match parameter.effect {
        Effect::Rendered => "rendered",
        Effect::NoEffect => "none",
        Effect::NotRendered => "ignored",
        Effect::Own => "own",
    };
    json!({
        "name": parameter.name,
        "type": parameter.ty.name(),
        "count": count,
        "texture": parameter.is_textured,
        "default": parameter.default,
        "range": (!parameter.range.is_empty()).then_some(&parameter.range),
        "unit": (!parameter.unit.name().is_empty()).then_some(parameter.unit.name()),
        "meaning": parameter.meaning,
        "effect": effect,
        "synonyms": parameter.synonyms,
    })
}
