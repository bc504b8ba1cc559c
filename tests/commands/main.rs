//! The program as people and scripts meet it: arguments, exit statuses, and what it prints and writes.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use lookat_image::{Image, agreement, align};
use lookat_scene::LoadOptions;
use lookat_scene::syntax::Severity;
use serde_json::Value;

mod chart;
mod checkpoint;
#[cfg(unix)]
mod combinations;
mod compare;
mod convert;
mod explain;
mod finished;
mod folder;
mod gallery;
mod greedy_files;
mod inspect;
mod json;
mod layers;
mod light;
mod live;
#[cfg(unix)]
mod memory;
mod messages;
mod outputs;
mod parts;
mod stability;
mod stopping;
#[cfg(unix)]
mod terminal;
mod threads;
#[cfg(unix)]
mod unread;
mod verify;
mod view;
mod walkthroughs;

use folder::{Folder, Run};

/// The folder of the project.
fn project() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A scene without fault that renders in a moment.
const FINE: &str = r#"LookAt 0 0 -4  0 0 0  0 1 0
Camera "perspective" "float fov" 40
Film "image" "integer xresolution" 32 "integer yresolution" 24 "string filename" "fine.exr"
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

    /// Runs the program under a limit of bash's `ulimit`.
    fn run_within(&self, limit: &str, arguments: &[&str]) -> Run {
        let mut command = Command::new("bash");
        command.args(["-c", &format!("ulimit {limit} && exec \"$@\""), "bash"]);
        command.arg(env!("CARGO_BIN_EXE_lookat")).args(arguments).current_dir(self.0.path());
        Run::of(command.output().unwrap())
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
        // A program that does not read it may have ended.
        let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
        Run::of(child.wait_with_output().unwrap())
    }

    /// Renders `fine.pbrt` into `picture.exr` with more arguments, over any existing file, and reads it.
    #[track_caller]
    fn picture(&self, arguments: &[&str]) -> Image {
        let run = self.run(&[&["render", "fine.pbrt", "--force", "-o", "picture.exr"], arguments].concat());
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
    check(&["check", "nothing.pbrt"], 2);
    check(&["check", "nothing.pbrt", "wrong.pbrt"], 2);
    check(&["render", "fine.pbrt"], 0);
    check(&["render", "warns.pbrt"], 0);
    check(&["render", "wrong.pbrt"], 1);
    check(&["render", "nothing.pbrt"], 2);
    check(&["inspect", "nothing.pbrt"], 2);
    check(&["render", "fine.pbrt", "-o", "picture.jpg"], 2);
    check(&["render", "fine.pbrt", "-o", "nowhere/picture.exr"], 2);
    check(&[], 2);
    check(&["paint", "fine.pbrt"], 2);
    check(&["check"], 2);
    check(&["render"], 2);
    check(&["render", "fine.pbrt", "wrong.pbrt"], 2);
    check(&["render", "fine.pbrt", "nothing.pbrt", "-o", "."], 2);
    check(&["render", "fine.pbrt", "--spp", "0"], 2);
    check(&["render", "fine.pbrt", "--threads", "0"], 2);
    check(&["render", "fine.pbrt", "--threads", "-1"], 2);
    check(&["render", "fine.pbrt", "--resolution", "640"], 2);
    check(&["render", "fine.pbrt", "--resolution", "0x480"], 2);
    check(&["render", "fine.pbrt", "--crop", "0", "1", "0"], 2);
    check(&["render", "fine.pbrt", "--crop", "0", "2", "0", "1"], 2);
    check(&["render", "fine.pbrt", "--seed", "-1"], 2);
    check(&["--help"], 0);
    check(&["--version"], 0);
    assert!(folder.run(&["--version"]).out.starts_with(concat!("lookat ", env!("CARGO_PKG_VERSION"))));
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
    assert_eq!((run.status, run.err.as_str()), (2, ""));
    let lines = json_lines(&run);
    assert_eq!(lines.len(), files.len());
    for (line, name) in lines.iter().zip(files) {
        let read = |path: &Path| std::fs::read(folder.path("").join(path));
        let loaded = lookat_scene::load(Path::new(name), &read, &LoadOptions::default());
        assert_eq!(line["scene"], name);
        let told = line["diagnostics"].as_array().unwrap();
        assert_eq!(told.len(), loaded.diagnostics.len());
        for (told, diagnostic) in told.iter().zip(&loaded.diagnostics) {
            let severity = match diagnostic.severity {
                Severity::Error => "error",
                Severity::Warning => "warning",
                Severity::Note => "note",
            };
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

/// What does not fit the scene is no error of the scene, and no picture of another size takes its place.
#[test]
fn arguments_that_do_not_fit_the_scene_are_told() {
    let folder = Folder::new();
    let check = |args: &[&str], expected: &str| {
        let run = folder.run(&[&["render", "fine.pbrt"], args].concat());
        assert_eq!((run.status, run.err.as_str()), (2, expected), "{args:?}");
    };
    let narrow = ["--crop", "0.01", "0.02", "0", "1"];
    check(&narrow, "error: the crop window contains no pixel of 32 x 24\n");
    check(
        &[&narrow[..], &["--keep-going"]].concat(),
        "error: the crop window contains no pixel of 32 x 24\n",
    );
    let most = "error: the picture has 2500000000 pixels; the limit for one run is 100000000\n";
    check(&["--resolution", "100000x100000", "--crop", "0", ".5", "0", ".5"], most);
    let wide = "error: cannot write a.tga: this format has at most 65535 pixels per side\n";
    check(&["--resolution", "70000x2", "-o", "a.tga"], wide);
    #[cfg(unix)]
    {
        let _socket = std::os::unix::net::UnixListener::bind(folder.path("socket.exr")).unwrap();
        check(&["-o", "socket.exr"], "error: cannot write socket.exr: the existing path is not a file\n");
    }
}

/// What a scene names is a file, and not what is typed.
#[test]
fn standard_input_is_the_scene_alone() {
    let folder = Folder::new();
    folder.write("includes.pbrt", &FINE.replace("Shape \"sphere\"", "Include \"-\""));
    let run = folder.run_with_input(&["check", "includes.pbrt"], "Shape \"sphere\"");
    assert_eq!(run.status, 1);
    assert!(run.err.contains("cannot include -: there is no such file"), "{}", run.err);
}

#[test]
fn a_failure_keeps_the_picture_that_was_there() {
    let folder = Folder::new();
    folder.write("fine.exr", "not a picture");
    assert_eq!(folder.run(&["render", "wrong.pbrt"]).status, 1);
    assert_eq!(std::fs::read(folder.path("fine.exr")).unwrap(), b"not a picture");
    assert_eq!(folder.run(&["render", "fine.pbrt", "--force"]).status, 0);
    assert_eq!(Image::read(&folder.path("fine.exr")).unwrap().data_window.width, 32);
}

#[test]
fn the_picture_goes_where_film_or_command_line_say() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("out")).unwrap();
    for name in ["a.exr", "b.pfm", "c.png", "d.tga", "out/e.exr"] {
        assert_eq!(folder.run(&["render", "fine.pbrt", "-o", name]).status, 0, "{name}");
        assert!(folder.path(name).is_file(), "{name}");
    }
    assert!(!folder.path("fine.exr").exists());
    assert_eq!(folder.run(&["render", "fine.pbrt"]).status, 0);
    assert!(folder.path("fine.exr").is_file());
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

/// A program whose help or result is lost does not say that all is well.
#[cfg(target_os = "linux")]
#[test]
fn what_cannot_be_printed_is_trouble() {
    let folder = Folder::new();
    for arguments in [&["--help"][..], &["render", "--help"], &["inspect", "fine.pbrt"]] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let out = folder.command(arguments).stdout(full).output().unwrap();
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!((out.status.code(), said.as_str()), (Some(2), "error: cannot write to standard output\n"));
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
        assert!(found.holds(0.01) == Some(true), "{found:?}");
        // The sum of squared t, by what it should be: 1 but for chance and for skewness.
        assert!(found.pixels.iter().all(|test| (0.75..1.2).contains(&test.ratio)), "{:?}", found.pixels);
        // And the picture is right: that of many samples.
        let plain = folder.picture(&["--spp", "1024", "--seed", "3"]);
        assert_eq!(agreement(&align(&a, &plain).unwrap()).unwrap().holds(0.01), Some(true));
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
    refused(&["-o", "a.exr", "--spp", "1"], "error layers need at least 2 samples per pixel");
    refused(&["-o", "a.png"], "a.png: only an .exr file can store error layers");
}
