//! Options that replace the camera, pictures by a moving camera, and several scenes.

use lookat_image::Channel;

use super::*;

/// `fine.pbrt` with another camera.
fn with_camera(camera: &str) -> String {
    FINE.replace("Camera \"perspective\" \"float fov\" 40", camera)
}

/// An option gives the picture that the scene with its parameter gives.
#[test]
fn options_replace_the_camera() {
    let folder = Folder::new();
    let lens = "Camera \"perspective\" \"float fov\" 40 \"float lensradius\" .5 \"float focaldistance\" 3";
    for (options, scene) in [
        (&["--fov", "55.5"][..], with_camera("Camera \"perspective\" \"float fov\" 55.5")),
        (&["--lens-radius", ".5", "--focal-distance", "3"], with_camera(lens)),
        (
            &["--screen-window", "-2 1, -1.5 .75"],
            with_camera("Camera \"perspective\" \"float fov\" 40 \"float screenwindow\" [-2 1 -1.5 .75]"),
        ),
        (
            &["--lookat", "1 2 -3  0 .5 0  0 0 1"],
            FINE.replace("0 0 -4  0 0 0  0 1 0", "1 2 -3  0 .5 0  0 0 1"),
        ),
        (
            &["--lookat=-1,2,-3, 0,.5,0, 0,0,1"],
            FINE.replace("0 0 -4  0 0 0  0 1 0", "-1 2 -3  0 .5 0  0 0 1"),
        ),
    ] {
        folder.write("other.pbrt", &scene);
        assert_eq!(folder.run(&["render", "other.pbrt", "-o", "other.exr"]).status, 0);
        let expected = Image::read(&folder.path("other.exr")).unwrap();
        assert_eq!(folder.picture(options).channels, expected.channels, "{options:?}");
        assert_ne!(folder.picture(&[]).channels, expected.channels, "{options:?}");
    }
    folder.write("lens.pbrt", &with_camera(lens));
    let run = folder.run(&["render", "lens.pbrt", "--lens-radius", "0", "-o", "lens.exr"]);
    assert!(run.status == 0 && !run.err.contains("warning"), "{}", run.err);
    assert_eq!(Image::read(&folder.path("lens.exr")).unwrap().channels, folder.picture(&[]).channels);
}

#[test]
fn options_that_no_camera_can_have_are_refused() {
    let folder = Folder::new();
    folder.write("ortho.pbrt", &with_camera("Camera \"orthographic\""));
    folder.write("all.pbrt", &with_camera("Camera \"environment\""));
    folder.write("lenses.pbrt", &with_camera(LENSES));
    folder.write("single.dat", SINGLE);
    for (scene, arguments, message) in [
        (
            "fine.pbrt",
            &["--fov", "180"][..],
            "'--fov <DEGREES>': the angle must be above 0 and below 180 degrees",
        ),
        ("fine.pbrt", &["--fov", "wide"], "'--fov <DEGREES>': expected a number"),
        ("fine.pbrt", &["--lens-radius", "-1"], "'--lens-radius <R>': the radius must be at least 0"),
        ("fine.pbrt", &["--focal-distance", "0"], "'--focal-distance <D>': the distance must be above 0"),
        (
            "fine.pbrt",
            &["--screen-window", "1 1 0 1"],
            "the window is empty: write the edges as xmin xmax ymin ymax",
        ),
        ("fine.pbrt", &["--lookat", "0 0 -4 0 0 0"], "expected 9 numbers in quotes"),
        (
            "fine.pbrt",
            &["--lookat", "0 0 0 0 0 0 0 1 0"],
            "the eye and the target of LookAt are the same point",
        ),
        ("fine.pbrt", &["--focal-distance", "3"], "--focal-distance has no effect on a pinhole"),
        (
            "ortho.pbrt",
            &["--fov", "30"],
            "--fov has no effect on an orthographic camera; to see more or less, use --screen-window",
        ),
        ("all.pbrt", &["--fov", "30"], "--fov has no effect on an environment camera"),
        ("all.pbrt", &["--lens-radius", "1"], "--lens-radius has no effect on an environment camera"),
        ("fine.pbrt", &["--time-at", "1"], "--time-at has no effect: nothing in this scene moves"),
        ("fine.pbrt", &["--time-at", "noon"], "'--time-at <T>': expected a number"),
        (
            "fine.pbrt",
            &["--animate", "time-at=0..1", "--frames", "2", "--time-at", "1"],
            "--animate time-at and --time-at contradict each other",
        ),
        (
            "lenses.pbrt",
            &["--fov", "30"],
            "--fov has no effect on a realistic camera: its angle of view comes from",
        ),
        ("lenses.pbrt", &["--lens-radius", "1"], "its opening is aperturediameter in Camera"),
        ("lenses.pbrt", &["--screen-window", "-1 1 -1 1"], "to show a part of the picture, use --crop"),
        (
            "lenses.pbrt",
            &["--focal-distance", "0.1"],
            "the lens cannot focus on a distance of 0.1; the nearest distance is 0.225",
        ),
        (
            "lenses.pbrt",
            &["--animate", "focal-distance=5..0.1", "--frames", "2"],
            "the lens cannot focus on a distance of 0.1",
        ),
        ("fine.pbrt", &["--animate", "size=1..2", "--frames", "3"], "the parameters are fov, lens-radius,"),
        (
            "fine.pbrt",
            &["--animate", "fov=10-20", "--frames", "3"],
            "expected PARAMETER=A..B, as in fov=20..60",
        ),
        (
            "fine.pbrt",
            &["--animate", "fov=10..200", "--frames", "3"],
            "fov cannot be 200: the angle must be above 0",
        ),
        ("fine.pbrt", &["--animate", "fov=10..20"], "--frames <N>"),
        ("fine.pbrt", &["--animate", "focal-distance=1..2", "--frames", "3"], "has no effect on a pinhole"),
        ("fine.pbrt", &["--turntable", "0"], "expected a whole number from 1"),
        (
            "fine.pbrt",
            &["--lens-radius", "1", "--focus", "0.5,0.5", "--focal-distance", "3"],
            "'--focus <X,Y>' cannot be used with '--focal-distance <D>'",
        ),
        (
            "fine.pbrt",
            &[
                "--lens-radius",
                "1",
                "--animate",
                "focal-distance=2..3",
                "--frames",
                "2",
                "--focus",
                "0.5,0.5",
            ],
            "--animate focal-distance and --focus contradict each other",
        ),
        (
            "fine.pbrt",
            &["--animate", "fov=20..30", "--frames", "2", "--fov", "40"],
            "--animate fov and --fov contradict each other",
        ),
        ("none/fine.pbrt", &["--watch"], "cannot watch none/fine.pbrt: there is no folder none"),
        (
            "fine.pbrt",
            &["--animate", "eye.z=0..1", "--frames", "2"],
            "eye.z at 0: the eye and the target of LookAt are the same point",
        ),
    ] {
        let run = folder.run(&[&["render", scene], arguments].concat());
        assert!(run.status == 2 && run.err.contains(message), "{arguments:?}: {}", run.err);
    }
    // Other commands refuse them too.
    for command in ["check", "inspect"] {
        let run = folder.run(&[command, "--fov", "20", "ortho.pbrt"]);
        assert!(
            run.status == 2 && run.err.contains("no effect on an orthographic"),
            "{command}: {}",
            run.err
        );
    }
    // The advice of the format applies.
    let run = folder.run(&["render", "fine.pbrt", "--lens-radius", "1"]);
    assert!(run.status == 0 && run.err.contains("the lens has no focaldistance"), "{}", run.err);
    let run = folder.run(&["render", "fine.pbrt", "--fov", ".785"]);
    assert!(run.status == 0 && run.err.contains("this looks like radians"), "{}", run.err);
}

/// Each picture is the one of its value alone, bit for bit.
#[test]
fn pictures_of_an_animation_are_those_of_their_values() {
    let folder = Folder::new();
    for (animation, option, values) in [
        ("fov=20..60", "--fov", ["20", "40", "60"]),
        ("lens-radius=0..0.5", "--lens-radius", ["0", "0.25", "0.5"]),
        ("focal-distance=5..3", "--focal-distance", ["5", "4", "3"]),
        ("eye.x=-1..1", "--lookat", ["-1 0 -4 0 0 0 0 1 0", "0 0 -4 0 0 0 0 1 0", "1 0 -4 0 0 0 0 1 0"]),
        ("look.y=1..2", "--lookat", ["0 0 -4 0 1 0 0 1 0", "0 0 -4 0 1.5 0 0 1 0", "0 0 -4 0 2 0 0 1 0"]),
    ] {
        let lens: &[&str] = match option {
            "--focal-distance" => &["--lens-radius", ".25"],
            "--lens-radius" => &["--focal-distance", "3"],
            _ => &[],
        };
        // A pinhole has no distance of focus.
        let still = |value: &str| if option == "--lens-radius" && value == "0" { &[][..] } else { lens };
        let arguments = ["render", "fine.pbrt", "-o", "a.exr", "--animate", animation, "--frames", "3"];
        let run = folder.run(&[&arguments[..], lens].concat());
        assert_eq!(run.status, 0, "{}", run.err);
        for (number, value) in values.into_iter().enumerate() {
            let frame = Image::read(&folder.path(&format!("a.{:04}.exr", number + 1))).unwrap();
            let alone = folder.picture(&[&[option, value], still(value)].concat());
            assert_eq!(frame.channels, alone.channels, "{animation} {value}");
        }
    }
    assert!(!folder.path("a.exr").exists() && !folder.path("a.0004.exr").exists());
    let run = folder.run(&["render", "fine.pbrt", "--animate", "fov=20..60", "--frames", "2", "--json"]);
    let line = &json_lines(&run)[0];
    let files: Vec<&str> =
        line["frames"].as_array().unwrap().iter().map(|it| it["file"].as_str().unwrap()).collect();
    assert_eq!(files, ["fine.0001.exr", "fine.0002.exr"]);
    assert!(line["picture"].is_null());
}

/// Instants of a scene that moves: one alone, or many.
#[test]
fn a_scene_that_moves_is_rendered_at_instants() {
    let folder = Folder::new();
    let moving = "ActiveTransform EndTime Translate 1 0 0 ActiveTransform All TransformTimes 0 4 Camera \"perspective\"";
    folder.write("moving.pbrt", &with_camera(moving));
    let picture = |arguments: &[&str], file: &str| {
        let run = folder.run(&[&["render", "moving.pbrt", "--force"], arguments].concat());
        assert_eq!(run.status, 0, "{}", run.err);
        Image::read(&folder.path(file)).unwrap().channels
    };
    let animate = ["--animate", "time-at=0..4", "--frames", "3", "-o", "a.exr"];
    let last = picture(&animate, "a.0003.exr");
    let middle = Image::read(&folder.path("a.0002.exr")).unwrap().channels;
    assert_eq!(middle, picture(&["--time-at", "2", "-o", "b.exr"], "b.exr"));
    assert_eq!(last, picture(&["--time-at", "4", "-o", "b.exr"], "b.exr"));
    // The shutter is open for a quarter of the motion.
    let open = picture(&["-o", "b.exr"], "b.exr");
    assert!(open != middle && open != last);
}

#[test]
fn a_turntable_turns_around_the_target_of_look_at() {
    let folder = Folder::new();
    let turned = |scene: &str, count: &str| {
        let run = folder.run(&["render", scene, "-o", "t.exr", "--turntable", count]);
        assert_eq!(run.status, 0, "{}", run.err);
        let count: u32 = count.parse().unwrap();
        let frame = |number: u32| Image::read(&folder.path(&format!("t.{number:04}.exr"))).unwrap().channels;
        (1..=count).map(frame).collect::<Vec<_>>()
    };
    let frames = turned("fine.pbrt", "4");
    assert_eq!(frames[0], folder.picture(&[]).channels);
    // A quarter about y takes -z to -x.
    for (frame, eye) in [(1, "-4 0 0"), (2, "0 0 4"), (3, "4 0 0")] {
        let alone = folder.picture(&["--lookat", &format!("{eye} 0 0 0 0 1 0")]);
        assert_eq!(frames[frame], alone.channels, "{eye}");
    }
    // What stands before LookAt stays: a mirrored picture stays mirrored.
    folder.write("mirrored.pbrt", &format!("Scale -1 1 1 {FINE}"));
    folder.write("behind.pbrt", &format!("Scale -1 1 1 {}", FINE.replace("0 0 -4", "0 0 4")));
    assert_eq!(folder.run(&["render", "behind.pbrt", "-o", "b.exr"]).status, 0);
    assert_eq!(turned("mirrored.pbrt", "2")[1], Image::read(&folder.path("b.exr")).unwrap().channels);
    // Without LookAt, around the middle of the shapes.
    folder.write("moved.pbrt", &FINE.replace("LookAt 0 0 -4  0 0 0  0 1 0", "Translate .5 0 4"));
    folder.write(
        "back.pbrt",
        &FINE.replace("LookAt 0 0 -4  0 0 0  0 1 0", "Translate .5 0 4 Rotate 180 0 1 0"),
    );
    assert_eq!(folder.run(&["render", "back.pbrt", "-o", "b.exr"]).status, 0);
    let (found, expected) = (turned("moved.pbrt", "2"), Image::read(&folder.path("b.exr")).unwrap());
    let differ =
        |a: &Channel, b: &Channel| a.samples.iter().zip(&b.samples).any(|(a, b)| (a - b).abs() > 1e-4);
    assert!(found[1].iter().zip(&expected.channels).all(|(a, b)| !differ(a, b)));
    let world = "WorldBegin CoordSysTransform \"camera\"";
    folder.write("carried.pbrt", &FINE.replace("WorldBegin", world));
    let run = folder.run(&["render", "carried.pbrt", "--turntable", "2"]);
    assert!(run.status == 2 && run.err.contains("render single pictures with --lookat"), "{}", run.err);
}

#[test]
fn several_scenes_are_rendered_one_by_one() {
    let folder = Folder::new();
    folder.write("other.pbrt", &FINE.replace("fine.exr", "other.exr"));
    let run = folder.run(&["render", "fine.pbrt", "wrong.pbrt", "other.pbrt", "--json"]);
    // Both write fine.exr.
    let message = "fine.pbrt and wrong.pbrt both write fine.exr: change the filename of one Film, or render them one by one with -o";
    assert_eq!((run.status, run.err), (2, format!("error: {message}\n")));
    assert!(!folder.path("fine.exr").exists());
    folder.write("wrong.pbrt", &FINE.replace("fine.exr", "wrong.exr").replace("Shape", "Shap"));
    let run = folder.run(&["render", "fine.pbrt", "wrong.pbrt", "other.pbrt", "--json"]);
    let lines = json_lines(&run);
    assert_eq!((run.status, lines.len()), (1, 3));
    assert!(lines[0]["picture"]["file"] == "fine.exr" && lines[2]["picture"]["file"] == "other.exr");
    assert!(lines[1]["picture"].is_null() && folder.path("other.exr").exists());
    let run = folder.run(&["render", "fine.pbrt", "nothing.pbrt", "other.pbrt"]);
    assert!(run.status == 2 && run.err.contains("other.exr: 32 x 24 pixels"), "{}", run.err);

    let run = folder.run(&["render", "fine.pbrt", "other.pbrt", "-o", "a.exr"]);
    assert!(run.status == 2 && run.err.contains("name a folder, or remove -o"), "{}", run.err);
    // The folder is created, with its parents, once everything else is right.
    let run = folder.run(&["render", "fine.pbrt", "fine.pbrt", "-o", "new/out"]);
    assert!(run.status == 2 && !folder.path("new").exists(), "{}", run.err);
    let run = folder.run(&["render", "fine.pbrt", "other.pbrt", "-o", "new/out", "--quick"]);
    assert!(run.status == 0 && folder.path("new/out/other.quick.exr").exists(), "{}", run.err);
    std::fs::create_dir(folder.path("out")).unwrap();
    let run = folder.run(&["render", "fine.pbrt", "other.pbrt", "-o", "out", "--quick"]);
    assert_eq!(run.status, 0, "{}", run.err);
    assert!(folder.path("out/fine.quick.exr").exists() && folder.path("out/other.quick.exr").exists());
    let run = folder.run(&["render", "fine.pbrt", "-"]);
    assert!(run.status == 2 && run.err.contains("standard input can be read only once"), "{}", run.err);
}

/// No picture of the command replaces a file that any scene of the command reads, even through a link.
#[cfg(unix)]
#[test]
fn several_scenes_keep_the_files_of_each_other() {
    let folder = Folder::new();
    assert_eq!(folder.run(&["render", "fine.pbrt"]).status, 0);
    std::fs::create_dir(folder.path("out")).unwrap();
    let textured = |picture: &str| {
        let texture =
            format!("WorldBegin Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"{picture}\"");
        FINE.replace("fine.exr", "other.exr").replace("WorldBegin", &texture)
    };
    let refused = |arguments: &[&str], file: &str| {
        let before = std::fs::read(folder.path(file)).unwrap();
        let run = folder.run(&[&["render", "--force"], arguments].concat());
        let message = format!("error: cannot write {file}: this file is an input; choose another name\n");
        assert!(run.status == 2 && run.err.ends_with(&message), "{arguments:?}: {}", run.err);
        assert_eq!(std::fs::read(folder.path(file)).unwrap(), before);
    };
    std::fs::copy(folder.path("fine.exr"), folder.path("out/fine.exr")).unwrap();
    folder.write("other.pbrt", &textured("out/fine.exr"));
    refused(&["other.pbrt", "fine.pbrt", "-o", "out"], "out/fine.exr");
    refused(&["fine.pbrt", "other.pbrt", "-o", "out"], "out/fine.exr");
    // Nothing is rendered before that.
    assert!(!folder.path("out/other.exr").exists());
    // Another name of the same file.
    std::fs::hard_link(folder.path("out/fine.exr"), folder.path("link.exr")).unwrap();
    folder.write("other.pbrt", &textured("link.exr"));
    refused(&["other.pbrt", "fine.pbrt", "-o", "out"], "out/fine.exr");
    // The names of partial and of numbered pictures.
    for name in ["fine.partial.exr", "fine.0002.exr"] {
        std::fs::copy(folder.path("fine.exr"), folder.path(name)).unwrap();
    }
    folder.write("other.pbrt", &textured("fine.partial.exr"));
    refused(&["other.pbrt", "fine.pbrt"], "fine.partial.exr");
    folder.write("other.pbrt", &textured("fine.0002.exr"));
    refused(&["other.pbrt", "fine.pbrt", "--turntable", "2"], "fine.0002.exr");
    let run = folder.run(&["render", "other.pbrt", "fine.pbrt", "--force"]);
    assert_eq!(run.status, 0, "{}", run.err);
}

/// A pipe that is read twice would wait for a second writer.
#[cfg(unix)]
#[test]
fn pipes_are_read_once_and_only_as_scenes() {
    let folder = Folder::new();
    assert!(Command::new("mkfifo").arg(folder.path("pipe.pbrt")).status().unwrap().success());
    for (arguments, message) in [
        (&["render", "fine.pbrt", "pipe.pbrt"][..], "pipe.pbrt can be read only once: render it alone"),
        (&["render", "pipe.pbrt", "--watch"], "pipe.pbrt can be read only once: with --watch, name a file"),
        (&["view", "pipe.pbrt"], "cannot read pipe.pbrt: it is a pipe or a device, not a file"),
        (&["view", "/dev/zero"], "cannot read /dev/zero: it is a pipe or a device, not a file"),
        (
            &["view", "fine.pbrt", "--reference", "pipe.pbrt"],
            "cannot read pipe.pbrt: it is a pipe or a device, not a file",
        ),
    ] {
        let run = within_a_minute(&folder, arguments);
        assert_eq!((run.status, run.err), (2, format!("error: {message}\n")), "{arguments:?}");
    }
}

/// Ends a run that waits.
#[cfg(unix)]
fn within_a_minute(folder: &Folder, arguments: &[&str]) -> Run {
    let mut command = Command::new("timeout");
    command.args(["-s", "KILL", "60", env!("CARGO_BIN_EXE_lookat")]).args(arguments);
    Run::of(command.current_dir(folder.0.path()).output().unwrap())
}

/// Pictures that are finished stay; the one that is not is a partial picture.
#[cfg(unix)]
#[test]
fn an_interrupted_animation_keeps_its_finished_pictures() {
    let folder = Folder::new();
    let arguments = ["render", "fine.pbrt", "-o", "a.exr", "--turntable", "1000", "--spp", "256"];
    let child = folder.command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    while !folder.path("a.0003.exr").exists() {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let run = Run::of(child.wait_with_output().unwrap());
    assert_eq!(run.status, 130, "{}", run.err);
    assert!(!folder.path("a.1000.exr").exists());
    assert_eq!(Image::read(&folder.path("a.0002.exr")).unwrap().data_window.width, 32);
}

/// A lens of 50 mm and 6 mm thick, and its stop.
const SINGLE: &str = "50 6 1.5 20\n-60 5 1 20\n0 40 0 12\n";
const LENSES: &str = "Camera \"realistic\" \"string lensfile\" \"single.dat\" \"float aperturediameter\" 8";

/// As a thin lens: the distance of what is in the middle is measured from the film.
#[test]
fn a_system_of_lenses_is_focused_too() {
    let folder = Folder::new();
    folder.write("single.dat", SINGLE);
    folder.write("lenses.pbrt", &with_camera(LENSES));
    let render = |arguments: &[&str]| {
        let run =
            folder.run(&[&["render", "lenses.pbrt", "-o", "picture.exr", "--force"], arguments].concat());
        let picture = Image::read(&folder.path("picture.exr")).unwrap();
        (run.status, run.err, picture.channels)
    };
    let (status, err, focused) = render(&["--focus", "0.5,0.5"]);
    let line = "focused on pixel 16, 12; to keep this, write \"float focusdistance\" 3 in Camera\n";
    assert!(status == 0 && err.starts_with(line), "{err}");
    assert_eq!(focused, render(&["--focal-distance", "3"]).2);
    folder.write("lenses.pbrt", &with_camera(&format!("{LENSES} \"float focusdistance\" 3")));
    assert_eq!(focused, render(&[]).2);
    // The first picture of a turntable is the scene's, the second shows the other side.
    let run = folder.run(&["render", "lenses.pbrt", "-o", "around.exr", "--turntable", "2"]);
    assert_eq!(run.status, 0, "{}", run.err);
    assert_eq!(Image::read(&folder.path("around.0001.exr")).unwrap().channels, focused);
    assert!(folder.path("around.0002.exr").exists());
}

/// A sphere of radius 1, seen from a distance of 4.
#[test]
fn the_lens_is_focused_on_the_point_that_is_named() {
    let folder = Folder::new();
    let render = |arguments: &[&str]| {
        let run = folder.run(&[&["render", "fine.pbrt", "-o", "picture.exr", "--force"], arguments].concat());
        (run.status, run.err)
    };
    let (status, err) = render(&["--lens-radius", "0.2", "--focus", "0.5,0.5"]);
    let line = "focused on pixel 16, 12; to keep this, write \"float focaldistance\" 3 in Camera\n";
    assert!(status == 0 && err.starts_with(line), "{err}");
    let focused = Image::read(&folder.path("picture.exr")).unwrap();
    let set = folder.picture(&["--lens-radius", "0.2", "--focal-distance", "3"]);
    assert_eq!(focused.channels, set.channels);
    // The middle of the pixel is beside the middle of the sphere.
    let (_, err) = render(&["--lens-radius", "0.2", "--focus", "16,12"]);
    assert!(err.contains("\"float focaldistance\" 3.00"), "{err}");
    let metadata: Value = serde_json::from_str(set.metadata.as_deref().unwrap()).unwrap();
    let camera = &metadata["camera"];
    let read = ["fov", "lensradius", "focaldistance"].map(|name| camera[name].as_f64().unwrap());
    assert_eq!(read, [40.0, 0.2, 3.0]);
    assert_eq!(camera["world_from_camera"][11], -4.0);
    for (arguments, message) in [
        (&["--focus", "0.5,0.5"][..], "--focus needs a lens"),
        (&["--focus", "0,0", "--lens-radius", "1"], "there is nothing to focus on at pixel 0, 0"),
        (&["--focus", "99,0", "--lens-radius", "1"], "the picture has only 32 x 24 pixels"),
    ] {
        let (status, err) = render(arguments);
        assert!(status == 2 && err.contains(message), "{err}");
    }
}

#[test]
fn check_looks_from_elsewhere() {
    let folder = Folder::new();
    let check = |arguments: &[&str]| folder.run(&[&["check", "--view", "fine.pbrt"], arguments].concat());
    assert_eq!(check(&[]).out, "");
    assert!(!check(&[]).err.contains("warning"));
    let inside = check(&["--lookat", "0 0 0  0 0 1  0 1 0"]);
    assert!(inside.status == 0 && inside.err.contains("the camera is inside this shape"), "{}", inside.err);
    let idle = check(&["--focal-distance", "3"]);
    assert!(idle.status == 2 && idle.err.contains("has no effect on a pinhole"), "{}", idle.err);
}
