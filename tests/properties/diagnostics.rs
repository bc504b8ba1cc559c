//! What lookat says about scene files: each file below `tests/diagnostics` ends with what is said about it, as in
//!
//! ```text
//! # error 4:7-4:16: unknown Shape "sphrere"
//! #   note: what stands beside the underlined text
//! #   related 2:1-2:11: another place and what is said there
//! #   also 5:7-5:16, 6:7-6:16
//! #   help: did you mean "sphere"?
//! #   fix 4:7-4:16: "sphere"
//! ```
//!
//! Lines and columns count from 1, columns in characters; the second place is the one after the last character. Places in
//! other files begin with their names. A file that ends without such comments is fine. Folders called `parts` hold what
//! the cases include.
//!
//! `UPDATE_EXPECTED=1 cargo test -p lookat --test properties diagnostics` rewrites the comments, for `git diff` to judge.

use std::io;
use std::path::{Path, PathBuf};

use lookat_scene::syntax::{Diagnostic, Severity, Span};
use lookat_scene::{LoadOptions, Loaded, Sources, load};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/diagnostics")
}

/// All cases below a folder, in the order of their names.
fn cases(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = folder.read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() && path.file_name().is_some_and(|name| name != "parts") {
            cases(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "pbrt") {
            found.push(path);
        }
    }
}

/// Splits a file into the scene and the expectations at its end.
fn split(bytes: &[u8]) -> (&[u8], &[u8]) {
    let mut at = bytes.len();
    for line in bytes.split_inclusive(|byte| *byte == b'\n').rev() {
        if !["# error ", "# warning ", "# note ", "#   "]
            .iter()
            .any(|start| line.starts_with(start.as_bytes()))
        {
            break;
        }
        at -= line.len();
    }
    bytes.split_at(at)
}

/// The same memory on every machine.
fn limited() -> LoadOptions {
    LoadOptions { max_memory: Some(1_000_000_000), ..LoadOptions::default() }
}

/// A range of a file, as people read it.
fn place(sources: &Sources, span: Span) -> String {
    let start = sources.location(span);
    let end = sources.location(Span { start: span.end, ..span });
    let file =
        if span.file.0 == 0 { String::new() } else { format!("{}:", sources.file(span.file).path.display()) };
    format!("{file}{}:{}-{}:{}", start.line, start.column, end.line, end.column)
}

/// A diagnostic in the form of the expectations.
fn written(sources: &Sources, diagnostic: &Diagnostic) -> String {
    let severity = match diagnostic.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Note => "note",
    };
    let mut lines =
        vec![format!("# {severity} {}: {}", place(sources, diagnostic.span()), diagnostic.message)];
    let (first, others) = diagnostic.labels.split_first().unwrap();
    if !first.text.is_empty() {
        lines.push(format!("#   note: {}", first.text));
    }
    for label in others {
        lines.push(format!("#   related {}: {}", place(sources, label.span), label.text));
    }
    if !diagnostic.places.is_empty() {
        let places: Vec<String> = diagnostic.places.iter().map(|span| place(sources, *span)).collect();
        lines.push(format!("#   also {}", places.join(", ")));
    }
    lines.extend(diagnostic.help.iter().map(|help| format!("#   help: {help}")));
    lines.extend(diagnostic.fix.iter().map(|fix| {
        format!("#   fix {}: {}", place(sources, fix.span), fix.replacement.replace('\n', "\\n"))
    }));
    lines.iter().map(|line| line.trim_end().to_owned() + "\n").collect()
}

fn all_written(loaded: &Loaded) -> String {
    loaded.diagnostics.iter().map(|diagnostic| written(&loaded.sources, diagnostic)).collect()
}

/// The lines of both texts; those of one alone are marked.
fn difference(expected: &str, actual: &str) -> String {
    let only = |text: &str, other: &str, mark: char| -> String {
        let mark = |line: &str| if other.lines().any(|l| l == line) { ' ' } else { mark };
        text.lines().map(|line| format!("  {}{line}\n", mark(line))).collect()
    };
    format!("  expected:\n{}  actual:\n{}", only(expected, actual, '-'), only(actual, expected, '+'))
}

/// What is to be true of every diagnostic.
fn style(diagnostic: &Diagnostic) -> Option<String> {
    let texts = diagnostic.labels.iter().map(|label| &label.text).chain(&diagnostic.help);
    texts
        .chain([&diagnostic.message])
        .find(|text| text.ends_with('.') && !text.ends_with("..") || text.contains('\n') || text.len() > 250)
        .map(|text| format!("  a text with a full stop or a line break, or too long: {text}\n"))
}

/// What is wrong with a case, if anything.
fn failure(path: &Path, update: bool) -> Option<String> {
    let bytes = std::fs::read(path).unwrap();
    let (scene, expected) = split(&bytes);
    let (folder, name) = (path.parent().unwrap(), Path::new(path.file_name().unwrap()));
    let read = |asked: &Path| -> io::Result<Vec<u8>> {
        // The expectations are no part of the case: some are about the end of the file.
        if asked == name { Ok(scene.to_vec()) } else { std::fs::read(folder.join(asked)) }
    };
    let loaded = load(name, &read, &limited());
    let errors = loaded.diagnostics.iter().any(|diagnostic| diagnostic.severity == Severity::Error);
    assert_eq!(loaded.scene.is_none(), errors, "{}: a scene exactly without errors", path.display());
    if let Some(text) = loaded.diagnostics.iter().find_map(style) {
        return Some(text);
    }
    let actual = all_written(&loaded);
    if actual.as_bytes() == expected {
        return None;
    }
    if update {
        let newline: &[u8] = if scene.ends_with(b"\n") || scene.is_empty() { b"" } else { b"\n" };
        std::fs::write(path, [scene, newline, actual.as_bytes()].concat()).unwrap();
    }
    Some(difference(&String::from_utf8_lossy(expected), &actual))
}

#[test]
fn files_say_what_is_wrong_with_them() {
    let update = std::env::var("UPDATE_EXPECTED").is_ok_and(|value| value == "1");
    let mut paths = Vec::new();
    cases(&folder(), &mut paths);
    assert!(paths.len() > 100, "cases are missing");
    let failures: Vec<String> = paths
        .iter()
        .filter_map(|path| failure(path, update).map(|text| format!("{}\n{text}", path.display())))
        .collect();
    let advice = if update { "rewritten; run again" } else { "UPDATE_EXPECTED=1 rewrites the expectations" };
    assert!(failures.is_empty(), "\n{}\n{} cases differ ({advice})", failures.join("\n"), failures.len());
}

// Cases that are not text.

/// A scene without fault, with `middle` in its world block.
fn scene(middle: &[u8]) -> Vec<u8> {
    let head: &[u8] =
        b"Camera \"perspective\" Film \"image\" Sampler \"sobol\" Integrator \"path\"\nWorldBegin\n\
        LightSource \"infinite\"\n";
    [head, middle, b"\nShape \"sphere\" WorldEnd\n"].concat()
}

/// Loads `scene.pbrt`, the first of the files.
#[track_caller]
fn check(files: &[(&str, &[u8])], expected: &[&str]) {
    let read = |asked: &Path| -> io::Result<Vec<u8>> {
        let known = files.iter().find(|(name, _)| Path::new(name) == asked);
        known.map(|(_, bytes)| bytes.to_vec()).ok_or_else(|| io::ErrorKind::NotFound.into())
    };
    let loaded = load(Path::new("scene.pbrt"), &read, &limited());
    let (actual, expected) =
        (all_written(&loaded), expected.iter().map(|line| format!("{line}\n")).collect::<String>());
    assert!(actual == expected, "\n{}", difference(&expected, &actual));
}

#[track_caller]
fn check_scene(scene: &[u8], expected: &[&str]) {
    check(&[("scene.pbrt", scene)], expected);
}

#[test]
fn a_byte_order_mark_is_no_text() {
    check_scene(&[b"\xEF\xBB\xBF".as_slice(), &scene(b"")].concat(), &[]);
}

#[test]
fn comments_and_names_may_hold_any_bytes() {
    check_scene(&scene(b"# caf\xe9 \xff\x00\nMakeNamedMaterial \"gr\xfcn\" \"string type\" \"matte\""), &[]);
}

#[test]
fn lines_may_end_as_in_windows() {
    let text = String::from_utf8(scene(b"# comment\n\nShape \"sphrere\"\nShape \"sphere")).unwrap();
    check_scene(
        text.replace('\n', "\r\n").as_bytes(),
        &[
            "# error 6:7-6:16: unknown Shape \"sphrere\"",
            "#   help: did you mean \"sphere\"?",
            "#   fix 6:7-6:16: \"sphere\"",
            "# error 7:7-7:14: the string is not closed",
            "#   help: add the closing quote on the same line",
        ],
    );
}

#[test]
fn bytes_that_are_no_text_are_shown_as_such() {
    check_scene(
        &scene(b"\x00\x01\x02 Shape \"sphere\""),
        &["# error 4:1-4:4: unknown directive `\\u{0}\\u{1}\\u{2}`"],
    );
    check_scene(
        &scene(b"Shape \"sph\xe8re\""),
        &[
            "# error 4:7-4:15: unknown Shape \"sph\u{fffd}re\"",
            "#   help: did you mean \"sphere\"?",
            "#   fix 4:7-4:15: \"sphere\"",
        ],
    );
}

#[test]
fn columns_count_characters() {
    check_scene(
        &scene("NamedMaterial \"grün\" Shape \"sphrere\"".as_bytes()),
        &[
            "# warning 4:15-4:21: there is no named material \"grün\": the material before it, or matte in a mix, is used, as in pbrt-v3",
            "#   help: define it with MakeNamedMaterial; none is defined at this point",
            "# error 4:28-4:37: unknown Shape \"sphrere\"",
            "#   help: did you mean \"sphere\"?",
            "#   fix 4:28-4:37: \"sphere\"",
        ],
    );
}

/// A binary PLY file of three vertices and the given faces.
fn ply(faces: &str, body: &[u8]) -> Vec<u8> {
    let header = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
         property float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    );
    let vertices = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_le_bytes);
    [header.as_bytes(), vertices.as_flattened(), body].concat()
}

#[test]
fn what_a_ply_file_promises_is_not_trusted() {
    let scene = scene(b"Shape \"plymesh\" \"string filename\" \"a.ply\"");
    let triangle = [&[3_u8][..], [0_i32, 1, 2].map(i32::to_le_bytes).as_flattened()].concat();
    let check_ply =
        |bytes: &[u8], expected: &[&str]| check(&[("scene.pbrt", &scene), ("a.ply", bytes)], expected);
    check_ply(&ply("1", &triangle), &[]);
    let promise = "a.ply: the header declares 4000000000 faces, but the file has only 49 bytes after it";
    check_ply(&ply("4000000000", &triangle), &[&format!("# error 4:35-4:42: {promise}")]);
    check_ply(&ply("1", &triangle[..7]), &["# error 4:35-4:42: a.ply: the file ends inside face 0 of 1"]);
    check_ply(&ply("1", &triangle)[..87], &["# error 4:35-4:42: a.ply: the header has no `end_header` line"]);
    check_ply(
        b"",
        &["# error 4:35-4:42: a.ply: line 1: this is not a PLY file, which begins with a line `ply`"],
    );
}

#[test]
fn a_file_full_of_mistakes_is_told_in_few_words() {
    let count = |text: &[u8]| {
        let loaded = load(Path::new("scene.pbrt"), &|_| Ok(text.to_vec()), &LoadOptions::default());
        loaded.diagnostics.len()
    };
    assert_eq!(count(&scene(&b"Shape \"sphrere\"\n".repeat(10_000))), 1);
    // That more than 1,000 are open is an error of its own.
    assert_eq!(count(&scene(&b"AttributeBegin\n".repeat(10_000))), 2);
    assert_eq!(count(&scene(&b"AttributeEnd\n".repeat(10_000))), 1);
    assert_eq!(count(&b"Shape \"sphere\"\n".repeat(10_000)), 1);
    assert_eq!(count(&scene(&b"Translate 1, 2, 3\n".repeat(10_000))), 1);
    assert_eq!(count(&scene(&b"Material \"matte\" \"float size\" 1\n".repeat(10_000))), 1);
    assert_eq!(count(&b"\xff\x00[\"]\n".repeat(10_000)), 2);
    // All on one line, each a mark of pbrt-v4.
    assert_eq!(count(&b"Attribute \"shape\" \"float a\" 1 ".repeat(100_000)), 2);
}
