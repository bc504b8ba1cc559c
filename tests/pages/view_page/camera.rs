//! Moving the camera, focusing and pointing.

use serde_json::{Value, json};

use super::{Opened, SCENE};

#[test]
fn the_camera_moves_by_mouse_and_keys() {
    let Some(mut page) = Opened::new() else { return };
    let frame = page.place(0.0, 0.0);
    let [left, middle] = [page.place(0.3, 0.5), page.place(0.5, 0.5)];
    page.drag(left, middle);
    page.browser.wait_for("of('eye-x').valueAsNumber < -1");
    page.finish();
    // Around the target or what is seen there, at about the same distance, and upright.
    let eye = ["x", "y", "z"].map(|axis| page.number(&format!("eye-{axis}")));
    assert!((eye.iter().map(|it| it * it).sum::<f64>().sqrt() - 5.1).abs() < 1.5, "{eye:?}");
    assert_eq!(page.number("up vector-y"), 1.0);
    assert_eq!(page.place(0.0, 0.0), frame, "nothing jumps");
    page.value("of('frame').focus()");
    page.browser.press("r", 82);
    page.browser.wait_for("of('eye-x').valueAsNumber === 0");
    page.browser.press("ArrowRight", 39);
    page.browser.wait_for("of('eye-x').valueAsNumber > 0.1");
    page.browser.press("+", 187);
    page.browser.wait_for("Math.abs(Math.hypot(...['x', 'y', 'z'].map((axis) => of(`eye-${axis}`).valueAsNumber)) - 0.9 * 26 ** 0.5) < 0.02");
    page.enter("fov-", 200.0);
    page.browser.wait_for("of('refused').textContent.includes('below 180 degrees')");
    page.value("of('reset').click()");
    page.browser.wait_for("of('fov-').valueAsNumber === 40");
    page.finish();
    assert_eq!(page.viewer.text(), SCENE);
    page.close();
}

#[test]
fn the_camera_moves_by_touch() {
    let Some(mut page) = Opened::new() else { return };
    let [left, middle, right] = [0.3, 0.5, 0.7].map(|x| page.place(x, 0.5));
    page.browser.touch("touchStart", &[left]);
    page.browser.touch("touchMove", &[middle]);
    page.browser.wait_for("of('eye-x').valueAsNumber < -1");
    page.browser.touch("touchEnd", &[]);
    page.value("of('reset').click()");
    page.browser.wait_for("of('eye-x').valueAsNumber === 0");
    // Fingers that come nearer move the eye away.
    page.browser.touch("touchStart", &[left]);
    page.browser.touch("touchStart", &[left, right]);
    page.browser.touch("touchMove", &[left, middle]);
    page.browser.wait_for("of('eye-z').valueAsNumber < -7");
    page.browser.touch("touchEnd", &[]);
    // What was between the fingers is still there.
    let sphere = page.place(0.4, 0.5);
    page.browser.touch("touchStart", &[sphere]);
    page.browser.touch("touchEnd", &[]);
    page.browser.wait_for("of('hit').textContent.includes('scene.pbrt')");
    page.finish();
    page.close();
}

#[test]
fn sliders_change_the_window_and_the_crop() {
    let Some(mut page) = Opened::new() else { return };
    let slide = |page: &mut Opened, name: &str, value: f64| {
        let slider = json!(format!("[aria-label=\"{name}, slider\"]"));
        page.value(&format!(
            "(({{ valueAsNumber: before }}, slider) => {{
                slider.value = {value}; slider.dispatchEvent(new Event('input')); return before;
            }})(document.querySelector({slider}), document.querySelector({slider}))"
        ))
    };
    assert_eq!(slide(&mut page, "screenwindow left", -2.0), -1.5);
    assert_eq!(slide(&mut page, "cropwindow right", 0.5), 1.0);
    page.browser.wait_for("of('picture').width === 30");
    assert_eq!(page.number("cropwindow-right"), 0.5);
    // An edge stops at the other one.
    slide(&mut page, "cropwindow left", 0.9);
    page.browser.wait_for("of('picture').width === 1");
    assert_eq!(page.number("cropwindow-right"), 0.5);
    assert_eq!(page.number("screenwindow-left"), -2.0);
    assert_eq!(page.number("frameaspectratio-"), 1.75);
    // What is no number, and no ratio, changes nothing.
    for (field, value) in [("frameaspectratio-", 0.0), ("frameaspectratio-", -1.0), ("fov-", f64::NAN)] {
        let before = page.number(field);
        page.enter(field, value);
        assert_eq!(page.number(field), before);
    }
    // A film that cannot be is refused in words.
    page.enter("resolution-xresolution", 1e60);
    page.browser.wait_for("of('film-refused').textContent.startsWith('resolution is 1 to')");
    // A window without an area is refused.
    page.enter("screenwindow-right", -2.0);
    page.browser.wait_for("of('refused').textContent.includes('the window is empty')");
    page.close();
}

#[test]
fn a_click_names_the_shape_and_focuses() {
    let Some(mut page) = Opened::new() else { return };
    let middle = page.place(0.5, 0.5);
    page.browser.click(middle);
    page.browser.wait_for("of('hit').textContent.includes('scene.pbrt:9:7')");
    let hit = page.value("of('hit').textContent");
    assert!(
        ["sphere", "matte", "scene.pbrt:8:10"].iter().all(|it| hit.as_str().unwrap().contains(it)),
        "{hit}"
    );
    assert_eq!(page.value("of('focaldistance-').disabled"), true);
    page.enter("lensradius-", 0.1);
    page.browser.wait_for("!of('focaldistance-').disabled");
    assert!((page.number("focaldistance-") - 5.099).abs() < 0.001);
    page.browser.click(middle);
    page.browser.wait_for("of('focaldistance-').valueAsNumber < 4.2");
    page.finish();
    let corner = page.place(0.02, 0.02);
    page.browser.click(corner);
    page.browser.wait_for("of('hit').textContent === 'Nothing is there.'");
    page.close();
}

#[test]
fn the_blur_of_the_lens_is_shown() {
    let Some(mut page) = Opened::new() else { return };
    assert_eq!(page.value("of('show-blur').disabled"), true);
    page.enter("lensradius-", 0.3);
    page.enter("focaldistance-", 4.0);
    page.browser.wait_for("!of('show-blur').disabled");
    page.value("of('show-blur').click()");
    page.browser.wait_for("of('blur').childElementCount > 3");
    // A pixel is 2 tan(20 degrees) / 40 = 0.0182 at depth 1; 1 / 4 -+ 0.0182 / 0.6 are 0.2197 and 0.2803.
    assert_eq!(page.value("of('sharp-range').textContent"), "3.567 to 4.552");
    // The middle of the sphere, at depth 4.1, is sharp; its rim is not.
    page.browser
        .wait_for("['.sharp', ':not(.sharp)'].every((kind) => of('blur').querySelector(`circle${kind}`))");
    page.value("of('lensradius-').value = 0; of('lensradius-').dispatchEvent(new Event('change'))");
    page.browser.wait_for("of('blur').hasAttribute('hidden')");
    page.close();
}

/// On a plane through the target. Mirrored cameras and reversed windows follow the pointer, too.
#[test]
fn what_is_under_the_pointer_follows_it() {
    let plane = SCENE.replace("LookAt 0 1 -5", "LookAt 0 0 -5").replace(
        "Shape \"sphere\"",
        "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [-9 -9 0 9 -9 0 9 9 0 -9 9 0]",
    );
    let window = |edges: &str| format!("\"float screenwindow\" [{edges}] Film");
    for scene in [
        plane.clone(),
        plane.replace("LookAt", "Scale -1 1 1 LookAt"),
        plane.replace("Film", &window("1.5 -1.2 1 -1")),
        plane.replace("\"perspective\" \"float fov\" 40", "\"orthographic\""),
    ] {
        let Some(mut page) = Opened::with(&scene) else { return };
        let mut socket = page.viewer.page();
        let camera = socket.news("view", |_| true)["camera"].take();
        let mut number = 0;
        let mut seen = |camera: &Value, x: f64, y: f64| -> [f64; 3] {
            number += 1;
            let set = json!({"lookAt": camera["lookAt"], "screenWindow": camera["screenWindow"]});
            socket.request(&json!({"type": "view", "by": 1, "number": number, "camera": set}));
            socket.news("view", |view| view["number"] == number && view["refused"].is_null());
            socket.request(&json!({"type": "pick", "by": 1, "number": number, "at": [60.0 * x, 40.0 * y]}));
            let picked = socket.news("picked", |picked| picked["number"] == number);
            std::array::from_fn(|axis| picked["hit"]["p"][axis].as_f64().unwrap())
        };
        let mut moved = |call: &str| {
            page.value(&format!(
                "import(new URL('camera.js', location.href)).then(({{ dolly, orbit, pan }}) => {call})"
            ))
        };
        let is_near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
        let [before, right] = [seen(&camera, 0.5, 0.4), seen(&camera, 0.6, 0.4)];
        let panned = moved(&format!("pan({camera}, 0.1, 0.2, null)"));
        assert!(is_near(seen(&panned, 0.6, 0.6), before), "{scene}");
        let nearer = moved(&format!("dolly({camera}, 0.7, [0.6, 0.4])"));
        assert!(is_near(seen(&nearer, 0.6, 0.4), right), "{scene}");
        assert!(!is_near(seen(&nearer, 0.5, 0.4), before), "{scene}");
        // What is before the target goes right as the eye goes left, and down as the eye goes up.
        let up = seen(&camera, 0.5, 0.3);
        let side = |camera: &Value, to: [f64; 3]| -> f64 {
            (0..3).map(|axis| camera["lookAt"][axis].as_f64().unwrap() * (to[axis] - before[axis])).sum()
        };
        let turned = moved(&format!("orbit({camera}, null, 0.1, 0)"));
        assert!(side(&turned, right) < side(&camera, right), "{scene}");
        let risen = moved(&format!("orbit({camera}, null, 0, 0.1)"));
        assert!(side(&risen, up) > side(&camera, up), "{scene}");
        page.close();
    }
}
