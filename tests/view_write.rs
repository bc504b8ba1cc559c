//! `lookat view` writes its camera into the files of the scene.

#[path = "view_server/viewer.rs"]
#[expect(dead_code, reason = "the server needs more of it")]
mod viewer;

use serde_json::{Value, json};
use viewer::{Page, Viewer};

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
        "the file has this camera and these parameters already; the film is never written"
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
