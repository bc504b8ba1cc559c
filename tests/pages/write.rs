//! `lookat view` writes its camera into the files of the scene.

use crate::viewer::{Page, Viewer};
use serde_json::{Value, json};

const CAMERA: &str =
    "# The camera.\r\nLookAt 0 1.0 -5  0 0 0  0 1 0 # from the front\r\nCamera \"perspective\"";
const SCENE: &str = "Include \"camera.pbrt\"
Film \"image\" \"integer xresolution\" 48 \"integer yresolution\" 32
Sampler \"halton\" \"integer pixelsamples\" 2
Integrator \"path\"
WorldBegin
LightSource \"infinite\"
Shape \"sphere\"
WorldEnd
";

/// A scene with its camera in another file.
fn start() -> (Viewer, Page) {
    let viewer = Viewer::start("WorldBegin WorldEnd");
    std::fs::write(camera_file(&viewer), CAMERA).unwrap();
    viewer.write(SCENE);
    let mut page = viewer.page();
    page.picture(|picture| picture.is_final && picture.size == [48, 32]);
    (viewer, page)
}

fn camera_file(viewer: &Viewer) -> std::path::PathBuf {
    viewer.folder.path().join("camera.pbrt")
}

fn camera_text(viewer: &Viewer) -> String {
    std::fs::read_to_string(camera_file(viewer)).unwrap()
}

fn set(page: &mut Page, number: u32, camera: Value) {
    page.request(&json!({"type": "view", "by": 1, "number": number, "camera": camera}));
    page.news("view", |view| view["number"] == number);
}

#[test]
fn the_camera_is_written_and_taken_back() {
    let (viewer, mut page) = start();
    assert_eq!(
        page.edit(1, "show")["refused"],
        "the file already has this camera and these parameters; settings of the film are never written"
    );
    assert_eq!(page.edit(1, "write")["refused"], "there is nothing to write");
    assert_eq!(page.edit(1, "undo")["refused"], "there is nothing to undo");
    set(&mut page, 1, json!({"lookAt": [0.1 + 0.2, 1, -5, 0, 0, 0, 0, 1, 0], "fov": 50}));
    let shown = page.edit(1, "show");
    assert_eq!(
        shown["lines"],
        json!([{
            "file": camera_file(&viewer),
            "line": 2,
            "removed": ["LookAt 0 1.0 -5  0 0 0  0 1 0 # from the front\r", "Camera \"perspective\""],
            "added": ["LookAt 0.3 1.0 -5  0 0 0  0 1 0 # from the front\r", "Camera \"perspective\" \"float fov\" 50"],
        }])
    );
    assert_eq!(camera_text(&viewer), CAMERA);
    // Another page has been shown nothing.
    assert_eq!(page.edit(2, "write")["refused"], "there is nothing to write");
    page.edit(1, "show");
    let written = page.edit(1, "write");
    assert_eq!(written["refused"], Value::Null);
    let text = CAMERA.replace("LookAt 0 ", "LookAt 0.3 ") + " \"float fov\" 50";
    assert_eq!(camera_text(&viewer), text);
    assert_eq!(viewer.text(), SCENE);
    // The page shows the camera of the file now.
    let mut other = viewer.page();
    let scene = other.news("scene", |_| true);
    assert_eq!((&scene["canUndo"], &scene["canRedo"]), (&true.into(), &false.into()));
    let view = other.news("view", |view| view["camera"]["fov"] == 50.0);
    assert!(view["set"].as_object().unwrap().values().all(Value::is_null), "{view}");
    assert_eq!(page.edit(2, "undo")["refused"], Value::Null);
    assert_eq!(camera_text(&viewer), CAMERA);
    other.news("view", |view| view["camera"]["fov"] == 90.0);
    assert_eq!(page.edit(1, "redo")["refused"], Value::Null);
    assert_eq!(camera_text(&viewer), text);
}

#[test]
fn nothing_is_written_that_was_not_shown() {
    let viewer = Viewer::start("Camera \"perspectiv\" WorldBegin WorldEnd");
    let mut page = viewer.page();
    assert_eq!(page.edit(1, "show")["refused"], "no scene has been read yet");
    let (viewer, mut page) = start();
    assert_eq!(page.edit(1, "write")["refused"], "there is nothing to write");
    set(&mut page, 1, json!({"fov": 50}));
    page.edit(1, "show");
    // Another page may do this.
    set(&mut page, 2, json!({"fov": 60}));
    let refused = page.edit(1, "write")["refused"].take();
    assert!(refused.as_str().unwrap().ends_with("has changed meanwhile: nothing is written"), "{refused}");
    assert_eq!(camera_text(&viewer), CAMERA);
}

#[test]
fn files_that_others_change_are_left_alone() {
    let (viewer, mut page) = start();
    set(&mut page, 1, json!({"fov": 50}));
    page.edit(1, "show");
    let other = format!("{CAMERA} # mine");
    std::fs::write(camera_file(&viewer), &other).unwrap();
    let refused = page.edit(1, "write")["refused"].take();
    assert!(refused.as_str().unwrap().ends_with("has changed meanwhile: nothing is written"), "{refused}");
    assert_eq!(camera_text(&viewer), other);
    // Shown again, it can be written.
    // It may be read before or after the refusal.
    let mut write_again = || {
        std::thread::sleep(std::time::Duration::from_millis(50));
        page.edit(1, "show");
        page.edit(1, "write")["refused"].is_null()
    };
    assert!((0..100).any(|_| write_again()));
    assert_eq!(camera_text(&viewer), format!("{CAMERA} \"float fov\" 50 # mine"));
    std::fs::remove_file(camera_file(&viewer)).unwrap();
    assert!(page.edit(1, "undo")["refused"].is_string());
    assert!(!camera_file(&viewer).exists());
}

/// The window of the film decides about the screen of a camera without a window.
#[test]
fn a_window_is_written_and_taken_back() {
    let (viewer, mut page) = start();
    set(&mut page, 1, json!({"screenWindow": [-3, 3, -2, 2]}));
    page.edit(1, "show");
    assert_eq!(page.edit(1, "write")["refused"], Value::Null);
    assert_eq!(camera_text(&viewer), format!("{CAMERA} \"float screenwindow\" [-3 3 -2 2]"));
    page.edit(1, "undo");
    assert_eq!(camera_text(&viewer), CAMERA);
    let view = viewer.page().news("view", |_| true);
    assert_eq!(view["camera"]["screenWindow"], json!([-1.5, 1.5, -1.0, 1.0]));
}

#[test]
fn a_camera_in_two_places_or_a_protected_file_is_not_changed() {
    let (viewer, mut page) = start();
    let twice = format!("Include \"./camera.pbrt\"\n{SCENE}");
    viewer.write(&twice);
    page.news("scene", |scene| scene["messages"].as_str().unwrap().contains("warning"));
    set(&mut page, 1, json!({"fov": 50}));
    let refused = page.edit(1, "show")["refused"].take();
    assert!(refused.as_str().unwrap().ends_with("is included twice: change it by hand"), "{refused}");
    viewer.write(SCENE);
    // A file that is just being written has errors.
    let is_fine = |scene: &Value| {
        scene["hasErrors"] == false && !scene["messages"].as_str().unwrap().contains("warning")
    };
    page.news("scene", is_fine);
    // The second LookAt moved the camera, so that the file has another one now.
    set(&mut page, 2, json!({"fov": 50}));
    let mut permissions = std::fs::metadata(camera_file(&viewer)).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(camera_file(&viewer), permissions).unwrap();
    assert_eq!(page.edit(1, "show")["refused"], Value::Null);
    let refused = page.edit(1, "write")["refused"].take();
    assert!(refused.as_str().unwrap().ends_with("is write-protected"), "{refused}");
    assert_eq!((camera_text(&viewer), viewer.text()), (CAMERA.to_owned(), SCENE.to_owned()));
}

/// A page can write what it was shown, even after the write of another page was refused.
#[test]
fn pages_do_not_take_what_others_were_shown() {
    let (viewer, mut page) = start();
    set(&mut page, 1, json!({"fov": 50}));
    page.edit(1, "show");
    assert_eq!(page.edit(2, "write")["refused"], "there is nothing to write");
    // Another page is shown the same lines.
    page.edit(3, "show");
    assert_eq!(page.edit(1, "write")["refused"], Value::Null);
    assert_eq!(camera_text(&viewer), format!("{CAMERA} \"float fov\" 50"));
    assert_eq!(page.edit(3, "write")["refused"], "there is nothing to write");
}

#[cfg(unix)]
#[test]
fn a_file_under_two_names_is_not_changed_and_a_link_stays() {
    use std::os::unix::fs::MetadataExt;

    let (viewer, mut page) = start();
    let link = viewer.folder.path().join("link.pbrt");
    std::fs::hard_link(camera_file(&viewer), &link).unwrap();
    viewer.write(&format!("Include \"link.pbrt\"\n{SCENE}"));
    page.news("scene", |scene| scene["messages"].as_str().unwrap().contains("warning"));
    set(&mut page, 1, json!({"fov": 50}));
    let refused = page.edit(1, "show")["refused"].take();
    assert!(refused.as_str().unwrap().ends_with("is included twice: change it by hand"), "{refused}");
    viewer.write(SCENE);
    page.news("scene", |scene| {
        scene["hasErrors"] == false && !scene["messages"].as_str().unwrap().contains("warning")
    });
    set(&mut page, 2, json!({"fov": 50}));
    assert_eq!(page.edit(1, "show")["refused"], Value::Null);
    assert_eq!(page.edit(1, "write")["refused"], Value::Null);
    let text = format!("{CAMERA} \"float fov\" 50");
    assert_eq!((camera_text(&viewer), std::fs::read_to_string(&link).unwrap()), (text.clone(), text));
    assert_eq!(std::fs::metadata(&link).unwrap().nlink(), 2);
}

/// What is no file, or too large, is an error as at the start. Nothing waits for it, and the file can come back.
#[cfg(unix)]
#[test]
fn a_file_that_becomes_a_pipe_a_device_or_huge_is_survived() {
    use std::path::Path;
    use std::process::Command;

    let viewer = Viewer::start_with("WorldBegin WorldEnd", &["--max-memory", "200M"]);
    std::fs::write(camera_file(&viewer), CAMERA).unwrap();
    viewer.write(SCENE);
    let mut page = viewer.page();
    page.picture(|picture| picture.is_final && picture.size == [48, 32]);
    set(&mut page, 1, json!({"fov": 50}));
    page.edit(1, "show");
    assert_eq!(page.edit(1, "write")["refused"], Value::Null);
    let written = camera_text(&viewer);
    let other = viewer.folder.path().join("other");
    let make = |kind: &str, path: &Path| match kind {
        "pipe" => assert!(Command::new("mkfifo").arg(path).status().unwrap().success()),
        "device" => std::os::unix::fs::symlink("/dev/zero", path).unwrap(),
        _ => std::fs::File::create(path).unwrap().set_len(1_500_000_000).unwrap(),
    };
    for (kind, reason) in [
        ("pipe", "it is a pipe or a device, not a file"),
        ("device", "it is a pipe or a device, not a file"),
        ("huge", "the limit is 200.0 MB"),
    ] {
        for file in [&camera_file(&viewer), &viewer.scene] {
            let text = std::fs::read_to_string(file).unwrap();
            // A change that is not written: it is compared with the file, too.
            let lights = viewer.page().news("scene", |_| true)["lights"].take();
            let at = &lights[0]["place"]["at"];
            page.request(&json!({
                "type": "change", "by": 1, "number": 7, "shown": [at], "at": at,
                "name": "L", "valueType": "rgb", "values": [3, 2, 1],
            }));
            assert_eq!(page.news("changed", |_| true)["refused"], Value::Null);
            make(kind, &other);
            std::fs::rename(&other, file).unwrap();
            let scene = page.news("scene", |scene| scene["hasErrors"] == true);
            assert!(scene["messages"].as_str().unwrap().contains(reason), "{scene}");
            page.edit(1, "discard");
            assert_eq!(page.edit(1, "undo")["refused"].is_string(), file != &viewer.scene);
            std::fs::write(&other, text).unwrap();
            std::fs::rename(&other, file).unwrap();
            page.news("scene", |scene| scene["hasErrors"] == false);
            if file == &viewer.scene {
                assert_eq!(camera_text(&viewer), CAMERA);
                page.edit(1, "redo");
            }
            assert_eq!(camera_text(&viewer), written);
        }
    }
    // In kB. The budget does not count the program itself.
    if let Ok(status) = std::fs::read_to_string(format!("/proc/{}/status", viewer.process())) {
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
        let peak: u64 = peak.trim().trim_end_matches(" kB").parse().unwrap();
        assert!(peak < 400_000, "{peak} kB");
    }
}
