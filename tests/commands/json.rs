//! `docs/json.md` has a name for each member that `--json` prints, and lists that come from the doc comments of the structs.
//! `UPDATE_EXPECTED=1` rewrites the lists.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use crate::folder::updates;
use crate::project;

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lookat")).args(arguments).current_dir(folder).output().unwrap()
}

/// The lines that a command prints, run in a folder.
fn printed(folder: &Path, arguments: &[&str]) -> Vec<Value> {
    let run = run(folder, arguments);
    let text = String::from_utf8(run.stdout).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(!lines.is_empty(), "{arguments:?} {}", String::from_utf8_lossy(&run.stderr));
    lines
}

/// What a chart writes, with another renderer in it: `chart.csv` and `chart.json`.
fn charted(folder: &Path) -> (String, Value) {
    let point = ["--point", "other=1,a.exr", "-o", "chart"];
    assert!(run(folder, &[&["chart", "scene.pbrt", "--spp", "4"], &point[..]].concat()).status.success());
    let read = |name| std::fs::read_to_string(folder.join("chart").join(name)).unwrap();
    (read("chart.csv"), serde_json::from_str(&read("chart.json")).unwrap())
}

/// The names of methods, which are keys of some objects.
const METHODS: [&str; 3] = ["random", "stratified", "sobol"];

/// All names of members, but for those of metrics, files and methods, which stand for themselves.
fn members(value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::Array(values) => values.iter().for_each(|value| members(value, found)),
        Value::Object(object) => {
            for (name, value) in object {
                if !METHODS.contains(&name.as_str()) {
                    found.insert(name.clone());
                }
                match name.as_str() {
                    "metrics" => {}
                    "not_finite" => {
                        value.as_object().unwrap().values().for_each(|value| members(value, found))
                    }
                    _ => members(value, found),
                }
            }
        }
        _ => {}
    }
}

#[test]
fn all_members_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "Film \"image\" \"integer xresolution\" 20 \"integer yresolution\" 20 Camera \"perspective\" \"float lensradius\" .1
        Sampler \"halton\" \"integer pixelsamples\" 64 Integrator \"path\" WorldBegin LightSource \"infinite\"
        ObjectBegin \"one\" Shape \"sphere\" \"float radus\" 2 ObjectEnd Translate 0 0 5 ObjectInstance \"one\" WorldEnd";
    std::fs::write(folder.path().join("scene.pbrt"), scene).unwrap();
    let render = ["render", "scene.pbrt", "--json", "--target-error", "0.5", "-o"];
    let mut all = printed(folder.path(), &[&render[..], &["scene.exr"]].concat());
    for (file, seed) in [("a.exr", "1"), ("b.exr", "2")] {
        let noisy = ["render", "scene.pbrt", "--quiet", "--error-layers", "-o", file, "--seed", seed];
        assert!(run(folder.path(), &noisy).status.success());
    }
    let scene = project().join("pbrt-scenes/cornell-matte.pbrt");
    for arguments in [
        vec!["render", "none.pbrt", "--json"],
        vec!["check", "scene.pbrt", scene.to_str().unwrap(), "--json"],
        vec!["inspect", "scene.pbrt", "--json"],
        vec!["compare", "a.exr", "b.exr", "--json"],
        vec!["compare", "a.exr", "scene.exr", "--json"],
        vec!["verify", ".", "--spp", "16", "--json"],
        vec!["stability", "--case", "S9", "--rays", "1000", "--json"],
    ] {
        all.extend(printed(folder.path(), &arguments));
    }
    let (table, chart) = charted(folder.path());
    all.push(chart);
    let text = std::fs::read_to_string(project().join("docs/json.md")).unwrap();
    let mut found = BTreeSet::new();
    all.iter().for_each(|value| members(value, &mut found));
    found.extend(table.lines().next().unwrap().split(',').map(str::to_owned));
    let missing: Vec<&String> = found.iter().filter(|name| !text.contains(&format!("`{name}`"))).collect();
    assert!(missing.is_empty(), "{missing:?}");
    assert!(found.len() > 110, "{}", found.len());
}

/// The sources in which the page's structs are: of the program, and of the libraries that it takes results from.
const SOURCES: [&str; 13] = [
    "lookat-image/src/compare/comparison.rs",
    "lookat/src/explain.rs",
    "lookat/src/inspect/needs.rs",
    "lookat/src/inspect/shown.rs",
    "lookat/src/light.rs",
    "lookat/src/render/fireflies.rs",
    "lookat/src/render/summary.rs",
    "lookat-scene/src/json.rs",
    "lookat-sight/src/metadata.rs",
    "lookat/src/scene_result.rs",
    "lookat/src/verify/outcome.rs",
    "lookat-render/src/inspect.rs",
    "lookat-render/src/render.rs",
];

#[test]
fn the_page_has_the_members_of_the_structs() {
    let read = |name: &&str| std::fs::read_to_string(project().join("crates").join(name)).unwrap();
    let source: String = SOURCES.iter().map(read).collect();
    let file = project().join("docs/json.md");
    let page = std::fs::read_to_string(&file).unwrap();
    let (mut made, mut rest) = (String::new(), page.as_str());
    while let Some((before, after)) = rest.split_once("<!-- ") {
        let (name, _) = after.split_once(" -->").unwrap();
        let (_, after) = after.split_once("<!-- end -->").unwrap();
        let rows = rows(&source, name);
        made += &format!("{before}<!-- {name} -->\n{rows}<!-- end -->");
        rest = after;
    }
    made += rest;
    if made != page {
        if updates() {
            std::fs::write(&file, &made).unwrap();
        }
        let differing = made.lines().zip(page.lines()).find(|(made, page)| made != page);
        panic!("run with UPDATE_EXPECTED=1, then read git diff; the first lines that differ: {differing:?}");
    }
}

/// A line for each member of a struct, also for members of flattened structs: its name and its doc comment.
fn rows(source: &str, name: &str) -> String {
    let is_start = |line: &&str| {
        let declared = line.trim_start_matches("pub ").strip_prefix("struct ");
        declared.is_some_and(|rest| rest.split([' ', '<']).next() == Some(name))
    };
    let lines = source.lines().skip_while(|line| !is_start(line)).skip(1).take_while(|line| *line != "}");
    let (mut rows, mut meaning, mut attributes) = (String::new(), Vec::new(), String::new());
    for line in lines.map(str::trim) {
        if let Some(text) = line.strip_prefix("/// ") {
            meaning.push(text);
        } else if line.starts_with('#') {
            attributes += line;
        } else if let Some((member, ty)) = line.trim_start_matches("pub ").split_once(": ") {
            let renamed = attributes.split_once("rename = \"").and_then(|(_, rest)| rest.split('"').next());
            let optional = if attributes.contains("skip_serializing_if") { "?" } else { "" };
            if attributes.contains("flatten") {
                let inner = ty.trim_start_matches("Option<").split(['<', '>', ',']).next().unwrap();
                rows += &self::rows(source, inner);
            } else if !attributes.contains("(skip)") {
                assert!(!meaning.is_empty(), "{name}::{member} has no doc comment");
                rows += &format!("- `{}`{optional}: {}\n", renamed.unwrap_or(member), meaning.join(" "));
            }
            meaning.clear();
            attributes.clear();
        }
    }
    assert!(!rows.is_empty(), "no struct {name}");
    rows
}
