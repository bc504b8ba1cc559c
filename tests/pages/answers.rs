//! What pages ask for, and what they get.

use std::process::Command;

use lookat_image::{Image, PictureFile};
use serde_json::{Value, json};

use crate::server::SCENE;
use crate::viewer::{Page, Viewer};

#[test]
fn values_out_of_range_are_refused_with_a_reason() {
    let viewer = Viewer::start(SCENE);
    let mut page = viewer.page();
    page.finished();
    for (camera, reason) in [
        (json!({"fov": 180}), "the angle must be above 0 and below 180 degrees"),
        (
            json!({"lookAt": [1, 1, 1, 1, 1, 1, 0, 1, 0]}),
            "the eye and the target of LookAt are the same point",
        ),
        (
            json!({"screenWindow": [1, 1, 0, 1]}),
            "the window is empty: write the edges as xmin xmax ymin ymax",
        ),
    ] {
        page.request(&json!({"type": "view", "by": 1, "number": 2, "camera": camera}));
        let view = page.news("view", |view| view["number"] == 2 && view["refused"] == reason);
        assert_eq!(view["camera"]["fov"], 40.0);
    }
}

#[test]
fn a_refusal_changes_nothing_for_good() {
    let viewer = Viewer::start(SCENE);
    let mut page = viewer.page();
    page.finished();
    page.request(&json!({"type": "view", "by": 1, "number": 2, "camera": {"fov": 200}}));
    page.news("view", |view| view["number"] == 2 && view["refused"].is_string());
    // What is told later is no older than the refused request: the page would ignore it.
    viewer.write(&SCENE.replace("fov\" 40", "fov\" 30"));
    let view = page.news("view", |view| view["camera"]["fov"] == 30.0);
    assert_eq!(view["number"], 2);
    for film in [
        json!({"resolution": [1e60, 40]}),
        json!({"resolution": [0, 40]}),
        json!({"samplesPerPixel": -0.5}),
        json!({"crop": [0.5, 0.5, 0, 1]}),
    ] {
        let mut request = film.clone();
        request["type"] = "film".into();
        page.request(&request);
        let scene = page.news("scene", |scene| scene["filmRefused"].is_string());
        assert_eq!(
            (&scene["hasErrors"], &scene["film"]["resolution"]),
            (&false.into(), &json!([48, 32])),
            "{film}"
        );
    }
    viewer.write(SCENE);
    let scene = page.news("scene", |scene| scene["filmRefused"].is_null());
    assert_eq!(scene["hasErrors"], false);
}

/// Pages that ask at the same time all get their answers.
#[test]
fn no_answer_is_lost_to_another_page() {
    let viewer = Viewer::start(SCENE);
    let mut pages: Vec<Page> = (0..6).map(|_| viewer.page()).collect();
    pages[0].finished();
    for _ in 0..5 {
        for (by, page) in pages.iter_mut().enumerate() {
            page.request(&json!({"type": "pick", "by": by, "number": by, "at": [24, 16]}));
            page.request(&json!({"type": "edit", "by": by, "action": "undo"}));
        }
        for (by, page) in pages.iter_mut().enumerate() {
            let picked = page.news("picked", |picked| picked["by"] == by);
            assert_eq!(picked["hit"]["shape"], "sphere");
        }
    }
}

/// The pixels of what `lookat render` makes.
fn rendered(viewer: &Viewer, arguments: &[&str]) -> Vec<[f32; 3]> {
    let picture = viewer.folder.path().join("picture.exr");
    let output = Command::new(env!("CARGO_BIN_EXE_lookat"))
        .args(["render", "--force", "-o"])
        .arg(&picture)
        .arg(&viewer.scene)
        .args(arguments)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let image: Image = PictureFile::open(&picture, &Default::default()).unwrap().read().unwrap().0;
    image.rgb().unwrap()
}

#[test]
fn the_last_picture_is_that_of_render() {
    let viewer = Viewer::start(SCENE);
    let mut page = viewer.page();
    let picture = page.finished();
    assert_eq!(picture.size, [48, 32]);
    assert!(picture.pixels == rendered(&viewer, &[]));
    // Another camera.
    let points = [1.5, 2.0, -4.0, 0.1, 0.2, 0.3, 0.0, 1.0, 0.1];
    let camera = json!({"lookAt": points, "fov": 55.5, "lensRadius": 0.1, "focalDistance": 4.5, "screenWindow": [-1.5, 1.6, -1, 1]});
    page.request(&json!({"type": "view", "by": 1, "number": 7, "camera": camera}));
    let picture = page.picture(|picture| picture.is_final && picture.number == 7);
    let look_at = points.map(|number| number.to_string()).join(" ");
    let view = [
        "--fov",
        "55.5",
        "--lens-radius",
        "0.1",
        "--focal-distance",
        "4.5",
        "--screen-window",
        "-1.5 1.6 -1 1",
    ];
    assert!(picture.pixels == rendered(&viewer, &[&["--lookat", &look_at], &view[..]].concat()));
    // Another film, and again the camera of the file.
    page.request(&json!({"type": "view", "by": 1, "number": 8, "camera": {}}));
    page.request(
        &json!({"type": "film", "resolution": [30, 40], "crop": [0.1, 0.9, 0, 0.5], "samplesPerPixel": 3}),
    );
    let picture = page.picture(|picture| picture.is_final && picture.number == 8 && picture.size == [24, 20]);
    let film = ["--resolution", "30x40", "--crop", "0.1", "0.9", "0", "0.5", "--spp", "3"];
    assert!(picture.pixels == rendered(&viewer, &film));
}

/// The page moves a camera from where it is, however the file places it.
#[test]
fn cameras_are_moved_from_where_they_are() {
    for (placed, has_look_at, is_exact) in [
        ("LookAt 0 1 -5  0 0 0  0 1 0", true, true),
        ("Scale -1 1 1 LookAt 0 1 -5  0 0 0  0 1 0", true, true),
        ("Rotate 20 1 .3 0 Translate 0 -1 5", false, false),
        ("Scale -1 2 1 Translate 0 -1 5", false, false),
    ] {
        let viewer = Viewer::start(&SCENE.replace("LookAt 0 1 -5  0 0 0  0 1 0", placed));
        let mut page = viewer.page();
        let view = page.news("view", |_| true);
        assert_eq!(view["camera"]["hasLookAt"], has_look_at, "{placed}");
        let own = page.finished().pixels;
        let camera = json!({"lookAt": view["camera"]["lookAt"]});
        page.request(&json!({"type": "view", "by": 1, "number": 9, "camera": camera}));
        let moved = page.picture(|picture| picture.is_final && picture.number == 9).pixels;
        let differing = own.iter().zip(&moved).filter(|(a, b)| (a[0] - b[0]).abs() > 1e-4).count();
        assert!(differing <= if is_exact { 0 } else { 8 }, "{placed}: {differing}");
    }
}

#[test]
fn a_place_has_a_shape_a_material_and_lines() {
    let viewer = Viewer::start(SCENE);
    let mut page = viewer.page();
    page.finished();
    let mut pick = |at: [f64; 2]| {
        page.request(&json!({"type": "pick", "by": 1, "number": 3, "at": at}));
        page.news("picked", |picked| picked["at"] == json!(at))["hit"].take()
    };
    let hit = pick([24.0, 16.0]);
    assert_eq!(hit["shape"], "sphere");
    assert_eq!(hit["shapePlace"]["text"], format!("{}:9:7", viewer.scene.display()));
    assert_eq!(hit["material"], "matte");
    assert_eq!(hit["materialPlace"]["text"], format!("{}:8:10", viewer.scene.display()));
    let depth = hit["depth"].as_f64().unwrap();
    assert!((depth - (26_f64.sqrt() - 1.0)).abs() < 0.01, "{depth}");
    assert_eq!(pick([1.0, 1.0]), Value::Null);
    // The picture is the same after it, and a new page gets it.
    let picture = viewer.page().finished();
    assert!(picture.pixels == rendered(&viewer, &[]));
}

#[test]
fn the_page_follows_the_file() {
    let viewer = Viewer::start(SCENE);
    let mut page = viewer.page();
    page.finished();
    let broken = SCENE.replace("\"sphere\"", "\"sphrere\"");
    viewer.write(&broken);
    let scene = page.news("scene", |scene| scene["hasErrors"] == true);
    let check = Command::new(env!("CARGO_BIN_EXE_lookat")).arg("check").arg(&viewer.scene).output().unwrap();
    assert_eq!(scene["messages"], String::from_utf8(check.stderr).unwrap());
    assert_eq!(scene["film"]["resolution"], json!([48, 32]));
    // The last camera without errors can still move.
    page.request(&json!({"type": "view", "by": 1, "number": 5, "camera": {"fov": 50}}));
    page.picture(|picture| picture.is_final && picture.number == 5);
    std::fs::remove_file(&viewer.scene).unwrap();
    let gone = |scene: &Value| scene["messages"].as_str().unwrap().contains("cannot read");
    page.news("scene", |scene| scene["hasErrors"] == true && gone(scene));
    // The camera that the page has set stays, because the file has the same one as before.
    viewer.write(&SCENE.replace("[.5 .4 .3]", "[.1 .2 .3]"));
    page.news("scene", |scene| scene["hasErrors"] == false);
    let picture = page.picture(|picture| picture.is_final);
    assert!(picture.pixels == rendered(&viewer, &["--fov", "50"]));
    // A new camera in the file replaces it.
    viewer.write(&SCENE.replace("fov\" 40", "fov\" 30"));
    page.news("view", |view| view["camera"]["fov"] == 30.0);
    let picture = page.picture(|picture| picture.is_final);
    assert!(picture.pixels == rendered(&viewer, &[]));
}

#[test]
fn two_pages_share_the_camera() {
    let viewer = Viewer::start(SCENE);
    let [mut one, mut other]: [Page; 2] = [viewer.page(), viewer.page()];
    one.request(&json!({"type": "view", "by": 1, "number": 2, "camera": {"fov": 20}}));
    let view = other.news("view", |view| view["by"] == 1);
    assert_eq!((&view["camera"]["fov"], &view["set"]["fov"]), (&json!(20.0), &json!(20.0)));
    let [a, b] =
        [&mut one, &mut other].map(|page| page.picture(|picture| picture.is_final && picture.number == 2));
    assert!(a.pixels == b.pixels);
    drop(one);
    other.request(&json!({"type": "view", "by": 2, "number": 3, "camera": {}}));
    other.picture(|picture| picture.is_final && picture.number == 3);
}
