//! Looking closely: layers, the error map, references and saved pictures of `lookat view`, without a browser.

use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;

use crate::viewer::{Content, Page, Viewer};
use lookat_image::Image;
use serde_json::{Value, json};

/// The scene of the server's tests, with more samples.
static SCENE: LazyLock<String> =
    LazyLock::new(|| crate::server::SCENE.replace("pixelsamples\" 8", "pixelsamples\" 64"));

fn lookat(arguments: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_lookat")).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// Renders the scene of a viewer into a file beside it.
fn render(viewer: &Viewer, name: &str, arguments: &[&str]) -> String {
    let file = viewer.folder.path().join(name).display().to_string();
    let scene = viewer.scene.display().to_string();
    let (status, _, errors) = lookat(&[&["render", &scene, "--force", "-o", &file], arguments].concat());
    assert_eq!(status, 0, "{errors}");
    file
}

fn compared(page: &mut Page) -> Value {
    page.news("compared", |_| true)
}

#[test]
fn saved_pictures_have_the_bytes_of_render() {
    let viewer = Viewer::start(&SCENE);
    let mut page = viewer.page();
    page.finished();
    for name in ["picture.exr", "picture.png"] {
        let file = render(&viewer, name, &[]);
        let answer = viewer.get_bytes(name);
        assert!(answer.starts_with(b"HTTP/1.1 200 OK\r\n"), "{name}");
        assert!(answer.ends_with(&std::fs::read(file).unwrap()), "{name}");
    }
    page.request(&json!({"type": "errors", "isOn": true}));
    page.news("looking", |looking| looking["hasErrors"] == true);
    page.finished();
    let file = render(&viewer, "picture.exr", &["--error-layers"]);
    assert!(viewer.get_bytes("picture.exr").ends_with(&std::fs::read(file).unwrap()));
    // While there is no finished picture, there is none to save.
    viewer.write(&SCENE.replace(" 64", " 1000000"));
    page.picture(|picture| picture.content == Content::Growing);
    assert!(viewer.get("picture.exr").starts_with("HTTP/1.1 404"));
}

#[test]
fn layers_are_those_of_render() {
    let viewer = Viewer::start(&SCENE);
    let names = ["depth", "position", "normal", "shading-normal", "uv", "albedo", "shape", "material"];
    let file = render(&viewer, "layers.exr", &["--layers", &names.join(",")]);
    let expected = Image::read(Path::new(&file)).unwrap();
    let mut page = viewer.page();
    page.finished();
    let channels: [&[&str]; 8] = [
        &["Z"],
        &["P.X", "P.Y", "P.Z"],
        &["N.X", "N.Y", "N.Z"],
        &["Ns.X", "Ns.Y", "Ns.Z"],
        &["uv.U", "uv.V"],
        &["albedo.R", "albedo.G", "albedo.B"],
        &["shape.I"],
        &["material.I"],
    ];
    for (number, channels) in channels.iter().enumerate() {
        page.request(&json!({"type": "layer", "layer": number}));
        let layer = page.picture(|picture| picture.content == Content::Layer && picture.size == [48, 32]);
        assert_eq!(layer.number as usize, number);
        for (axis, name) in channels.iter().enumerate() {
            let found: Vec<f32> = layer.pixels.iter().map(|pixel| pixel[axis]).collect();
            assert_eq!(found, expected.channel(name).unwrap(), "{name}");
        }
    }
    // The same at one place.
    page.request(&json!({"type": "values", "by": 3, "number": 4, "at": [24.5, 15.9]}));
    let values = page.news("values", |values| values["by"] == 3 && values["number"] == 4);
    let found: Vec<Vec<f32>> = serde_json::from_value(values["values"].clone()).unwrap();
    let pixel = |name: &&str| expected.channel(name).unwrap()[15 * 48 + 24];
    assert_eq!(found, channels.map(|names| names.iter().map(pixel).collect::<Vec<_>>()));
    page.request(&json!({"type": "values", "by": 3, "number": 5, "at": [-1, 1e300]}));
    assert_eq!(page.news("values", |values| values["number"] == 5)["values"], json!([]));
    // Another one that nobody has changes nothing.
    page.request(&json!({"type": "layer", "layer": 200}));
    page.request(&json!({"type": "layer", "layer": 0}));
    page.picture(|picture| picture.content == Content::Layer && picture.number == 0);
}

#[test]
fn layers_do_not_wait_for_a_long_picture() {
    let viewer = Viewer::start(&SCENE.replace(" 64", " 1000000"));
    let mut page = viewer.page();
    let before = page.picture(|picture| picture.content == Content::Growing && picture.done < picture.total);
    page.request(&json!({"type": "layer", "layer": 0}));
    page.picture(|picture| picture.content == Content::Layer && picture.size == [48, 32]);
    // It goes on where it was.
    let after = page.picture(|picture| picture.content == Content::Growing);
    assert!(after.generation == before.generation && after.done > before.done);
    // It also goes on while a page keeps it as the reference.
    page.request(&json!({"type": "reference", "from": "picture"}));
    let kept = page.picture(|picture| picture.content == Content::Reference);
    assert_eq!(kept.size, [48, 32]);
    let later = page.picture(|picture| picture.content == Content::Growing);
    assert!(later.generation == after.generation && later.done > after.done);
    // And while it answers other questions.
    page.request(&json!({"type": "pick", "by": 1, "number": 1, "at": [24, 16]}));
    assert_eq!(page.news("picked", |_| true)["hit"]["shape"], "sphere");
    assert!(page.edit(1, "show")["refused"].is_string());
    let last = page.picture(|picture| picture.content == Content::Growing);
    assert!(last.generation == later.generation && last.done > later.done);
    // What takes long is given up when the camera moves.
    page.request(&json!({"type": "layer", "layer": 2}));
    page.request(&json!({"type": "view", "by": 1, "number": 7, "camera": {"fov": 50}}));
    page.picture(|picture| picture.content == Content::Growing && picture.number == 7);
}

#[test]
fn the_error_map_grows_and_is_that_of_the_error_layers() {
    let viewer = Viewer::start(&SCENE);
    let mut page = viewer.page();
    let plain = page.finished();
    page.request(&json!({"type": "errors", "isOn": true}));
    let mut maps = 0;
    let (mut errors, mut finished) = (None, None);
    while finished.is_none() {
        let picture = page.picture(|_| true);
        match picture.content {
            Content::Errors => {
                maps += 1;
                errors = Some(picture);
            }
            Content::Finished => finished = Some(picture),
            _ => {}
        }
    }
    let file = render(&viewer, "errors.exr", &["--error-layers"]);
    let expected = Image::read(Path::new(&file)).unwrap();
    let (errors, finished) = (errors.unwrap(), finished.unwrap());
    assert!(finished.pixels == expected.rgb().unwrap() && finished.pixels != plain.pixels && maps > 0);
    let luminance = |[r, g, b]: [f32; 3]| 0.212_671 * r + 0.715_16 * g + 0.072_169 * b;
    let known = expected.errors().unwrap();
    let mut some = 0;
    for ((error, known), color) in errors.pixels.iter().zip(known).zip(&finished.pixels) {
        assert_eq!(error[2], known.replicates as f32);
        assert_eq!(error[1], luminance(known.standard_error));
        if luminance(*color) > 0.5 {
            some += 1;
            assert_eq!(error[0], error[1] / luminance(*color));
        }
    }
    assert!(some > 500);
    // Without it, the picture of `render` comes back.
    page.request(&json!({"type": "errors", "isOn": false}));
    page.news("looking", |looking| looking["hasErrors"] == false);
    assert!(page.finished().pixels == plain.pixels);
    viewer.write(&SCENE.replace(" 64", " 1"));
    page.finished();
    page.request(&json!({"type": "errors", "isOn": true}));
    let looking = page.news("looking", |looking| looking["errorsRefused"].is_string());
    assert_eq!(looking["hasErrors"], false);
    assert!(looking["errorsRefused"].as_str().unwrap().contains("at least 2 samples per pixel"));
}

/// The text of `compare`, with the same numbers.
#[test]
fn the_verdict_is_that_of_compare() {
    let folder = tempfile::tempdir().unwrap();
    let [scene, other, reference] = ["a.pbrt", "b.pbrt", "r.exr"].map(|name| folder.path().join(name));
    std::fs::write(&scene, SCENE.as_bytes()).unwrap();
    std::fs::write(&other, SCENE.replace("[1 2 3]", "[1.05 2 3]")).unwrap();
    let make = |scene: &Path| {
        let [scene, file] = [scene, &reference].map(|path| path.display().to_string());
        lookat(&["render", &scene, "--error-layers", "--seed", "7", "--force", "-o", &file]);
    };
    make(&scene);
    let viewer = Viewer::start_with(&SCENE, &["--reference", reference.to_str().unwrap()]);
    let compare = |file: &str| lookat(&["compare", file, reference.to_str().unwrap()]).1;
    let mut page = viewer.page();
    page.finished();
    let found = compared(&mut page);
    assert_eq!(found["agrees"], Value::Null);
    assert_eq!(found["text"], compare(&render(&viewer, "picture.exr", &[])));
    page.request(&json!({"type": "errors", "isOn": true}));
    page.news("looking", |looking| looking["hasErrors"] == true);
    let found = compared(&mut page);
    let file = render(&viewer, "picture.exr", &["--error-layers"]);
    assert_eq!((&found["text"], &found["agrees"]), (&json!(compare(&file)), &json!(true)));
    // The file is followed.
    make(&other);
    page.picture(|picture| picture.content == Content::Reference);
    let found = compared(&mut page);
    assert_eq!((&found["text"], &found["agrees"]), (&json!(compare(&file)), &json!(false)));
    std::fs::write(&reference, "nothing").unwrap();
    let looking = page.news("looking", |looking| looking["referenceRefused"].is_string());
    assert_eq!(looking["reference"], reference.display().to_string());
    make(&scene);
    page.news("looking", |looking| looking["referenceRefused"].is_null());
    assert_eq!(compared(&mut page)["agrees"], true);
    // Another size: the message of `compare`.
    page.request(&json!({"type": "film", "resolution": [24, 16]}));
    let looking = page.news("looking", |looking| looking["referenceRefused"].is_string());
    assert_eq!(looking["referenceRefused"], "the sizes differ: 24x16 and 48x32");
    assert_eq!(compared(&mut page)["text"], "the sizes differ: 24x16 and 48x32\n");
    // A crop window: what both have.
    page.request(&json!({"type": "film", "crop": [0.25, 0.75, 0, 1]}));
    let cut = page.picture(|picture| picture.content == Content::Reference);
    assert_eq!(cut.size, [24, 32]);
    let found = compared(&mut page);
    let file = render(&viewer, "picture.exr", &["--error-layers", "--crop", "0.25", "0.75", "0", "1"]);
    assert_eq!((&found["text"], &found["agrees"]), (&json!(compare(&file)), &json!(true)));
    assert!(found["text"].as_str().unwrap().contains("pixels are in only one of the pictures"));
}

#[test]
fn a_picture_is_kept_as_the_reference() {
    let viewer = Viewer::start(&SCENE);
    let mut page = viewer.page();
    let picture = page.finished();
    page.request(&json!({"type": "reference", "from": "picture"}));
    assert!(page.picture(|picture| picture.content == Content::Reference).pixels == picture.pixels);
    assert!(compared(&mut page)["text"].as_str().unwrap().contains("\nrmse            0 "));
    page.request(&json!({"type": "view", "by": 1, "number": 7, "camera": {"fov": 50}}));
    page.picture(|picture| picture.content == Content::Finished && picture.number == 7);
    assert!(!compared(&mut page)["text"].as_str().unwrap().contains("\nrmse            0 "));
    // A window that is opened later sees it, too.
    let mut late = viewer.page();
    assert!(late.picture(|picture| picture.content == Content::Reference).pixels == picture.pixels);
    page.request(&json!({"type": "reference", "from": "nothing"}));
    page.news("looking", |looking| looking["reference"].is_null());
    page.request(&json!({"type": "reference", "from": "file"}));
    let looking = page.news("looking", |_| true);
    assert!(looking["reference"].is_null() && looking["file"].is_null());
    // The page offers a picture beside the scene. Nothing reads it before a page chooses it.
    render(&viewer, "scene.exr", &["--seed", "3"]);
    viewer.write(&format!("{}# \n", *SCENE));
    let looking = page.news("looking", |looking| looking["file"].is_string());
    assert!(looking["reference"].is_null());
    page.request(&json!({"type": "reference", "from": "file"}));
    let looking = page.news("looking", |looking| looking["reference"].is_string());
    assert!(looking["reference"].as_str().unwrap().ends_with("scene.exr"));
}

#[test]
fn a_reference_that_is_named_must_be_there() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.pbrt");
    std::fs::write(&scene, SCENE.as_bytes()).unwrap();
    let [scene, reference] = [&scene, &folder.path().join("none.exr")].map(|path| path.display().to_string());
    let (status, out, errors) = lookat(&["view", &scene, "--reference", &reference]);
    assert_eq!((status, out), (2, String::new()));
    assert_eq!(errors, format!("error: cannot read {reference}: there is no such file or folder\n"));
}
