//! A folder with every kind of trouble.

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;

use super::*;

const LONG: &str = "a name that is much longer than the names of the other scenes in this folder";

/// How a scene is spoiled, with the verdict on it and a part of the reason.
const CASES: [(&str, &str, &str); 18] = [
    ("a", "agrees", "identical"),
    (LONG, "agrees", "identical"),
    ("caf\u{fffd}", "agrees", "identical"),
    ("far", "differs", "by more than noise"),
    ("small", "differs", "the sizes differ: 48x48 and 4x4"),
    ("rare", "undecided", "only a few pixels differ, and the reference is brighter there (tail index "),
    ("lonely", "new", "no reference beside it"),
    ("texture", "new", "no reference beside the scene, except a picture that the scene uses"),
    ("reference-link", "failed", "reference-link.exr is a link to nowhere.exr, where there is no file"),
    ("reference-folder", "failed", "reference-folder.exr is a folder, not a file"),
    ("reference-loop", "failed", "reference-loop.exr: Too many levels of symbolic links"),
    ("reference-text", "failed", "is not in the"),
    ("reference-alpha", "failed", "the second picture has neither the channels R, G and B nor Y"),
    ("scene-error", "failed", "the scene has an error: unknown directive `Shpae`"),
    ("scene-link", "failed", "scene-link.pbrt is a link to nowhere.pbrt, where there is no file"),
    ("scene-folder", "failed", "scene-folder.pbrt is a folder, not a file"),
    ("scene-loop", "failed", "scene-loop.pbrt: Too many levels of symbolic links"),
    ("scene-pipe", "failed", "scene-pipe.pbrt is a pipe or a device, not a file"),
];

fn troubled() -> Folder {
    let folder = Folder::new();
    let copy = |ending: &str, name: &str| {
        std::fs::copy(folder.path(&format!("a.{ending}")), folder.path(&format!("{name}.{ending}"))).unwrap();
    };
    assert_eq!(folder.verify(&["--update"]).0, 1);
    let both = [
        LONG,
        "far",
        "small",
        "reference-text",
        "reference-alpha",
        "scene-error",
        "scene-link",
        "scene-folder",
    ];
    for name in both.into_iter().chain(["scene-loop", "scene-pipe"]) {
        copy("exr", name);
    }
    let scenes = ["lonely", "rare", "texture", "reference-link", "reference-folder", "reference-loop"];
    for name in [LONG, "far", "small", "reference-text", "reference-alpha"].into_iter().chain(scenes) {
        copy("pbrt", name);
    }
    for ending in ["pbrt", "exr"] {
        let name = folder.0.path().join(OsStr::from_bytes(&[b"caf\xe9.", ending.as_bytes()].concat()));
        std::fs::copy(folder.path(&format!("a.{ending}")), name).unwrap();
    }
    let flat = |name: &str, side: u32, value: f32| {
        let window = Window { x: 0, y: 0, width: side, height: side };
        let pixels = vec![[value; 3]; (side * side) as usize];
        Image::from_rgb(window, window, &pixels).write(&folder.path(name)).unwrap();
    };
    flat("far.exr", 48, 123_456.0);
    flat("small.exr", 4, 0.5);
    flat("texture.png", 8, 0.5);
    let mut rare = Image::read(&folder.path("a.exr")).unwrap();
    rare.channels.retain(|channel| channel.name.len() == 1);
    // In 14 pixels of a tile of 16 x 16 in a row of 48.
    rare.channels[0].samples.iter_mut().step_by(49).take(14).for_each(|sample| *sample = 50.0);
    rare.write(&folder.path("rare.exr")).unwrap();
    let mut alpha = Image::read(&folder.path("a.exr")).unwrap();
    alpha.channels.truncate(1);
    alpha.channels[0].name = "A".into();
    alpha.write(&folder.path("reference-alpha.exr")).unwrap();
    let texture = "Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"texture.png\"\nMaterial \"matte\" \"texture Kd\" \"t\"";
    folder.write("texture.pbrt", &SCENE.replace("Material \"matte\" \"rgb Kd\" [.5 .5 .5]", texture));
    folder.write("reference-text.exr", "not a picture");
    folder.write("scene-error.pbrt", &SCENE.replacen("Shape", "Shpae", 1));
    symlink("nowhere.exr", folder.path("reference-link.exr")).unwrap();
    symlink("reference-loop.exr", folder.path("reference-loop.exr")).unwrap();
    symlink("nowhere.pbrt", folder.path("scene-link.pbrt")).unwrap();
    symlink("scene-loop.pbrt", folder.path("scene-loop.pbrt")).unwrap();
    std::fs::create_dir(folder.path("reference-folder.exr")).unwrap();
    std::fs::create_dir(folder.path("scene-folder.pbrt")).unwrap();
    let pipe = Command::new("mkfifo").arg(folder.path("scene-pipe.pbrt")).status().unwrap();
    assert!(pipe.success());
    folder
}

#[test]
fn each_trouble_is_told_in_text_json_and_report() {
    let folder = troubled();
    let page = folder.path("it's a page.html");
    let (status, out, _) = folder.verify(&["--report", page.to_str().unwrap()]);
    assert_eq!(status, 2, "{out}");
    let (status, lines, _) = folder.verify(&["--json"]);
    assert_eq!(status, 2, "{lines}");
    let rows: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(rows.len(), CASES.len(), "{out}");
    let page = std::fs::read_to_string(page).unwrap();
    for (name, verdict, reason) in CASES {
        let row =
            out.lines().find(|row| row.starts_with(&format!("{name} "))).unwrap_or_else(|| panic!("{out}"));
        assert!(row.contains(verdict) && row.contains(reason), "{row}");
        let json = rows.iter().find(|json| json["scene"] == name).unwrap();
        assert_eq!(json["verdict"], verdict, "{json}");
        assert!(json["reason"].as_str().unwrap().contains(reason), "{json}");
        let (_, article) = page.split_once(&format!("<h2>{name}</h2>")).unwrap_or_else(|| panic!("{name}"));
        let (article, _) = article.split_once("</article>").unwrap();
        let roles = |role: &str| article.matches(&format!("data-only=\"{role}\"")).count();
        let shown = (article.matches("class=\"viewer\"").count(), roles("expected"), roles("actual"));
        let expected = match name {
            "small" => (2, 1, 1),
            // The render alone.
            _ if verdict == "new" || name == "reference-alpha" => (1, 0, 1),
            _ if ["agrees", "differs", "undecided"].contains(&verdict) => (1, 0, 0),
            _ => (0, 0, 0),
        };
        assert_eq!(shown, expected, "{name}");
        let says_why = article.contains("unknown directive `Shpae`\n  --&gt; ");
        assert_eq!(says_why, name == "scene-error", "{article}");
        assert_eq!(json["diagnostics"].as_array().unwrap().len(), usize::from(name == "scene-error"));
    }
    assert!(
        out.ends_with("18 scenes: 3 agree, 2 differ, 1 undecided, 2 without a reference, 10 failed\n"),
        "{out}"
    );
    let quoted = "&quot;";
    let repeated = format!(" &amp;&amp; lookat verify {} --report {quoted}", folder.0.path().display());
    assert!(
        page.contains(&repeated) && page.contains(&format!("it&#39;s a page.html{quoted}</code>")),
        "{page}"
    );
}

/// Figures never touch, however large or small, and each compared scene shows the bias that it would have found.
#[test]
fn figures_stand_apart() {
    let folder = troubled();
    let (_, out, _) = folder.verify(&[]);
    let header = out.lines().next().unwrap();
    assert!(header.ends_with(" error detectable       rmse       flip    noise-p"), "{header}");
    for name in ["a", LONG, "far"] {
        let row = out.lines().find(|row| row.starts_with(&format!("{name} "))).unwrap();
        let (_, figures) = row.split_once(if name == "far" { " differs" } else { " agrees" }).unwrap();
        let figures: Vec<&str> = figures.split_whitespace().take(7).collect();
        // Error and bias are in percent.
        assert_eq!([figures[1], figures[3]], ["%", "%"], "{row}");
        for figure in [0, 2, 4, 5, 6].map(|i| figures[i]) {
            assert!(figure.parse::<f64>().is_ok(), "{figure}: {row}");
        }
        assert!(figures[2].parse::<f64>().unwrap() > 0.0, "{row}");
    }
    let (_, row) = folder.row(&[]);
    assert!(row["visible_in_mean"].as_f64().unwrap() > 1e-5, "{row}");
}

/// Neither an empty folder nor one without any reference passes.
#[test]
fn nothing_to_compare_is_an_error() {
    let folder = Folder::new();
    assert_eq!(folder.verify(&[]).0, 2);
    std::fs::remove_file(folder.path("a.pbrt")).unwrap();
    let (status, _, err) = folder.verify(&[]);
    assert!(status == 2 && err.contains("there is no .pbrt file in "), "{err}");
    symlink("nowhere.pbrt", folder.path("a.pbrt")).unwrap();
    let (status, out, _) = folder.verify(&[]);
    assert!(status == 2 && out.contains("a.pbrt is a link to nowhere.pbrt"), "{out}");
    symlink("round", folder.path("round")).unwrap();
    let (status, _, err) = run(&["verify", folder.path("round").to_str().unwrap()]);
    assert!(status == 2 && err.contains("cannot read "), "{err}");
}

/// A new reference is shown, and written neither through a dangling link nor over a folder.
#[test]
fn new_references_are_shown() {
    let folder = Folder::new();
    let page = folder.path("page.html");
    let update = ["--update", "--spp", "4", "--report", page.to_str().unwrap()];
    assert_eq!(folder.verify(&update).0, 1);
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.contains("data-only=\"actual\"") && !html.contains("data-only=\"expected\""));
    std::fs::remove_file(folder.path("a.exr")).unwrap();
    symlink("elsewhere.exr", folder.path("a.exr")).unwrap();
    let (status, out, _) = folder.verify(&update);
    assert!(status == 2 && out.contains("a.exr is a link to elsewhere.exr"), "{out}");
    assert!(!folder.path("elsewhere.exr").exists());
}
