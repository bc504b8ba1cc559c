//! What `lookat check --view` says about scenes with mistakes that only the picture shows: beside each scene of `tests/views`
//! stands the expected text. `UPDATE_EXPECTED=1 cargo test -p lookat --test properties views` rewrites the texts, for `git diff` to judge.

use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The scenes of a folder, in the order of their names, relative to the root.
fn scenes(folder: &str) -> Vec<PathBuf> {
    let names = root().join(folder).read_dir().unwrap().map(|entry| entry.unwrap().file_name());
    let all = names.map(|name| Path::new(folder).join(name));
    let mut scenes: Vec<PathBuf> =
        all.filter(|path| path.extension().is_some_and(|it| it == "pbrt")).collect();
    scenes.sort();
    scenes
}

/// What is said about a scene.
fn said(scene: &Path) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lookat"));
    let output = command.current_dir(root()).args(["check", "--view"]).arg(scene).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", scene.display());
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn mistakes_that_the_picture_shows_are_named() {
    for scene in scenes("tests/views") {
        let (said, file) = (said(&scene), root().join(&scene).with_extension("txt"));
        if std::env::var_os("UPDATE_EXPECTED").is_some() {
            std::fs::write(&file, &said).unwrap();
        }
        let expected = std::fs::read_to_string(&file).unwrap_or_default();
        assert_eq!(said, expected, "{}", scene.display());
    }
}

/// What `check` says about them it says without `--view`, too.
#[test]
fn scenes_as_they_are_meant_have_no_warnings_about_the_view() {
    for folder in ["", "/cameras", "/gallery", "/lights", "/materials", "/shapes", "/stability", "/textures"]
    {
        for scene in scenes(&format!("pbrt-scenes{folder}")) {
            let mut command = Command::new(env!("CARGO_BIN_EXE_lookat"));
            let output = command.current_dir(root()).arg("check").arg(&scene).output().unwrap();
            assert_eq!(said(&scene), String::from_utf8(output.stderr).unwrap(), "{}", scene.display());
        }
    }
}
