//! What the program says of scenes, and what becomes of those that are in error.

use super::*;

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

/// A file is missing at any speed. What is in it is not read with `--fast`.
#[test]
fn a_fast_check_reads_no_contents_of_meshes_and_pictures() {
    let folder = Folder::new();
    let cut = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 0 0";
    folder.write("cut.ply", cut);
    folder.write("cut.png", "\u{89}PNG");
    let world = |more: &str| FINE.replace("WorldEnd", &format!("{more}\nWorldEnd"));
    let mesh = "Shape \"plymesh\" \"string filename\" \"cut.ply\"";
    let light = "LightSource \"infinite\" \"string mapname\" \"cut.png\"";
    let texture = "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"cut.png\"";
    for (more, error) in [
        (mesh, "the header declares 3 vertices, but the file has only 11 bytes"),
        (light, "cut.png"),
        (texture, "cut.png"),
    ] {
        folder.write("cut.pbrt", &world(more));
        let run = folder.run(&["check", "cut.pbrt"]);
        assert!(run.status == 1 && run.err.contains(error), "{}", run.err);
        let run = folder.run(&["check", "--fast", "cut.pbrt"]);
        let fine = "cut.pbrt: fine; --fast skipped the contents of 1 mesh or picture\n";
        assert_eq!((run.status, &run.err[..]), (0, fine));
        assert_eq!(folder.run(&["check", "--fast", "--quiet", "cut.pbrt"]).err, "");
        assert_eq!(json_lines(&folder.run(&["check", "--fast", "--json", "cut.pbrt"]))[0]["unread"], 1);
        folder.write("cut.pbrt", &world(&more.replace("cut.p", "gone.p")));
        let run = folder.run(&["check", "--fast", "cut.pbrt"]);
        assert!(run.status == 1 && run.err.contains("cannot read gone.p"), "{}", run.err);
    }
    // What a header or a name decides is the same at any speed.
    let check_both = |scene: &str, error: &str| {
        folder.write("cut.pbrt", scene);
        let [whole, fast] =
            [&[][..], &["--fast"]].map(|more| folder.run(&[&["check", "cut.pbrt"], more].concat()));
        assert!(fast.status == 1 && fast.err.contains(error), "{}", fast.err);
        let skipped = "cut.pbrt: --fast skipped the contents of 1 mesh or picture\n";
        assert_eq!(fast.err, whole.err + skipped);
    };
    for (before, after, error) in [
        ("format", "farmat", "line 2: unknown keyword `farmat`"),
        ("property float z\n", "", "the vertices have no number `z`"),
        ("face 1", "face 0", "the PLY file has no faces"),
        ("uchar int", "uchar float", "the list `vertex_indices` of the faces has no integer type"),
    ] {
        folder.write("cut.ply", &cut.replace(before, after));
        check_both(&world(mesh), error);
    }
    std::fs::write(folder.path("cut.ply"), b"\x1f\x8b\x08\x00damaged").unwrap();
    check_both(&world(mesh), "the gzip data is damaged or cut short");
    folder.write("cut.gif", "GIF89a");
    check_both(&world(&texture.replace("png", "gif")), "lookat reads exr, pfm, png, tga, jpg and hdr");
    assert_eq!(folder.run(&["check", "--fast", "fine.pbrt"]).err, "fine.pbrt: fine\n");
}

/// A note is information: it is counted apart and fails nothing.
#[test]
fn notes_never_fail() {
    let folder = Folder::new();
    let noted = FINE.replace("\"sobol\"", "\"02sequence\"").replace("fov\" 40", "fov\" 1");
    folder.write("notes.pbrt", &noted);
    folder.write("both.pbrt", &noted.replace("Shape \"sphere\"", "Shape \"sphere\" \"float raduis\" 2"));
    let run = folder.run(&["check", "--strict", "notes.pbrt"]);
    assert_eq!(run.status, 0, "{}", run.err);
    assert!(
        run.err.contains("note: lookat renders Sampler \"02sequence\"")
            && run.err.ends_with("notes.pbrt: 2 notes\n")
    );
    assert!(folder.run(&["check", "both.pbrt"]).err.ends_with("both.pbrt: 1 warning, 2 notes\n"));
    let strict = folder.run(&["check", "--strict", "both.pbrt"]);
    assert_eq!(strict.status, 1);
    assert!(strict.err.ends_with("both.pbrt: 1 error, 2 notes\n"), "{}", strict.err);
    assert_eq!(folder.run(&["render", "--strict", "--quiet", "notes.pbrt"]).err, "");
    let told = &json_lines(&folder.run(&["check", "--json", "notes.pbrt"]))[0]["diagnostics"];
    assert!(told.as_array().unwrap().iter().all(|told| told["severity"] == "note"), "{told}");
}

/// One cause is one message, with its other places; JSON has all of them.
#[test]
fn one_cause_is_one_message() {
    let folder = Folder::new();
    let shapes: String =
        (0..20).map(|i| format!("Shape \"plymesh\" \"string filename\" \"gone/{i}/a.ply\"\n")).collect();
    folder.write("gone.pbrt", &FINE.replace("Shape \"sphere\"\n", &shapes));
    let run = folder.run(&["check", "gone.pbrt"]);
    assert_eq!(run.err.matches("error:").count(), 1, "{}", run.err);
    for part in [
        "error: there is no folder gone\n",
        "needed for gone/0/a.ply",
        "also at 19 other places: gone.pbrt:10:35, ",
        ", and 9 more\n",
        "gone.pbrt: 1 error\n",
    ] {
        assert!(run.err.contains(part), "no {part:?} in\n{}", run.err);
    }
    let told = &json_lines(&folder.run(&["check", "--json", "gone.pbrt"]))[0]["diagnostics"][0];
    assert_eq!(told["places"].as_array().unwrap().len(), 19);
    assert_eq!(
        (told["places"][18]["line"].as_u64(), told["places"][18]["column"].as_u64()),
        (Some(28), Some(35))
    );
}

#[test]
fn quiet_shows_errors_only() {
    let folder = Folder::new();
    for quiet in ["-q", "--quiet"] {
        let run = folder.run(&["check", quiet, "fine.pbrt", "warns.pbrt", "wrong.pbrt"]);
        assert_eq!(run.status, 1);
        assert!(run.err.starts_with("error: ") && run.err.ends_with("wrong.pbrt: 2 errors\n"), "{}", run.err);
        assert!(!run.err.contains("warn") && !run.err.contains("fine.pbrt"), "{}", run.err);
    }
    assert_eq!(folder.run(&["check", "-q", "fine.pbrt", "warns.pbrt"]).err, "");
}

/// A tip is one that works.
#[test]
fn tips_for_wrong_options_hold() {
    let folder = Folder::new();
    folder.write("-b.exr", "");
    for (arguments, tip) in [
        ("render --sp 3 fine.pbrt", "a similar argument exists: '--spp'"),
        ("render -spp 4 fine.pbrt", "options of several letters begin with two dashes: '--spp'"),
        ("render -out a.exr fine.pbrt", "options of several letters begin with two dashes: '--output'"),
        ("chart.pbrt", "to render the scene, write 'lookat render chart.pbrt'"),
        ("fine.pbrt --spp 4", "to render the scene, write 'lookat render fine.pbrt --spp 4'"),
        ("check --quick fine.pbrt", "'--quick' is an option of 'lookat render'"),
        ("check fine.pbrt --crop 0 1 0 1", "'--crop' is an option of 'lookat render'"),
        ("render fine.pbrt -o -x.exr", "to give '-x.exr' as the value of '-o', write '-o=-x.exr'"),
        ("render fine.pbrt --threads -x", "to give '-x' as the value of '--threads', write '--threads=-x'"),
        ("compare fine.pbrt -b.exr", "a file name that begins with a dash is written './-b.exr'"),
    ] {
        let run = folder.run(&arguments.split(' ').collect::<Vec<_>>());
        assert!(run.status == 2 && run.err.contains(tip), "{arguments}: {}", run.err);
        assert_eq!(run.err.matches("tip:").count(), 1, "{arguments}: {}", run.err);
    }
    // Where nothing is known, nothing is said.
    for arguments in ["check --verbose fine.pbrt", "render fine.pbrt -x", "render fine.pbrt warns.pbrt"] {
        let run = folder.run(&arguments.split(' ').collect::<Vec<_>>());
        assert!(run.status == 2 && !run.err.contains("tip:"), "{arguments}: {}", run.err);
    }
    assert_eq!(folder.run(&["render", "fine.pbrt", "-o=-x.exr"]).status, 0);
}

/// Whoever looks away from everything is told so; inside a closed sphere there is something to see, but no light.
#[test]
fn black_pictures_are_told() {
    let folder = Folder::new();
    let without_sky = FINE.replace("LightSource \"infinite\" \"rgb L\" [.2 .2 .2]\n", "");
    folder.write("away.pbrt", &without_sky.replace("0 0 -4  0 0 0", "0 0 -4  0 0 -9"));
    folder.write("inside.pbrt", &without_sky.replace("0 0 -4  0 0 0", "0 0 0  0 0 9"));
    let said = |scene, args: &[&str]| folder.run(&[&["render", scene, "-o", "a.exr"], args].concat());
    assert!(said("away.pbrt", &[]).err.contains("no camera ray hits a surface"));
    let black = "WorldBegin Material \"matte\" \"rgb Kd\" [0 0 0]";
    folder.write("black.pbrt", &without_sky.replace("WorldBegin", black));
    assert!(said("inside.pbrt", &[]).err.contains("no visible surface receives light"));
    assert!(said("black.pbrt", &[]).err.contains("the black material at black.pbrt:6:21; give it a color"));
    assert!(!said("fine.pbrt", &[]).err.contains("all black"));
    assert!(said("away.pbrt", &["--quiet"]).err.contains("the picture is all black"));
    assert_eq!(said("fine.pbrt", &["--quiet"]).err, "");
    for (scene, black) in [("away.pbrt", true), ("inside.pbrt", true), ("fine.pbrt", false)] {
        assert_eq!(json_lines(&said(scene, &["--json"]))[0]["picture"]["black"], black);
    }
}

/// The line after the summary names the filter, not the light or an exposure.
#[test]
fn pictures_without_samples_in_the_filter_blame_the_filter() {
    let folder = Folder::new();
    let narrow = |width| {
        let filter =
            format!("PixelFilter \"box\" \"float xwidth\" {width} \"float ywidth\" {width} WorldBegin");
        folder.write("narrow.pbrt", &FINE.replace("WorldBegin", &filter));
        let render = ["render", "narrow.pbrt", "-o", "a.exr", "--spp", "1"];
        (folder.run(&render).err, folder.run(&[&render[..], &["--quiet"]].concat()).err)
    };
    let filter =
        "the PixelFilter is narrower than the gaps between samples; set xwidth and ywidth to at least 0.5\n";
    let (told, quiet) = narrow(0.001);
    let black = format!("the picture is all black: {filter}");
    assert!(told.ends_with(&black) && quiet == black, "{told} {quiet}");
    // A few samples count; the picture is not too dark for that.
    let (told, quiet) = narrow(0.05);
    assert!(told.ends_with(filter) && !told.contains("--exposure"), "{told}");
    assert!(quiet.ends_with(&format!(" pixels are black: {filter}")), "{quiet}");
    let (told, quiet) = narrow(0.45);
    assert!(!told.contains("gaps between") && quiet.is_empty(), "{told} {quiet}");
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
            None => assert!(help.starts_with("lookat looks in the folder"), "{name}: {help}"),
        }
    }
}

#[test]
fn strict_makes_errors_of_warnings() {
    let folder = Folder::new();
    for command in ["check", "render"] {
        let run = folder.run(&[command, "warns.pbrt", "--strict"]);
        assert!(!run.err.contains("--keep-going"), "nothing has to be left out: {}", run.err);
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
        let run = folder.run(&["render", "a.pbrt", "--keep-going", "-o", "a.exr"]);
        assert_eq!(run.status, 0, "{}", run.err);
        std::fs::read(folder.path("a.exr")).unwrap()
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
    assert!(run.err.contains("warning: ") && run.err.contains("fine.exr: 32 x 24 pixels"), "{}", run.err);
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

/// However many warnings there are, errors are printed.
#[test]
fn warnings_do_not_hide_errors() {
    let folder = Folder::new();
    let warnings: String =
        (0..120).map(|k| format!("Shape \"sphere\" \"float slip{k}\" 1 ")).collect::<Vec<_>>().join("\n");
    folder.write("many.pbrt", &FINE.replace("Shape \"sphere\"", &format!("{warnings}\nShape \"nothing\"")));
    let err = folder.run(&["check", "many.pbrt"]).err;
    assert!(err.contains("error: unknown Shape \"nothing\""), "{err}");
    assert!(err.contains("... and 21 more messages; lookat check --json prints all"), "{err}");
    assert!(err.ends_with("many.pbrt: 1 error, 120 warnings\n"), "{err}");
}

/// Of a light, a part of which could not be read, nothing is seen; not what it would be without that part.
#[test]
fn lights_in_error_give_no_light() {
    let folder = Folder::new();
    let lamps = r#"AttributeBegin AreaLightSource "diffuse" "rgb L" [1 2] Shape "sphere" AttributeEnd
        LightSource "infinite" "rgb L" [1 2] LightSource "point" "color I" "much""#;
    let world = FINE.split_once("WorldBegin").unwrap().0;
    folder.write("lamps.pbrt", &format!("{world}WorldBegin {lamps} WorldEnd"));
    let run = folder.run(&["render", "lamps.pbrt", "-o", "a.exr", "--keep-going", "--json"]);
    let result = &json_lines(&run)[0];
    assert_eq!((run.status, &result["picture"]["black"]), (0, &true.into()), "{}", run.out);
}

/// Parts that scenes include, of the world or before it, are checked by themselves; but they are no scenes.
#[test]
fn parts_of_scenes_are_checked_and_not_rendered() {
    let folder = Folder::new();
    let run = |text: &str, command: &str| {
        folder.write("part.pbrt", text);
        folder.run(&[command, "part.pbrt"])
    };
    let camera = "LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\"";
    for (text, without) in [(camera, "WorldBegin"), ("Shape \"sphere\"", "Camera, Film or WorldBegin")] {
        let checked = run(text, "check");
        let note = format!("note: this file is a part of a scene: it has no {without}\n");
        assert!(checked.status == 0 && checked.err.starts_with(&note), "{}", checked.err);
        assert_eq!(run(text, "render").status, 1);
    }
    // What is wrong with them is told; and nothing at all is no part.
    for (text, error) in [
        ("Camera \"perspectve\"", "error: unknown Camera \"perspectve\""),
        ("# nothing", "error: the file has no WorldBegin"),
    ] {
        let checked = run(text, "check");
        assert!(checked.status == 1 && checked.err.contains(error), "{}", checked.err);
    }
}

/// The command moved to another program.
#[test]
fn a_folder_is_no_scene_and_an_empty_file_no_picture() {
    let folder = Folder::new();
    let run = folder.run(&["check", "."]);
    assert!(run.status == 2 && run.err.contains("name its files, as in ./*.pbrt"), "{}", run.err);
    folder.write("empty.exr", "");
    let run = folder.run(&["convert", "empty.exr", "a.png"]);
    assert_eq!((run.status, &run.err[..]), (2, "error: cannot read empty.exr: the file is empty\n"));
    let run = folder.run(&["explain", "glow"]);
    assert_eq!(run.err, "error: nothing is called \"glow\": `lookat explain` lists everything\n");
}

#[test]
fn bench_has_a_new_place() {
    let run = Folder::new().run(&["bench", "--only", "tracing"]);
    assert!(run.status == 2 && run.err.contains("cargo run --release -p lookat-lab -- bench"), "{}", run.err);
}

/// Where a number is due, what else is given is refused, with the numbers that serve.
#[test]
fn numbers_of_options_have_their_ranges_told() {
    let folder = Folder::new();
    for (arguments, range) in [
        (["render", "fine.pbrt", "--threads", "-1"], "from 1 to 1024"),
        (["render", "fine.pbrt", "--spp", "-4"], "from 1 to 1073741824"),
        (["chart", "fine.pbrt", "--seeds", "4"], "from 8 to 1000"),
        (["chart", "fine.pbrt", "--spp", "-4"], "a power of two"),
    ] {
        let run = folder.run(&arguments);
        assert!(run.status == 2 && run.err.contains(range), "{}", run.err);
    }
}
