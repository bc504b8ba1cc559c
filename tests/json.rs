//! What `--json` prints has the names that `docs/json.md` has for it.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn project() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

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
        vec!["stability", "--case", "S9", "--json"],
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
