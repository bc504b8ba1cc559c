//! The program as people and scripts meet it: arguments, exit statuses, and what it prints and writes.

use std::io::Write;
use std::path::Path;
use std::process::Stdio;

use lookat_image::{Image, agreement, align};
use lookat_scene::Overrides;
use lookat_scene::syntax::Severity;
use serde_json::Value;

mod folder;
#[path = "cli/stopping.rs"]
mod stopping;

use folder::{Folder, Run};

/// A scene without fault that renders in a moment.
const FINE: &str = r#"LookAt 0 0 -4  0 0 0  0 1 0
Camera "perspective" "float fov" 40
Film "image" "integer xresolution" 32 "integer yresolution" 24 "string filename" "fine.pfm"
Sampler "sobol" "integer pixelsamples" 4
Integrator "path"
WorldBegin
LightSource "point" "point from" [3 4 -5] "rgb I" [30 30 30]
LightSource "infinite" "rgb L" [.2 .2 .2]
Shape "sphere"
WorldEnd
"#;

impl Folder {
    fn new() -> Self {
        let folder = Folder::empty();
        folder.write("fine.pbrt", FINE);
        folder.write("warns.pbrt", &FINE.replace("Shape \"sphere\"", "Shape \"sphere\" \"float raduis\" 2"));
        folder.write(
            "wrong.pbrt",
            &FINE.replace("Shape \"sphere\"", "Shape \"sphrere\"\nShape \"sphere\"\nMaterial \"mate\""),
        );
        folder
    }

    /// The names of all files, in order.
    fn names(&self) -> Vec<String> {
        let entries = self.0.path().read_dir().unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn run_with_input(&self, arguments: &[&str], input: &str) -> Run {
        let mut command = self.command(arguments);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
        Run::of(child.wait_with_output().unwrap())
    }

    /// Renders `fine.pbrt` into `picture.exr` with more arguments, and reads it.
    #[track_caller]
    fn picture(&self, arguments: &[&str]) -> Image {
        let run = self.run(&[&["render", "fine.pbrt", "-o", "picture.exr"], arguments].concat());
        assert_eq!(run.status, 0, "{arguments:?}: {}", run.err);
        Image::read(&self.path("picture.exr")).unwrap()
    }
}

#[test]
fn the_exit_status_tells_fine_from_wrong_from_trouble() {
    let folder = Folder::new();
    let check = |arguments: &[&str], status: i32| {
        let run = folder.run(arguments);
        assert_eq!(run.status, status, "{arguments:?}\n{}", run.err);
    };
    check(&["check", "fine.pbrt"], 0);
    check(&["check", "warns.pbrt"], 0);
    check(&["check", "wrong.pbrt"], 1);
    check(&["check", "fine.pbrt", "wrong.pbrt", "fine.pbrt"], 1);
    check(&["check", "nothing.pbrt"], 1);
    check(&["render", "fine.pbrt"], 0);
    check(&["render", "warns.pbrt"], 0);
    check(&["render", "wrong.pbrt"], 1);
    check(&["render", "nothing.pbrt"], 1);
    check(&["render", "fine.pbrt", "-o", "picture.jpg"], 2);
    check(&["render", "fine.pbrt", "-o", "nowhere/picture.exr"], 2);
    check(&[], 2);
    check(&["paint", "fine.pbrt"], 2);
    check(&["check"], 2);
    check(&["render"], 2);
    check(&["render", "fine.pbrt", "wrong.pbrt"], 2);
    check(&["render", "fine.pbrt", "--spp", "0"], 2);
    check(&["render", "fine.pbrt", "--threads", "0"], 2);
    check(&["render", "fine.pbrt", "--resolution", "640"], 2);
    check(&["render", "fine.pbrt", "--resolution", "0x480"], 2);
    check(&["render", "fine.pbrt", "--crop", "0", "1", "0"], 2);
    check(&["render", "fine.pbrt", "--crop", "0", "2", "0", "1"], 2);
    check(&["render", "fine.pbrt", "--seed", "-1"], 2);
    check(&["--help"], 0);
    check(&["--version"], 0);
}

#[test]
fn a_diagnostic_shows_the_line_and_the_way_out() {
    let run = Folder::new().run(&["check", "wrong.pbrt", "warns.pbrt", "fine.pbrt"]);
    assert_eq!(run.out, "", "diagnostics go to standard error");
    for part in [
        "error: unknown Shape \"sphrere\"",
        "--> wrong.pbrt:9:7",
        "9 | Shape \"sphrere\"",
        "help: did you mean \"sphere\"?",
        "error: unknown Material \"mate\"",
        "wrong.pbrt: 2 errors\n",
        "warning: Shape \"sphere\" has no parameter \"raduis\"; it is ignored",
        "warns.pbrt: 1 warning\n",
    ] {
        assert!(run.err.contains(part), "no {part:?} in\n{}", run.err);
    }
    assert!(run.err.ends_with("fine.pbrt: fine\n"), "{}", run.err);
    assert!(!run.err.contains('\u{1b}'), "no colors into a pipe");
}

/// The lines of standard output, each of which has to be JSON.
fn json_lines(run: &Run) -> Vec<Value> {
    run.out.lines().map(|line| serde_json::from_str(line).expect(line)).collect()
}

#[test]
fn json_is_a_line_for_each_scene_with_all_diagnostics() {
    let folder = Folder::new();
    let files = ["wrong.pbrt", "fine.pbrt", "warns.pbrt", "nothing.pbrt"];
    let run = folder.run(&[&["check", "--json"], &files[..]].concat());
    assert_eq!((run.status, run.err.as_str()), (1, ""));
    let lines = json_lines(&run);
    assert_eq!(lines.len(), files.len());
    for (line, name) in lines.iter().zip(files) {
        let read = |path: &Path| std::fs::read(folder.path("").join(path));
        let loaded = lookat_scene::load(Path::new(name), &read, &Overrides::default());
        assert_eq!(line["scene"], name);
        let told = line["diagnostics"].as_array().unwrap();
        assert_eq!(told.len(), loaded.diagnostics.len());
        for (told, diagnostic) in told.iter().zip(&loaded.diagnostics) {
            let severity = if diagnostic.severity == Severity::Error { "error" } else { "warning" };
            assert_eq!(told["severity"], severity);
            assert_eq!(told["message"], diagnostic.message.as_str());
            assert_eq!(told["help"].as_str(), diagnostic.help.as_deref());
            assert_eq!(
                told["fix"]["replacement"].as_str(),
                diagnostic.fix.as_ref().map(|f| f.replacement.as_str())
            );
            let labels = told["labels"].as_array().unwrap();
            assert_eq!(labels.len(), diagnostic.labels.len());
            for (told, label) in labels.iter().zip(&diagnostic.labels) {
                let place = loaded.sources.location(label.span);
                assert_eq!(told["file"], name);
                assert_eq!(
                    (told["line"].as_u64(), told["column"].as_u64()),
                    (Some(place.line as u64), Some(place.column as u64))
                );
                assert_eq!(
                    (told["start"].as_u64(), told["end"].as_u64()),
                    (Some(label.span.start.into()), Some(label.span.end.into()))
                );
                assert_eq!(told["text"], label.text.as_str());
            }
        }
    }
}

#[test]
fn json_tells_of_the_picture_or_why_there_is_none() {
    let folder = Folder::new();
    let run =
        folder.run(&["render", "fine.pbrt", "-o", "picture.exr", "--json", "--crop", "0", ".5", "0", "1"]);
    assert_eq!((run.status, run.err.as_str()), (0, ""));
    let picture = &json_lines(&run)[0]["picture"];
    assert_eq!(picture["file"], "picture.exr");
    assert_eq!((picture["width"].as_u64(), picture["height"].as_u64()), (Some(16), Some(24)));
    assert_eq!(picture["samples_per_pixel"].as_f64(), Some(4.0));
    assert_eq!(picture["complete"], true);

    let run = folder.run(&["render", "wrong.pbrt", "--json"]);
    let lines = json_lines(&run);
    assert_eq!((run.status, lines.len()), (1, 1));
    assert!(lines[0]["picture"].is_null());
    assert_eq!(lines[0]["diagnostics"].as_array().unwrap().len(), 2);

    let run = folder.run(&["render", "fine.pbrt", "-o", "picture.jpg", "--json"]);
    let lines = json_lines(&run);
    assert_eq!((run.status, lines.len()), (2, 1));
    assert!(lines[0]["error"].as_str().unwrap().contains("picture.jpg"));
}

/// Whoever looks away from everything is told so; inside a closed sphere there is something to see, but no light.
#[test]
fn black_pictures_are_told() {
    let folder = Folder::new();
    let without_sky = FINE.replace("LightSource \"infinite\" \"rgb L\" [.2 .2 .2]\n", "");
    folder.write("away.pbrt", &without_sky.replace("0 0 -4  0 0 0", "0 0 -4  0 0 -9"));
    folder.write("inside.pbrt", &without_sky.replace("0 0 -4  0 0 0", "0 0 0  0 0 9"));
    let said = |scene, args: &[&str]| folder.run(&[&["render", scene, "-o", "a.pfm"], args].concat());
    assert!(said("away.pbrt", &[]).err.contains("no ray from the camera meets a surface"));
    assert!(said("inside.pbrt", &[]).err.contains("no light comes to the camera"));
    assert!(!said("fine.pbrt", &[]).err.contains("black"));
    for (scene, black) in [("away.pbrt", true), ("inside.pbrt", true), ("fine.pbrt", false)] {
        assert_eq!(json_lines(&said(scene, &["--json"]))[0]["picture"]["black"], black);
    }
}

// Elsewhere a name of other case may be that of the file.
#[cfg(target_os = "linux")]
#[test]
fn files_that_are_there_under_another_name_are_told() {
    let folder = Folder::empty();
    std::fs::create_dir_all(folder.path("textures/old")).unwrap();
    for name in ["textures/Wood.spd", "textures/steel-01.spd", "glass.spd"] {
        folder.write(name, "400 1 700 1");
    }
    let names = [
        ("Textures/wood.SPD", Some("textures/Wood.spd")),
        ("textures\\\\Wood.spd", Some("textures/Wood.spd")),
        ("C:/Users/me/textures/Wood.spd", Some("textures/Wood.spd")),
        ("/home/me/glass.spd", Some("glass.spd")),
        ("textures/old/../Wood.sdp", Some("textures/old/../Wood.spd")),
        // Another number is another file, and a folder is none.
        ("textures/steel-02.spd", None),
        ("textures/OLD", None),
        ("nowhere.ply", None),
    ];
    for (name, meant) in names {
        let shape = format!("Material \"metal\" \"spectrum k\" \"{name}\" Shape \"sphere\"");
        folder.write("a.pbrt", &FINE.replace("Shape \"sphere\"", &shape));
        let run = folder.run(&["check", "--json", "a.pbrt"]);
        let diagnostics = &json_lines(&run)[0]["diagnostics"];
        let help = diagnostics[0]["help"].as_str().unwrap();
        match meant {
            Some(meant) => {
                assert_eq!(help, format!("did you mean \"{meant}\"?"), "{name}");
                assert_eq!(diagnostics[0]["fix"]["replacement"], format!("\"{meant}\""), "{name}");
            }
            None => assert!(help.starts_with("names are relative"), "{name}: {help}"),
        }
    }
}

#[test]
fn strict_makes_errors_of_warnings() {
    let folder = Folder::new();
    for command in ["check", "render"] {
        let run = folder.run(&[command, "warns.pbrt", "--strict"]);
        assert_eq!(run.status, 1, "{}", run.err);
        assert!(run.err.contains("error: Shape \"sphere\" has no parameter"), "{}", run.err);
        assert_eq!(folder.run(&[command, "fine.pbrt", "--strict"]).status, 0);
    }
}

#[test]
fn keep_going_renders_what_is_left() {
    let folder = Folder::new();
    let run = folder.run(&["render", "wrong.pbrt", "--keep-going", "-o", "kept.exr"]);
    assert_eq!(run.status, 0, "the picture that was asked for is there: {}", run.err);
    assert!(run.err.contains("unknown Shape"), "{}", run.err);
    let kept = Image::read(&folder.path("kept.exr")).unwrap();
    assert_eq!(kept.channels, folder.picture(&[]).channels);
}

/// With the words on the left, which are in error, the picture is that of the words on the right.
#[test]
fn keep_going_takes_what_is_right_of_what_is_wrong() {
    let folder = Folder::new();
    let bytes = |text: &str| {
        folder.write("a.pbrt", text);
        let run = folder.run(&["render", "a.pbrt", "--keep-going", "-o", "a.pfm"]);
        assert_eq!(run.status, 0, "{}", run.err);
        std::fs::read(folder.path("a.pfm")).unwrap()
    };
    let sphere = |before: &str| FINE.replace("Shape", &format!("{before} Shape"));
    let object = |ends: &str| {
        let begin = "AttributeBegin Translate 0 0 1 ObjectBegin \"a\" Translate 0 1 0 AttributeBegin Translate 1 0 0 Shape";
        FINE.replace("Shape", begin)
            .replace("WorldEnd", &format!("AttributeEnd {ends} ObjectInstance \"a\" WorldEnd"))
    };
    let depth = |more: &str| FINE.replace("\"path\"", &format!("\"path\" \"integer maxdepth\" 0 {more}"));
    for (wrong, right) in [
        (
            sphere("Material \"phong\" \"rgb Kd\" [.9 .1 .1]"),
            sphere("Material \"matte\" \"rgb Kd\" [.9 .1 .1]"),
        ),
        (object("AttributeEnd Scale 9 9 9 ObjectEnd"), object("ObjectEnd AttributeEnd")),
        (depth("\"string lightsamplestrategy\" \"some\""), depth("")),
        (FINE.replace("[.2 .2 .2]", "[.2 .2 .2] \"string mapname\" \"none.exr\""), FINE.to_owned()),
    ] {
        assert!(bytes(&wrong) == bytes(&right), "{wrong}");
    }
}

#[test]
fn quiet_leaves_only_errors() {
    let folder = Folder::new();
    let run = folder.run(&["render", "warns.pbrt", "--quiet"]);
    assert_eq!((run.status, run.out.as_str(), run.err.as_str()), (0, "", ""));
    let run = folder.run(&["render", "wrong.pbrt", "-q"]);
    assert_eq!(run.status, 1);
    assert!(run.err.contains("unknown Shape"), "{}", run.err);
    let run = folder.run(&["render", "warns.pbrt"]);
    assert!(run.err.contains("warning: ") && run.err.contains("fine.pfm: 32 x 24 pixels"), "{}", run.err);
}

#[test]
fn a_minus_is_standard_input() {
    let folder = Folder::new();
    assert_eq!(folder.run_with_input(&["check", "-"], FINE).status, 0);
    let run = folder.run_with_input(&["check", "-"], "Teapot");
    assert_eq!(run.status, 1);
    assert!(run.err.contains("standard input:1:1"), "{}", run.err);
    folder.write("part.pbrt", "Shape \"sphere\"");
    let scene = FINE.replace("Shape \"sphere\"", "Include \"part.pbrt\"");
    let run = folder.run_with_input(&["render", "-", "-o", "piped.exr"], &scene);
    assert_eq!(run.status, 0, "{}", run.err);
    let piped = Image::read(&folder.path("piped.exr")).unwrap();
    assert_eq!(piped.channels, folder.picture(&[]).channels);
}

#[test]
fn a_failure_writes_nothing() {
    let folder = Folder::new();
    let before = folder.names();
    for arguments in [
        &["render", "wrong.pbrt"][..],
        &["render", "warns.pbrt", "--strict"],
        &["render", "fine.pbrt", "-o", "picture.jpg"],
        &["render", "fine.pbrt", "-o", "picture"],
        &["render", "fine.pbrt", "-o", "nowhere/picture.exr"],
        &["render", "fine.pbrt", "--crop", ".5", ".5", "0", "1"],
        &["render", "fine.pbrt", "--crop", "0", "1", ".5", ".2"],
        &["check", "fine.pbrt"],
    ] {
        folder.run(arguments);
        assert_eq!(folder.names(), before, "{arguments:?}");
    }
    let run = folder.run(&["render", "fine.pbrt", "-o", "picture.jpg"]);
    assert!(run.err.contains("exr, png, pfm and tga"), "it says what it writes: {}", run.err);
    let run = folder.run(&["render", "fine.pbrt", "-o", "nowhere/picture.exr"]);
    assert!(run.err.contains("there is no folder nowhere"), "{}", run.err);
    // A folder that takes no files is found out before anything is rendered.
    #[cfg(target_os = "linux")]
    {
        let run = folder.run(&["render", "fine.pbrt", "-o", "/proc/picture.exr"]);
        assert_eq!((run.status, run.err.lines().count()), (2, 1), "{}", run.err);
        assert!(run.err.contains("cannot write /proc/picture.exr"), "{}", run.err);
    }
}

#[test]
fn a_failure_keeps_the_picture_that_was_there() {
    let folder = Folder::new();
    folder.write("fine.pfm", "not a picture");
    assert_eq!(folder.run(&["render", "wrong.pbrt"]).status, 1);
    assert_eq!(std::fs::read(folder.path("fine.pfm")).unwrap(), b"not a picture");
    assert_eq!(folder.run(&["render", "fine.pbrt"]).status, 0);
    assert_eq!(Image::read(&folder.path("fine.pfm")).unwrap().data_window.width, 32);
}

#[test]
fn the_picture_goes_where_film_or_command_line_say() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("out")).unwrap();
    for name in ["a.exr", "b.pfm", "c.png", "d.tga", "out/e.exr"] {
        assert_eq!(folder.run(&["render", "fine.pbrt", "-o", name]).status, 0, "{name}");
        assert!(folder.path(name).is_file(), "{name}");
    }
    assert!(!folder.path("fine.pfm").exists());
    assert_eq!(folder.run(&["render", "fine.pbrt"]).status, 0);
    assert!(folder.path("fine.pfm").is_file());
}

#[test]
fn options_of_pbrt_are_understood() {
    let folder = Folder::new();
    let run = folder.run(&[
        "render",
        "--outfile",
        "pbrt.exr",
        "--nthreads",
        "2",
        "--quiet",
        "--cropwindow",
        "0",
        ".5",
        "0",
        ".25",
        "fine.pbrt",
    ]);
    assert_eq!(run.status, 0, "{}", run.err);
    let pbrt = Image::read(&folder.path("pbrt.exr")).unwrap();
    assert_eq!((pbrt.data_window.width, pbrt.data_window.height), (16, 6));
    assert_eq!(pbrt.channels, folder.picture(&["--crop", "0", ".5", "0", ".25"]).channels);
}

#[test]
fn options_take_the_place_of_the_files() {
    let folder = Folder::new();
    let sides = |image: &Image| (image.data_window.width, image.data_window.height);
    let plain = folder.picture(&[]);
    assert_eq!(sides(&plain), (32, 24));
    assert_eq!(sides(&folder.picture(&["--resolution", "20x10"])), (20, 10));
    assert_eq!(sides(&folder.picture(&["--quick"])), (8, 6));

    let crop = folder.picture(&["--crop", ".25", ".75", ".5", "1"]);
    let (data, display) = (crop.data_window, crop.display_window);
    assert_eq!((data.x, data.y, data.width, data.height), (8, 12, 16, 12));
    assert_eq!((display.x, display.y, display.width, display.height), (0, 0, 32, 24));
    let (all, part) = (plain.rgb().unwrap(), crop.rgb().unwrap());
    for (row, pixels) in part.chunks(16).enumerate() {
        let start = (row + 12) * 32 + 8;
        assert_eq!(pixels, &all[start..start + 16], "a cropped picture is that part of the whole");
    }

    assert_ne!(plain.channels, folder.picture(&["--spp", "5"]).channels);
    assert_eq!(plain.channels, folder.picture(&["--spp", "4"]).channels);
    let samples =
        |image: &Image| -> Value { serde_json::from_str(image.metadata.as_deref().unwrap()).unwrap() };
    assert_eq!(samples(&folder.picture(&["--spp", "7"]))["samples_per_pixel"].as_f64(), Some(7.0));
    assert_eq!(samples(&folder.picture(&["--quick"]))["samples_per_pixel"].as_f64(), Some(1.0));
}

#[test]
fn threads_change_no_byte_and_seeds_change_the_noise() {
    let folder = Folder::new();
    let bytes = |arguments: &[&str]| {
        folder.picture(arguments);
        std::fs::read(folder.path("picture.exr")).unwrap()
    };
    let one = bytes(&["--threads", "1"]);
    for threads in ["2", "7"] {
        assert!(bytes(&["--threads", threads]) == one, "{threads} threads");
    }
    assert!(bytes(&["--seed", "0"]) == one, "0 is the seed of old");
    assert!(bytes(&["--seed", "1"]) == bytes(&["--seed", "1"]));
    let noise = |seed: &str| folder.picture(&["--seed", seed]).channels;
    assert_ne!(noise("0"), noise("1"));
    assert_ne!(noise("1"), noise("18446744073709551615"));
}

#[test]
fn places_in_long_lines_are_told_by_their_own_column() {
    let folder = Folder::new();
    let indices = "0 1 2 ".repeat(400);
    let mesh = format!(
        "Shape \"trianglemesh\" \"integer indices\" [{indices}0 1 7] \"point P\" [0 0 0 1 0 0 0 1 0]"
    );
    let column = mesh.find('7').unwrap() + 1;
    folder.write("long.pbrt", &FINE.replace("Shape \"sphere\"", &mesh));
    let run = folder.run(&["check", "long.pbrt"]);
    assert!(run.err.contains(&format!("long.pbrt:9:{column}\n")), "{}", run.err);
    // Not the whole line is shown.
    assert!(run.err.lines().all(|line| line.len() < 300), "{}", run.err);
}

/// The line would be shown whole, and once more as it should be.
#[test]
fn long_lines_are_shown_in_part_only() {
    let folder = Folder::new();
    let line = format!("{}Shaep \"sphere\"", "Shape \"sphere\" ".repeat(10_000));
    folder.write("long.pbrt", &FINE.replace("Shape \"sphere\"", &line));
    let run = folder.run(&["check", "long.pbrt"]);
    assert!(run.err.contains("Shaep") && run.err.contains("help: did you mean `Shape`?"), "{}", run.err);
    assert!(run.err.len() < 1000 && !run.err.contains(":::"), "{}", run.err);
}

/// A program whose help or result is lost does not say that all is well.
#[cfg(target_os = "linux")]
#[test]
fn what_cannot_be_printed_is_trouble() {
    let folder = Folder::new();
    for arguments in [&["--help"][..], &["render", "--help"], &["inspect", "fine.pbrt"]] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let out = folder.command(arguments).stdout(full).output().unwrap();
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!((out.status.code(), said.as_str()), (Some(2), "error: cannot write the result\n"));
    }
}

/// The errors that are written are as large as the errors are.
#[test]
fn error_layers_tell_how_noisy_each_pixel_is() {
    let folder = Folder::new();
    // Light from an area, so that every pixel of the sphere is noisy.
    folder.write("fine.pbrt", &FINE.replace("WorldBegin", "WorldBegin AttributeBegin Translate 1 3 -3 AreaLightSource \"diffuse\" \"rgb L\" [20 20 20] Shape \"sphere\" AttributeEnd"));
    let picture = |spp: &str, seed: &str| folder.picture(&["--error-layers", "--spp", spp, "--seed", seed]);
    for spp in ["50", "64"] {
        let (a, b) = (picture(spp, "1"), picture(spp, "2"));
        let errors = a.errors().unwrap();
        assert!(errors.iter().all(|error| error.samples.to_string() == spp && error.replicates == 16));
        let pair = align(&a, &b).unwrap();
        let found = agreement(&pair).unwrap();
        assert!(found.holds(0.01), "{found:?}");
        // The sum of squared t, by what it should be: 1 but for chance and for skewness.
        assert!(found.pixels.iter().all(|test| (0.75..1.2).contains(&test.ratio)), "{:?}", found.pixels);
        // And the picture is right: that of many samples.
        let plain = folder.picture(&["--spp", "1024", "--seed", "3"]);
        assert!(agreement(&align(&a, &plain).unwrap()).unwrap().holds(0.01));
    }
    let threads = |count: &str| {
        std::fs::read({
            folder.picture(&["--error-layers", "--threads", count]);
            folder.path("picture.exr")
        })
    };
    assert_eq!(threads("1").unwrap(), threads("3").unwrap());
    // Less than two samples tell nothing.
    assert_eq!(picture("2", "1").errors().unwrap()[0].replicates, 2);
    let refused = |arguments: &[&str], message: &str| {
        let run = folder.run(&[&["render", "fine.pbrt", "--error-layers"], arguments].concat());
        assert!(run.status == 2 && run.err.contains(message), "{}", run.err);
    };
    refused(&["-o", "a.exr", "--spp", "1"], "--error-layers needs at least 2 samples per pixel");
    refused(&["-o", "a.png"], "a.png: only an .exr file can hold error layers");
}
