//! The output of `lookat-lab bench`. No test asserts speed.

use std::process::Command;

use serde_json::Value;

fn run(arguments: &[&str]) -> (i32, String, String) {
    let output =
        Command::new(env!("CARGO_BIN_EXE_lookat-lab")).arg("bench").args(arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

#[test]
fn tables_are_whole() {
    let (status, out, err) = run(&["--only", "reading,rendering", "--rounds", "2", "--json"]);
    assert_eq!(status, 0, "{err}");
    // Progress is not in the way of programs.
    assert!(err.contains("reading") && err.contains("rendering"), "{err}");
    let result: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((&result["rounds"], &result["version"]), (&2.into(), &env!("CARGO_PKG_VERSION").into()));
    assert!(result["threads"].as_u64().unwrap() > 0 && !result["processor"].as_str().unwrap().is_empty());
    let tables = result["tables"].as_array().unwrap();
    let names: Vec<&str> = tables.iter().map(|table| table["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["reading", "rendering"]);
    for table in tables {
        let columns = table["columns"].as_array().unwrap().len();
        for row in table["rows"].as_array().unwrap() {
            let cells = row["cells"].as_array().unwrap();
            assert_eq!(cells.len(), columns);
            for cell in cells {
                let [low, median, high] = ["low", "median", "high"].map(|name| cell[name].as_f64().unwrap());
                assert!(0.0 < low && low <= median && median <= high, "{row}");
            }
        }
    }
    // The rows of reading are the same mesh, the last one at 12 bytes a vertex and 13 a triangle.
    let binary = tables[0]["rows"][2]["cells"][0]["median"].as_f64().unwrap();
    assert!(
        (binary - (12.0 * 6.0 * 290.0 * 290.0 + 13.0 * 12.0 * 289.0 * 289.0) / 1e6).abs() < 0.001,
        "{binary}"
    );
}

/// The shares of the stages add up to the whole time, and the rays of all kinds add up to all rays.
#[test]
fn stages_add_up() {
    let (status, out, err) = run(&["--only", "profile", "--rounds", "1", "--json"]);
    assert_eq!(status, 0, "{err}");
    let result: Value = serde_json::from_str(&out).unwrap();
    let tables = result["tables"].as_array().unwrap();
    assert_eq!(tables.len(), 5);
    for table in tables {
        let rows = table["rows"].as_array().unwrap();
        let (stages, rest) = rows.split_at(rows.len() - 2);
        let number = |row: &Value, column: usize| row["cells"][column]["median"].as_f64();
        let sum = |column| stages.iter().filter_map(|row| number(row, column)).sum::<f64>();
        assert!((sum(1) - 100.0).abs() < 1e-6, "{table}");
        let shading = stages.iter().find(|row| row["name"] == "shading").unwrap();
        for row in rest {
            let rays = sum(2) - number(shading, 2).unwrap();
            assert!((number(row, 2).unwrap() - rays).abs() < 1e-9, "{table}");
            assert!((number(row, 6).unwrap() - sum(6)).abs() < 1e-6, "{table}");
        }
        for row in rows.iter().filter(|row| number(row, 2).is_some()) {
            assert!(number(row, 3).unwrap() <= 100.0, "{row}");
        }
    }
}

#[test]
fn people_read_the_same() {
    let (status, out, err) = run(&["--only", "reading", "--rounds", "1"]);
    assert!(err.contains("noisy with fewer than 3 rounds"), "{err}");
    assert!(status == 0 && out.starts_with("lookat ") && out.contains("SIMD: "), "{out}");
    let table = out.split_once("reading: ").unwrap().1;
    assert_eq!(table.trim_end().lines().count(), 1 + 1 + 3, "{out}");
    let (status, out, err) = run(&["--only", "spelling"]);
    assert!(
        status == 2 && out.is_empty() && err.contains("tracing, reading, rendering, features, profile"),
        "{err}"
    );
    assert_eq!(run(&["--rounds", "0"]).0, 2);
}

/// A pipe cannot be read twice, so it is no scene for `--view`.
#[cfg(unix)]
#[test]
fn a_pipe_is_no_scene_to_view() {
    let folder = std::env::temp_dir().join(format!("lookat-lab-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let pipe = folder.join("pipe.pbrt");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let lookat = std::env::current_exe().unwrap();
    let (status, _, err) = run(&["--view", pipe.to_str().unwrap(), "--lookat", lookat.to_str().unwrap()]);
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(status == 1 && err.ends_with("pipe.pbrt: it is a pipe or a device, not a file\n"), "{err}");
}
