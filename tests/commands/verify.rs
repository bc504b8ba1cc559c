//! `lookat verify`: the project's own scenes against their references, and the command itself.
//!
//! The references are renders by pbrt-v3 with 1,024 samples. `lookat verify pbrt-scenes` prints the differences.

use std::path::{Path, PathBuf};
use std::process::Command;

use lookat_image::{Image, Window};
use serde_json::Value;
use tempfile::TempDir;

#[cfg(unix)]
mod trouble;

/// Spheres without noise in front of a sky, and with it where a lamp shines on them.
const SCENE: &str = r#"LookAt 0 1 -5  0 0 0  0 1 0
Camera "perspective" "float fov" 40
Film "image" "integer xresolution" 48 "integer yresolution" 48
Sampler "halton" "integer pixelsamples" 32
Integrator "path"
WorldBegin
LightSource "infinite" "rgb L" [.2 .3 .4]
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [8 7 6]
  Translate 2 3 -2
  Shape "sphere" "float radius" .5
AttributeEnd
Material "matte" "rgb Kd" [.5 .5 .5]
Shape "sphere"
Translate 0 -101 0
Shape "sphere" "float radius" 100
WorldEnd
"#;

struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Folder(tempfile::tempdir().unwrap());
        folder.write("a.pbrt", SCENE);
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// Exit status, standard output, standard error.
    fn verify(&self, arguments: &[&str]) -> (i32, String, String) {
        run(&[&["verify", self.0.path().to_str().unwrap()], arguments].concat())
    }

    /// The row of scene `a`, as JSON.
    fn row(&self, arguments: &[&str]) -> (i32, Value) {
        let (status, out, err) = self.verify(&[&["--json"], arguments].concat());
        let row =
            out.lines().find(|line| line.contains("\"scene\":\"a\"")).unwrap_or_else(|| panic!("{out}{err}"));
        (status, serde_json::from_str(row).unwrap())
    }

    fn change(&self, from: &str, to: &str) {
        assert!(SCENE.contains(from));
        self.write("a.pbrt", &SCENE.replace(from, to));
    }
}

fn run(arguments: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_lookat")).args(arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// The warnings of the scenes of a folder, and how many of them have no reference. The others agree.
fn verify_scenes(folder: &str) -> [usize; 2] {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pbrt-scenes").join(folder);
    let (status, out, err) = run(&["verify", scenes.to_str().unwrap()]);
    assert_eq!(status, 0, "{out}");
    let count = |ending: &str| {
        let files = std::fs::read_dir(&scenes).unwrap().map(|entry| entry.unwrap().path());
        files.filter(|file| file.extension().is_some_and(|own| own == ending)).count()
    };
    let (all, references) = (count("pbrt"), count("exr"));
    let noun = if all == 1 { "scene" } else { "scenes" };
    assert!(out.contains(&format!("{all} {noun}: {references} agree")), "{out}");
    [err.matches("warning: ").count(), all - references]
}

#[test]
fn the_projects_scenes_agree_with_pbrt() {
    // Two of them show what lookat warns of.
    assert_eq!(verify_scenes(""), [2, 1]);
    assert_eq!(verify_scenes("cameras"), [0, 0]);
    // pbrt-v3 departs from the source of one.
    assert_eq!(verify_scenes("materials"), [1, 0]);
    // pbrt-v3 blurs textures along the seams of two mappings.
    assert_eq!(verify_scenes("textures"), [1, 0]);
    assert_eq!(verify_scenes("lights"), [0, 0]);
    // pbrt-v3 renders cones, paraboloids and hyperboloids that emit not at all, and curves with defects.
    assert_eq!(verify_scenes("shapes"), [0, 4]);
}

/// Other seeds and sample counts are nothing but noise; other scenes are more.
#[test]
fn changes_are_told_from_noise() {
    let folder = Folder::new();
    let (status, out, _) = folder.verify(&["--update", "--seed", "7", "--spp", "64"]);
    assert_eq!(status, 1, "{out}");
    for arguments in [&[][..], &["--seed", "1"], &["--spp", "8", "--seed", "2"], &["--spp", "200"]] {
        let (status, row) = folder.row(arguments);
        assert_eq!((status, &row["verdict"]), (0, &"agrees".into()), "{row}");
        assert!(row["metrics"]["rmse"].as_f64().unwrap() > 1e-4, "{row}");
    }
    for (from, to) in [
        // 2 % of one of the materials; a third of a pixel; a lamp that is a little smaller.
        ("[.5 .5 .5]", "[.51 .5 .5]"),
        ("LookAt 0 1 -5  0 0 0", "LookAt 0 1 -5  0.025 0 0"),
        ("radius\" .5", "radius\" .49"),
    ] {
        folder.change(from, to);
        let (status, row) = folder.row(&["--seed", "1"]);
        assert_eq!((status, &row["verdict"]), (1, &"differs".into()), "{to}: {row}");
    }
}

/// A reference of another renderer has no error layers.
#[test]
fn changes_are_found_without_error_layers() {
    let folder = Folder::new();
    folder.verify(&["--update", "--seed", "7", "--spp", "512"]);
    let mut image = Image::read(&folder.path("a.exr")).unwrap();
    image.channels.retain(|channel| channel.name.len() == 1);
    image.write(&folder.path("a.exr")).unwrap();
    assert_eq!(folder.row(&[]).0, 0);
    folder.change("[.5 .5 .5]", "[.52 .5 .5]");
    assert_eq!(folder.row(&[]).0, 1);
    folder.change("LookAt 0 1 -5  0 0 0", "LookAt 0 1 -5  0.03 0 0");
    assert_eq!(folder.row(&[]).0, 1);
}

#[test]
fn limits_decide_where_they_are_given() {
    let folder = Folder::new();
    folder.verify(&["--update"]);
    folder.change("[.5 .5 .5]", "[.51 .51 .51]");
    let status = |limit: &str| folder.row(&["--max", limit]);
    assert_eq!(status("rmse=0.1").0, 0);
    let (code, row) = status("rmse=0.0001");
    assert_eq!((code, &row["reason"]), (1, &"exceeds the limit of rmse".into()));
    assert!(row["metrics"]["noise-p"].as_f64().unwrap() < 0.01, "that is no limit then: {row}");
    assert_eq!(status("noise-p=0.01").0, 1);
    // A picture of 8 bits needs limits.
    std::fs::remove_file(folder.path("a.exr")).unwrap();
    run(&["render", folder.path("a.pbrt").to_str().unwrap(), "-o", folder.path("a.png").to_str().unwrap()]);
    let (code, row) = folder.row(&[]);
    assert!(code == 2 && row["reason"].as_str().unwrap().contains("--max sets other limits"), "{row}");
    assert_eq!(status("rmse=0.01").0, 0);
}

/// What changes references must not pass unnoticed, and spoils nothing.
#[test]
fn updates_write_references_and_say_so() {
    let folder = Folder::new();
    let (status, _, err) = folder.verify(&[]);
    assert!(status == 2 && err.contains("--update writes references"), "{err}");
    let (status, out, _) = folder.verify(&["--update"]);
    assert!(status == 1 && out.contains("no reference beside it; wrote"), "{out}");
    assert_eq!(folder.row(&[]).0, 0);
    let before = std::fs::read(folder.path("a.exr")).unwrap();
    // What agrees stays.
    assert_eq!(folder.verify(&["--update", "--seed", "3"]).0, 0);
    assert_eq!(std::fs::read(folder.path("a.exr")).unwrap(), before);
    folder.change("[.5 .5 .5]", "[.6 .5 .5]");
    let (status, row) = folder.row(&["--update"]);
    assert_eq!((status, &row["updated"]), (1, &true.into()));
    assert_ne!(std::fs::read(folder.path("a.exr")).unwrap(), before);
    assert_eq!(folder.row(&[]).0, 0);
    // A reference that cannot be read is left alone.
    folder.write("a.exr", "not a picture");
    let (status, row) = folder.row(&["--update"]);
    assert!(status == 2 && row["reason"].as_str().unwrap().contains("is not in the EXR format"), "{row}");
    assert_eq!(std::fs::read(folder.path("a.exr")).unwrap(), b"not a picture");
}

#[test]
fn every_scene_gets_its_row() {
    let folder = Folder::new();
    folder.verify(&["--update"]);
    folder.write("b.pbrt", &SCENE.replace("Shape", "Shpae"));
    std::fs::copy(folder.path("a.exr"), folder.path("b.exr")).unwrap();
    folder.write("c.pbrt", SCENE);
    folder.write("d.pbrt", SCENE);
    let mut broken = Image::read(&folder.path("a.exr")).unwrap();
    broken.channels[0].samples[5] = f32::NAN;
    broken.write(&folder.path("d.exr")).unwrap();
    folder.write("e.pbrt", SCENE);
    let window = Window { x: 0, y: 0, width: 4, height: 4 };
    Image::from_rgb(window, window, &[[0.0; 3]; 16]).write(&folder.path("e.exr")).unwrap();
    let (status, out, err) = folder.verify(&[]);
    assert_eq!(status, 2);
    let rows: Vec<&str> = out.lines().skip(1).collect();
    for (row, start, end) in [
        (0, "a     agrees ", "identical"),
        (1, "b     failed", "unknown directive `Shpae`"),
        (2, "c     new    ", "no reference beside it"),
        (3, "d     differs", "1 pixel of the reference is not finite"),
        (4, "e     differs", "the sizes differ: 48x48 and 4x4"),
        (5, "5 scenes: 1 agrees, 2 differ", "1 without a reference, 1 failed"),
    ] {
        assert!(rows[row].starts_with(start) && rows[row].ends_with(end), "{out}");
    }
    assert!(err.contains("unknown directive `Shpae`"), "{err}");
    let (status, _, err) = run(&["verify", folder.path("nowhere").to_str().unwrap()]);
    assert!(status == 2 && err.contains("nowhere"), "{err}");
}

/// A picture that another scene uses is no reference that can be replaced.
#[test]
fn an_update_keeps_the_files_of_all_scenes() {
    let folder = Folder::new();
    assert_eq!(folder.verify(&["--update"]).0, 1);
    let texture = "Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"a.exr\"\nMaterial \"matte\"";
    std::fs::write(folder.path("z.pbrt"), SCENE.replace("Material \"matte\"", texture)).unwrap();
    folder.change("[.5 .5 .5]", "[.9 .9 .9]");
    let before = std::fs::read(folder.path("a.exr")).unwrap();
    let (status, row) = folder.row(&["--update"]);
    assert_eq!((status, &row["verdict"]), (2, &"failed".into()), "{row}");
    assert!(row["reason"].as_str().unwrap().contains("this file is an input"), "{row}");
    assert_eq!(std::fs::read(folder.path("a.exr")).unwrap(), before);
    // Nor by the report.
    std::fs::write(folder.path("part.html"), "").unwrap();
    folder.change("WorldBegin", "Include \"part.html\" WorldBegin");
    let (status, _, err) = folder.verify(&["--report", folder.path("part.html").to_str().unwrap()]);
    assert!(status == 2 && err.contains("this file is an input"), "{err}");
}
