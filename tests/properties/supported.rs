//! The tables of types and parameters in `docs/supported.md` come from the schema. `UPDATE_EXPECTED=1` rewrites them.

use std::path::Path;

use lookat_scene::kinds;
use lookat_scene::schema::{Count, Kind, Parameter, Unit};

/// The table of a directive begins after `<!-- Camera -->`, and ends here.
const END: &str = "<!-- end -->";

#[test]
fn the_page_has_the_tables_of_the_schema() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/supported.md");
    let page = std::fs::read_to_string(&file).unwrap();
    let mut made = page.clone();
    // The types and parameters of MakeNamedMaterial are those of Material.
    let kinds = kinds().filter(|kind| kind.directive != "MakeNamedMaterial");
    let mut directives: Vec<&str> = kinds.map(|kind| kind.directive).collect();
    directives.dedup();
    assert!(directives.len() >= 10, "{directives:?}");
    for directive in directives {
        let start = format!("<!-- {directive} -->\n");
        let (before, rest) = made.split_once(&start).unwrap_or_else(|| panic!("no table for {directive}"));
        let (_, after) = rest.split_once(END).unwrap();
        made = format!("{before}{start}{}{END}{after}", tables(directive));
    }
    if made != page {
        if std::env::var_os("UPDATE_EXPECTED").is_some() {
            std::fs::write(&file, &made).unwrap();
        }
        let differing = made.lines().zip(page.lines()).find(|(made, page)| made != page);
        panic!("run with UPDATE_EXPECTED=1, then read git diff; the first lines that differ: {differing:?}");
    }
}

/// The types of a directive, and its parameters.
fn tables(directive: &str) -> String {
    let kinds: Vec<&Kind> = kinds().filter(|kind| kind.directive == directive).collect();
    let mut text = String::from("\n| type | |\n|---|---|\n");
    for kind in &kinds {
        let instead = match kind.instead {
            "" => String::new(),
            instead => format!(". Not supported: lookat renders {instead}"),
        };
        text += &format!("| {} | {}{instead} |\n", name(kind), kind.meaning);
    }
    // Each parameter once, with the types that have it.
    let mut rows: Vec<(Parameter, Vec<&Kind>)> = Vec::new();
    for kind in &kinds {
        for parameter in kind.parameters() {
            // `lookat explain` shows them.
            let parameter = Parameter { synonyms: Vec::new(), ..parameter };
            match rows.iter_mut().find(|(known, _)| *known == parameter) {
                Some((_, types)) => types.push(kind),
                None => rows.push((parameter, vec![kind])),
            }
        }
    }
    if rows.is_empty() {
        return text + "\n";
    }
    text += "\n| parameter | of | type | default | range | meaning |\n|---|---|---|---|---|---|\n";
    for (parameter, types) in rows {
        let Parameter { name, default, meaning, .. } = &parameter;
        let (ty, range) = (ty(&parameter), range(&parameter));
        let (of, effect) = (of(&types, &kinds), effect(&parameter));
        text += &format!("| `{name}` | {of} | {ty} | {default} | {range} | {meaning}{effect} |\n");
    }
    text + "\n"
}

fn name(kind: &Kind) -> String {
    // The empty name is written as it stands in a scene.
    if kind.name.is_empty() { "`\"\"`".into() } else { format!("`{}`", kind.name) }
}

/// The types that have a parameter.
fn of(types: &[&Kind], all: &[&Kind]) -> String {
    let listed = |kinds: &[&Kind]| kinds.iter().map(|kind| name(kind)).collect::<Vec<_>>().join(", ");
    let others: Vec<&Kind> =
        all.iter().copied().filter(|kind| types.iter().all(|other| other.name != kind.name)).collect();
    match others.len() {
        0 => "all".into(),
        count if count < types.len() / 2 => format!("all except {}", listed(&others)),
        _ => listed(types),
    }
}

fn ty(parameter: &Parameter) -> String {
    let name = parameter.ty.name();
    match parameter.count {
        Count::One if parameter.is_textured => format!("{name} or texture"),
        Count::One => name.into(),
        Count::Exactly(count) => format!("{name}[{count}]"),
        Count::List => format!("{name}[]"),
    }
}

fn range(parameter: &Parameter) -> String {
    let Parameter { range, unit, .. } = parameter;
    match unit {
        Unit::None => range.clone(),
        Unit::Degrees | Unit::Pixels => format!("{range} {}", unit.name()).trim().into(),
        _ if range.is_empty() => unit.name().into(),
        _ => format!("{range}, in {}", unit.name()),
    }
}

fn effect(parameter: &Parameter) -> String {
    match parameter.effect.words() {
        "" => String::new(),
        words => format!(" ({words})"),
    }
}
