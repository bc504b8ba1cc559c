//! `lookat view` changes parameters of materials and lights, and writes them on request.

use crate::viewer::{Page, Viewer};
use serde_json::{Value, json};

const SCENE: &str = "LookAt 0 1 -5  0 0 0  0 1 0
Camera \"perspective\" \"float fov\" 40
Film \"image\" \"integer xresolution\" 48 \"integer yresolution\" 32
Sampler \"halton\" \"integer pixelsamples\" 2
Integrator \"path\"
WorldBegin
LightSource \"point\" \"rgb I\" [9 9 9] \"point from\" [2 3 -4] # above
MakeNamedMaterial \"red\" \"string type\" [\"plastic\"] \"rgb Kd\" [.9 .10 .1] \"float roughness\" .2
NamedMaterial \"red\"
AreaLightSource \"diffuse\" \"rgb L\" [.1 .1 .1]
Shape \"sphere\"
WorldEnd
";

fn start(scene: &str) -> (Viewer, Page) {
    let viewer = Viewer::start(scene);
    let mut page = viewer.page();
    page.finished();
    (viewer, page)
}

fn pick(page: &mut Page) -> Value {
    page.request(&json!({"type": "pick", "by": 1, "number": 0, "at": [24, 16]}));
    page.news("picked", |_| true)["hit"].take()
}

/// Changes a parameter of one of the directives that are shown.
fn change(
    page: &mut Page,
    shown: &Value,
    which: usize,
    (name, value_type): (&str, &str),
    values: Value,
) -> Value {
    let places: Vec<&Value> = shown.as_array().unwrap().iter().map(|shown| &shown["place"]["at"]).collect();
    page.request(&json!({
        "type": "change", "by": 1, "number": 7, "shown": places, "at": places[which],
        "name": name, "valueType": value_type, "values": values,
    }));
    page.news("changed", |_| true)
}

/// The value of a parameter.
fn given<'v>(directive: &'v Value, name: &str) -> &'v Value {
    let parameters = directive["parameters"].as_array().unwrap();
    &parameters.iter().find(|parameter| parameter["facts"]["name"] == name).unwrap()["given"]
}

#[test]
fn materials_and_lights_change_before_they_are_written() {
    let (viewer, mut page) = start(SCENE);
    let hit = pick(&mut page);
    assert_eq!(hit["shapePlace"]["line"], 11);
    let shown = &hit["directives"];
    let head = |shown: &Value| (shown["directive"].clone(), shown["kind"].clone(), shown["name"].clone());
    assert_eq!(head(&shown[0]), (json!("MakeNamedMaterial"), json!("plastic"), json!("red")));
    assert_eq!(head(&shown[1]), (json!("AreaLightSource"), json!("diffuse"), Value::Null));
    assert_eq!(given(&shown[0], "Kd"), &json!({"type": "rgb", "values": [0.9, 0.1, 0.1]}));
    assert_eq!(given(&shown[0], "Ks"), &Value::Null);
    let before = pixels(&viewer);
    let changed = change(&mut page, shown, 0, ("Kd", "rgb"), json!([0.1, 0.1, 0.125]));
    assert_eq!(changed["refused"], Value::Null);
    // A parameter that was not there moves what follows.
    let changed = change(&mut page, &changed["directives"], 0, ("Ks", "rgb"), json!([0.5, 0.5, 0.5]));
    let changed = change(&mut page, &changed["directives"], 1, ("twosided", "bool"), json!(["true"]));
    assert_eq!(changed["refused"], Value::Null);
    let after = page.finished().pixels;
    let red = |pixels: &[[f32; 3]]| pixels.iter().map(|pixel| pixel[0]).sum::<f32>();
    assert!(red(&after) < 0.7 * red(&before));
    assert_eq!(viewer.text(), SCENE);
    let written = SCENE
        .replace(
            "[.9 .10 .1] \"float roughness\" .2",
            "[0.1 .10 0.125] \"float roughness\" .2 \"rgb Ks\" [0.5 0.5 0.5]",
        )
        .replace("L\" [.1 .1 .1]", "L\" [.1 .1 .1] \"bool twosided\" \"true\"");
    // Each change can be taken back.
    page.edit(1, "undo");
    page.edit(1, "undo");
    page.picture(|picture| picture.is_final && picture.pixels != after);
    page.edit(1, "redo");
    page.edit(1, "redo");
    page.picture(|picture| picture.is_final && picture.pixels == after);
    // The camera is written along.
    page.request(&json!({"type": "view", "by": 1, "number": 1, "camera": {"fov": 50}}));
    page.news("view", |view| view["number"] == 1);
    let lines = page.edit(1, "show")["lines"].take();
    let lines: Vec<&Value> = lines.as_array().unwrap().iter().map(|lines| &lines["line"]).collect();
    assert_eq!(lines, [&json!(2), &json!(8), &json!(10)]);
    assert_eq!(page.edit(1, "write")["refused"], Value::Null);
    assert_eq!(viewer.page().news("scene", |_| true)["hasLost"], false);
    assert_eq!(viewer.text(), written.replace("fov\" 40", "fov\" 50"));
    let render = |text: &str| Viewer::start(text).page().finished().pixels;
    assert_eq!(render(&written), after);
    assert_eq!(page.edit(1, "undo")["isWritten"], true);
    assert_eq!(viewer.text(), SCENE);
}

#[test]
fn lights_are_listed_and_changes_are_discarded() {
    let (viewer, mut page) = start(SCENE);
    let lights = viewer.page().news("scene", |_| true)["lights"].take();
    assert_eq!(given(&lights[0], "from"), &json!({"type": "point3", "values": [2.0, 3.0, -4.0]}));
    let before = pixels(&viewer);
    change(&mut page, &lights, 0, ("I", "rgb"), json!([99, 99, 99]));
    assert_eq!(viewer.page().news("scene", |_| true)["hasUnsaved"], true);
    page.picture(|picture| picture.is_final && picture.pixels != before);
    assert_eq!(page.edit(1, "discard")["refused"], Value::Null);
    page.picture(|picture| picture.is_final && picture.pixels == before);
    // A file that another program changes is shown as it is.
    let lights = viewer.page().news("scene", |_| true)["lights"].take();
    change(&mut page, &lights, 0, ("I", "rgb"), json!([99, 99, 99]));
    viewer.write(&SCENE.replace("# above", "# behind"));
    let scene = page.news("scene", |scene| scene["hasLost"] == true);
    assert_eq!(scene["hasUnsaved"], false);
    assert_eq!(given(&scene["lights"][0], "I")["values"], json!([9.0, 9.0, 9.0]));
    assert_eq!(
        page.edit(1, "show")["refused"],
        "the file already has this camera and these parameters; settings of the film are never written"
    );
}

/// The finished picture.
fn pixels(viewer: &Viewer) -> Vec<[f32; 3]> {
    viewer.page().finished().pixels
}

#[test]
fn what_is_wrong_is_refused() {
    let (viewer, mut page) = start(SCENE);
    let hit = pick(&mut page);
    let shown = &hit["directives"];
    let mut refused = |which: usize, key: (&str, &str), values: Value| {
        let changed = change(&mut page, shown, which, key, values);
        assert_eq!(changed["directives"].as_array().unwrap().len(), 2);
        changed["refused"].as_str().unwrap_or_default().to_owned()
    };
    assert_eq!(
        refused(1, ("twosided", "bool"), json!(["a\" Shape \"sphere"])),
        "this value cannot be written"
    );
    assert!(refused(0, ("Kd", "spectrum"), json!(["/etc/passwd"])).contains("cannot name files"));
    assert_eq!(refused(0, ("Kf", "rgb"), json!([1, 1, 1])), "there is no parameter \"Kf\"");
    assert_eq!(refused(0, ("Kd", "hue"), json!([1, 1, 1])), "there is no type \"hue\"");
    assert!(
        refused(0, ("Kd", "rgb"), json!([1, 1])).contains("Kd needs 3 numbers (red, green, blue), found 2")
    );
    assert!(
        refused(0, ("Kd", "texture"), json!(["bricks"])).contains("there is no spectrum texture \"bricks\"")
    );
    assert!(refused(0, ("bumpmap", "string"), json!(["a.png"])).contains("cannot name files"));
    assert!(refused(1, ("L", "rgb"), json!([1e30, 1, 1])).contains("1e18"));
    let old = json!([{"place": {"at": {"reading": 99, "file": 0, "start": 3}}}]);
    let changed = change(&mut page, &old, 0, ("Kd", "rgb"), json!([1, 1, 1]));
    assert_eq!(changed["refused"], "the file has changed: point at the shape again");
    // The camera is no material.
    let mut camera = shown[0].clone();
    camera["place"]["at"]["start"] = json!(SCENE.find("Camera").unwrap());
    let changed = change(&mut page, &json!([camera]), 0, ("fov", "float"), json!([50]));
    assert_eq!(changed["refused"], "there is no material or light at this place");
    assert_eq!(viewer.page().news("scene", |_| true)["hasUnsaved"], false);
    assert_eq!(viewer.text(), SCENE);
}
