//! `lookat explain`: the directives, types and parameters of the format.

use std::fmt::Write;
use std::process::ExitCode;

use lookat_scene::schema::{Count, Effect, Kind, Parameter, REQUIRED, kinds};
use lookat_scene::syntax::nearest;
use serde_json::{Value, json};

use crate::args::Explain;

/// Runs the command.
pub fn explain(arguments: &Explain) -> ExitCode {
    crate::exit_code(run(arguments).map(|()| 0))
}

fn run(arguments: &Explain) -> Result<(), String> {
    let mut found: Vec<&Kind> = kinds().collect();
    if let Some(directive) = &arguments.directive {
        found.retain(|kind| kind.directive == directive);
        check(&found, "there is no directive", directive, kinds().map(|kind| kind.directive))?;
    }
    if let (Some(directive), Some(name)) = (&arguments.directive, &arguments.kind) {
        let names: Vec<&str> = found.iter().map(|kind| kind.name).collect();
        found.retain(|kind| kind.name == name);
        check(&found, &format!("{directive} has no type"), name, names)?;
    }
    if let ([kind], Some(name)) = (&found[..], &arguments.parameter) {
        let mut parameters: Vec<Parameter> = kind.parameters().collect();
        let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name).collect();
        parameters.retain(|parameter| parameter.name == name);
        check(&parameters, &format!("{} has no parameter", title(kind)), name, names)?;
        return match arguments.json {
            true => crate::print_json(&as_json(&parameters[0])),
            false => crate::print(&paragraph(&parameters[0])),
        };
    }
    if arguments.json {
        return crate::print_json(&found.iter().map(|kind| kind_as_json(kind)).collect::<Vec<_>>());
    }
    crate::print(&match &found[..] {
        [kind] => whole(kind),
        _ => overview(&found),
    })
}

/// Fails if nothing is found, and suggests a known name. `lacks` is the beginning of the message.
fn check<'n, T>(
    found: &[T],
    lacks: &str,
    name: &str,
    known: impl IntoIterator<Item = &'n str>,
) -> Result<(), String> {
    if !found.is_empty() {
        return Ok(());
    }
    let mut known: Vec<&str> = known.into_iter().collect();
    known.dedup();
    let advice = match nearest(name, known.iter().copied()) {
        Some(near) => format!("did you mean {near}?"),
        None => format!("choose from {}", known.join(", ")),
    };
    Err(format!("{lacks} \"{name}\": {advice}"))
}

fn title(kind: &Kind) -> String {
    format!("{} \"{}\"", kind.directive, kind.name)
}

/// A line for each type.
fn overview(kinds: &[&Kind]) -> String {
    let width = kinds.iter().map(|kind| title(kind).len()).max().unwrap_or(0);
    let line = |kind: &&Kind| format!("{:width$}  {}\n", title(kind), meaning(kind));
    kinds.iter().map(line).collect()
}

fn meaning(kind: &Kind) -> String {
    match kind.instead {
        "" => kind.meaning.into(),
        instead => format!("{}; not supported: lookat renders {instead}", kind.meaning),
    }
}

/// A type with all its parameters.
fn whole(kind: &Kind) -> String {
    let mut text = format!("{}: {}\n", title(kind), meaning(kind));
    kind.parameters().for_each(|parameter| text += &format!("\n{}", paragraph(&parameter)));
    text
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
    format!("  {text}\n      {meaning}{effect}\n")
}

fn kind_as_json(kind: &Kind) -> Value {
    let parameters: Vec<Value> = kind.parameters().map(|parameter| as_json(&parameter)).collect();
    json!({
        "directive": kind.directive,
        "type": kind.name,
        "meaning": kind.meaning,
        "instead": (!kind.instead.is_empty()).then_some(kind.instead),
        "parameters": parameters,
    })
}

fn as_json(parameter: &Parameter) -> Value {
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
    })
}
