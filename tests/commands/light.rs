//! The line about light, and the exposure and tone curve of 8-bit files.

use super::*;

/// `FINE` with the light of its lamp and of its sky times a factor.
fn with_light(factor: f64) -> String {
    let (lamp, sky) = (30.0 * factor, 0.2 * factor);
    let scene = FINE.replace("[30 30 30]", &format!("[{lamp} {lamp} {lamp}]"));
    scene.replace("[.2 .2 .2]", &format!("[{sky} {sky} {sky}]"))
}

/// The advised stops after rendering to this file.
fn advised(folder: &Folder, scene: &str, arguments: &[&str]) -> Option<i32> {
    folder.write("a.pbrt", scene);
    let run = folder.run(&[&["render", "a.pbrt", "--force"], arguments].concat());
    assert_eq!(run.status, 0, "{}", run.err);
    let (_, stops) =
        run.err.split_once("try --exposure ").or_else(|| run.err.split_once("a.png --exposure "))?;
    Some(stops.trim().parse().unwrap())
}

#[test]
fn the_line_tells_how_bright_the_picture_is() {
    let folder = Folder::new();
    let line = |run: &Run| run.err.lines().find(|line| line.starts_with("light: ")).map(String::from);
    let run = folder.run(&["render", "fine.pbrt", "-o", "a.exr"]);
    let light = line(&run).unwrap();
    assert!(light.starts_with("light: median 0.2, largest ") && run.err.lines().count() == 2, "{}", run.err);
    assert!(light.contains("; 0 % of pixels black, 0 % clip in an 8-bit file"), "{light}");
    assert_eq!(line(&folder.run(&["render", "fine.pbrt", "-o", "a.exr", "--quiet"])), None);
    let run = folder.run(&["render", "fine.pbrt", "-o", "a.png", "--json", "--exposure", "3"]);
    let light = &json_lines(&run)[0]["picture"]["light"];
    let number = |name: &str| light[name].as_f64().unwrap();
    assert!((number("median") - 0.2).abs() < 1e-6 && number("largest") > 0.2 && number("largest") < 2.0);
    assert!(number("clipped") > 0.9 && number("black") == 0.0 && number("exposure") == 3.0, "{light}");
    assert_eq!(number("advised_exposure"), 0.0);
}

/// A lamp a thousand times too far away, and one that clips half of the picture.
#[test]
fn pictures_that_show_nothing_name_the_exposure_that_shows_them() {
    let folder = Folder::new();
    let far = FINE.replace("[3 4 -5]", "[3000 4000 -5000]").replace("[.2 .2 .2]", "[0 0 0]");
    let stops = advised(&folder, &far, &["-o", "a.png"]).unwrap();
    assert!((15..25).contains(&stops), "{stops}");
    // The command of an EXR file does what it says.
    assert_eq!(advised(&folder, &far, &["-o", "a.exr"]), Some(stops));
    let run = folder.run(&["convert", "a.exr", "a.png", "--force", "--exposure", &stops.to_string()]);
    let brightest =
        Image::read(&folder.path("a.png")).unwrap().rgb().unwrap().concat().into_iter().fold(0.0, f32::max);
    assert!(run.status == 0 && brightest > 0.3 && !run.err.contains("--exposure"), "{brightest} {}", run.err);
    for exposure in [&stops.to_string()[..], "auto"] {
        assert_eq!(advised(&folder, &far, &["-o", "a.png", "--exposure", exposure]), None);
    }
    let glare = FINE.replace("WorldBegin", "WorldBegin AttributeBegin Translate -5 0 0 AreaLightSource \"diffuse\" \"rgb L\" [90 90 90] Shape \"trianglemesh\" \"point P\" [0 -9 2  5 -9 2  5 9 2  0 9 2] \"integer indices\" [0 2 1 0 3 2] \"bool twosided\" \"true\" AttributeEnd");
    let stops = advised(&folder, &glare, &["-o", "a.png"]).unwrap();
    assert!((-8..-4).contains(&stops), "{stops}");
    assert_eq!(advised(&folder, &glare, &["-o", "a.png", "--exposure", "auto"]), None);
    // Neither a fine picture nor a black one.
    assert_eq!(advised(&folder, FINE, &["-o", "a.png"]), None);
    assert_eq!(advised(&folder, &with_light(0.0), &["-o", "a.png"]), None);
}

/// One stop more doubles the light in 8-bit files. Linear files stay as they are.
#[test]
fn exposure_is_light() {
    let folder = Folder::new();
    folder.write("double.pbrt", &with_light(2.0));
    for file in ["a.png", "a.tga"] {
        let bytes = |scene: &str, exposure: &str| {
            let run = folder.run(&["render", scene, "--force", "-o", file, "--exposure", exposure]);
            assert_eq!(run.status, 0, "{}", run.err);
            Image::read(&folder.path(file)).unwrap().rgb()
        };
        assert!(bytes("fine.pbrt", "1") == bytes("double.pbrt", "0"));
        assert!(bytes("double.pbrt", "-1") == bytes("fine.pbrt", "0"));
        assert!(bytes("fine.pbrt", "0") != bytes("fine.pbrt", "1"));
    }
    let plain = folder.picture(&[]);
    for file in ["b.exr", "b.pfm"] {
        let run = folder.run(&["render", "fine.pbrt", "-o", file, "--exposure", "2", "--tone", "aces"]);
        let note = format!(
            "{file}: --exposure and --tone change only .png and .tga files; this file stays linear\n"
        );
        assert!(run.err.starts_with(&note), "{}", run.err);
        assert!(Image::read(&folder.path(file)).unwrap().rgb() == plain.rgb());
    }
}

#[test]
fn metadata_tells_exposure_and_curve() {
    let folder = Folder::new();
    let metadata = |arguments: &[&str]| -> Value {
        let run = folder.run(&[&["render", "fine.pbrt", "-o", "a.png"], arguments].concat());
        assert_eq!(run.status, 0, "{}", run.err);
        serde_json::from_str(&Image::read(&folder.path("a.png")).unwrap().metadata.unwrap()).unwrap()
    };
    let told = metadata(&["--exposure", "-1.5", "--tone", "neutral"]);
    assert_eq!((&told["exposure"], &told["tone"]), (&(-1.5).into(), &"neutral".into()));
    assert_eq!((&told["program"], &told["samples_per_pixel"]), (&"lookat".into(), &4.0.into()));
    let plain = metadata(&["--tone", "none"]);
    assert!(plain["exposure"].is_null() && plain["tone"].is_null());
}

#[test]
fn exposures_and_curves_that_do_not_exist_are_refused() {
    let folder = Folder::new();
    for (arguments, message) in [
        (["--exposure", "bright"], "expected a number from -100 to 100, or auto"),
        (["--exposure", "101"], "expected a number from -100 to 100, or auto"),
        (["--tone", "filmic"], "the tone curves are none, reinhard, aces, neutral"),
    ] {
        let run = folder.run(&[&["render", "fine.pbrt"], &arguments[..]].concat());
        assert!(run.status == 2 && run.err.contains(message), "{arguments:?}: {}", run.err);
    }
}
