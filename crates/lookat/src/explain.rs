//! `lookat explain`: the directives, types and parameters of the format.

use std::fmt::Write;
use std::process::ExitCode;

use lookat_scene::kinds;
use lookat_scene::schema::{Count, Effect, Kind, Parameter, REQUIRED, Synonym, parameter_synonyms};
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
        let (parameter, remark) = find(kind, name)?;
        return match arguments.json {
            true => crate::print_json(&as_json(&parameter)),
            false => crate::print(&format!("{remark}{}", paragraph(&parameter))),
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

/// A parameter by its name, or by a word of other programs and then with a line about that word.
fn find(kind: &Kind, name: &str) -> Result<(Parameter, String), String> {
    let mut parameters: Vec<Parameter> = kind.parameters().collect();
    let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name).collect();
    let lacks = format!("{} has no parameter", title(kind));
    let is_known = |synonym: &Synonym| synonym.name.is_empty() || names.contains(&synonym.name);
    let synonym = parameter_synonyms(kind.directive, kind.name, name).find(is_known);
    let (wanted, remark) = match synonym.filter(|_| !names.contains(&name)) {
        None => (name, String::new()),
        Some(Synonym { name: "", advice, .. }) => return Err(format!("{lacks} \"{name}\": {advice}")),
        Some(Synonym { name: own, advice: "", .. }) => (own, format!("\"{name}\" is \"{own}\" in pbrt\n")),
        Some(Synonym { name: own, advice, .. }) => {
            (own, format!("\"{name}\" is \"{own}\" in pbrt: {advice}\n"))
        }
    };
    parameters.retain(|parameter| parameter.name == wanted);
    check(&parameters, &lacks, name, names)?;
    Ok((parameters.swap_remove(0), remark))
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
    let synonyms = match &parameter.synonyms[..] {
        [] => String::new(),
        words => format!("      elsewhere: {}\n", words.join(", ")),
    };
    format!("  {text}\n      {meaning}{effect}\n{synonyms}")
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
        "synonyms": parameter.synonyms,
    })
}
