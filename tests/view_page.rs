//! The page of `lookat view`, in a browser. Skipped where there is none.

#[path = "report/browser.rs"]
#[expect(dead_code, reason = "the report needs more of it")]
mod browser;
#[path = "view_server/viewer.rs"]
#[expect(dead_code, reason = "the server needs more of it")]
mod viewer;

use browser::Browser;
use serde_json::{Value, json};
use viewer::Viewer;

const SCENE: &str = "LookAt 0 1 -5  0 0 0  0 1 0
Camera \"perspective\" \"float fov\" 40
Film \"image\" \"integer xresolution\" 60 \"integer yresolution\" 40
Sampler \"halton\" \"integer pixelsamples\" 4
Integrator \"path\"
WorldBegin
LightSource \"infinite\" \"rgb L\" [.25 .25 .25]
Material \"matte\" \"rgb Kd\" [.5 .4 .312345678]
Shape \"sphere\"
WorldEnd
";

struct Opened {
    browser: Browser,
    viewer: Viewer,
}

impl Opened {
    fn new() -> Option<Opened> {
        Opened::with(SCENE)
    }

    fn with(scene: &str) -> Option<Opened> {
        let Some(program) = browser::find() else {
            println!("skipped: no Chromium on PATH, nor in the environment variable CHROMIUM");
            return None;
        };
        let viewer = Viewer::start(scene);
        let mut browser = Browser::start(&program);
        browser.resize(1280, 900);
        browser.visit(&format!("http://{}/{}/", viewer.host, viewer.token));
        let mut page = Opened { browser, viewer };
        page.browser.evaluate("window.of = (id) => document.getElementById(id)");
        page.finish();
        Some(page)
    }

    /// Waits for the picture that `render` makes.
    fn finish(&mut self) {
        self.browser.wait_for("of('samples').textContent.startsWith('finished: 4 of 4 samples')");
    }

    fn value(&mut self, expression: &str) -> Value {
        self.browser.evaluate(expression)
    }

    fn number(&mut self, field: &str) -> f64 {
        self.value(&format!("of({}).valueAsNumber", json!(field))).as_f64().unwrap()
    }

    /// Chooses from a list, as a person does: with an event.
    fn choose(&mut self, list: &str, value: &str) {
        let (list, value) = (json!(list), json!(value));
        self.value(&format!("of({list}).value = {value}; of({list}).dispatchEvent(new Event('change'))"));
    }

    /// The color of a pixel of the canvas.
    fn color(&mut self, [x, y]: [u32; 2]) -> [u64; 3] {
        let data = format!("[...of('picture').getContext('2d').getImageData({x}, {y}, 1, 1).data]");
        let color = self.value(&data);
        std::array::from_fn(|c| color[c].as_u64().unwrap())
    }

    fn text(&mut self, id: &str) -> String {
        self.value(&format!("of({}).textContent", json!(id))).as_str().unwrap().into()
    }

    /// Types a number into a field.
    fn enter(&mut self, field: &str, value: f64) {
        let field = json!(field);
        self.value(&format!("of({field}).value = {value}; of({field}).dispatchEvent(new Event('change'))"));
    }

    /// A place of the window, by fractions of the picture.
    fn place(&mut self, x: f64, y: f64) -> [f64; 2] {
        let place = self.value(&format!(
            "(({{ x, y, width, height }}) => [x + {x} * width, y + {y} * height])(of('frame').getBoundingClientRect())"
        ));
        std::array::from_fn(|i| place[i].as_f64().unwrap())
    }

    fn drag(&mut self, from: [f64; 2], to: [f64; 2]) {
        self.browser.mouse("mousePressed", from);
        for step in 1..=10 {
            let at = |axis: usize| from[axis] + (to[axis] - from[axis]) * f64::from(step) / 10.0;
            self.browser.mouse("mouseMoved", [at(0), at(1)]);
        }
        std::thread::sleep(std::time::Duration::from_millis(200));
        self.browser.mouse("mouseReleased", to);
    }

    fn close(self) {
        assert!(self.browser.faults.is_empty(), "{}", self.browser.faults.join("\n"));
    }
}

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
fn errors_are_shown_over_the_last_picture() {
    let Some(mut page) = Opened::new() else { return };
    page.viewer.write(&SCENE.replace("\"sphere\"", "\"sphrere\""));
    page.browser.wait_for("!of('error').hidden && of('errors').textContent.includes('^^^^^^^^^')");
    assert!(page.value("of('errors').textContent").as_str().unwrap().contains("did you mean \"sphere\"?"));
    assert_eq!(page.value("of('picture').width"), 60);
    page.viewer.write(SCENE);
    page.browser.wait_for("of('error').hidden");
    page.finish();
    page.close();
}

#[test]
fn the_camera_is_written_when_the_lines_have_been_seen() {
    let Some(mut page) = Opened::new() else { return };
    let written = SCENE.replace("fov\" 40", "fov\" 55");
    page.enter("fov-", 55.0);
    page.browser.wait_for("of('fov-').closest('.field').hasAttribute('data-set')");
    page.value("of('write').click()");
    page.browser.wait_for("of('changes').open");
    let lines = page.value("of('lines').textContent");
    let (before, after) =
        ("- Camera \"perspective\" \"float fov\" 40", "+ Camera \"perspective\" \"float fov\" 55");
    assert!([before, after, "scene.pbrt:2"].iter().all(|it| lines.as_str().unwrap().contains(it)), "{lines}");
    page.value("of('changes').querySelector('button[value=\"\"]').click()");
    page.browser.wait_for("!of('changes').open");
    assert_eq!(page.viewer.text(), SCENE);
    page.value("of('write').click()");
    page.browser.wait_for("of('changes').open");
    page.value("of('changes').querySelector('button[value=write]').click()");
    page.browser.wait_for("!of('undo').disabled && !of('fov-').closest('.field').hasAttribute('data-set')");
    assert_eq!(page.viewer.text(), written);
    page.value("of('undo').click()");
    page.browser.wait_for("of('undo').disabled && of('fov-').valueAsNumber === 40");
    assert_eq!(page.viewer.text(), SCENE);
    page.value("of('redo').click()");
    page.browser.wait_for("of('redo').disabled && of('fov-').valueAsNumber === 55");
    assert_eq!(page.viewer.text(), written);
    page.close();
}

#[test]
fn a_material_changes_in_a_panel() {
    let Some(mut page) = Opened::new() else { return };
    let middle = page.place(0.5, 0.5);
    page.browser.click(middle);
    page.browser.wait_for("of('directives').textContent.includes('Material \"matte\"')");
    let field = |label: &str| format!("of('directives').querySelector('[aria-label=\"{label}\"]')");
    let [red, sigma, slider] = ["Kd red", "sigma", "sigma slider"].map(field);
    assert_eq!(page.value(&format!("[{red}.valueAsNumber, {sigma}.placeholder]")), json!([0.5, "0"]));
    page.value(&format!("{red}.value = 0.1; {red}.dispatchEvent(new Event('change'))"));
    page.browser.wait_for("!of('discard').disabled");
    // The others keep all their digits.
    page.value("of('write').click()");
    page.browser.wait_for("of('changes').open && of('lines').textContent.includes('+ Material \"matte\" \"rgb Kd\" [0.1 .4 .312345678]')");
    page.value("of('changes').querySelector('button[value=\"\"]').click()");
    page.value(&format!(
        "{slider}.max = 90; {slider}.value = 45; {slider}.dispatchEvent(new Event('input'))"
    ));
    page.browser.wait_for(&format!("{sigma}.valueAsNumber === 45"));
    // The sphere is bluish now.
    let color = "[...of('picture').getContext('2d').getImageData(30, 20, 1, 1).data]";
    page.finish();
    let color = page.value(color);
    assert!(color[0].as_f64() < color[2].as_f64(), "{color}");
    let light = "of('lights').querySelector('[aria-label=\"L red\"]')";
    page.value(&format!("{light}.value = 1e30; {light}.dispatchEvent(new Event('change'))"));
    page.browser.wait_for("of('lights').querySelector('.remark').textContent.includes('1e18')");
    assert_eq!(page.viewer.text(), SCENE);
    page.value("of('discard').click()");
    page.browser.wait_for(&format!("of('discard').disabled && {red}.valueAsNumber === 0.5"));
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

#[test]
fn two_windows_show_the_same() {
    let Some(mut page) = Opened::new() else { return };
    let program = browser::find().unwrap();
    let mut other = Browser::start(&program);
    other.visit(&format!("http://{}/{}/", page.viewer.host, page.viewer.token));
    other.evaluate("window.of = (id) => document.getElementById(id)");
    other.wait_for("of('fov-')?.valueAsNumber === 40");
    page.enter("fov-", 55.0);
    other.wait_for("of('fov-').valueAsNumber === 55");
    other.evaluate("of('fov-').value = 200; of('fov-').dispatchEvent(new Event('change'))");
    other.wait_for("of('refused').textContent.includes('below 180 degrees')");
    assert_eq!(page.value("of('refused').textContent"), "");
    page.finish();
    other.wait_for("of('samples').textContent.startsWith('finished: 4 of 4 samples')");
    assert!(other.faults.is_empty());
    page.close();
}

#[test]
fn a_file_disappears_and_comes_back() {
    let Some(mut page) = Opened::new() else { return };
    std::fs::remove_file(&page.viewer.scene).unwrap();
    page.browser.wait_for("!of('error').hidden && of('errors').textContent.includes('cannot read')");
    assert_eq!(page.value("of('picture').width"), 60);
    page.enter("fov-", 50.0);
    page.finish();
    page.viewer.write(SCENE);
    page.browser.wait_for("of('error').hidden");
    page.finish();
    page.browser.wait_for("of('fov-').valueAsNumber === 50");
    page.close();
}

#[test]
fn exposure_needs_no_rendering() {
    let Some(mut page) = Opened::new() else { return };
    let color = "[...of('picture').getContext('2d').getImageData(1, 1, 1, 1).data]";
    assert_eq!(page.value(color), json!([137, 137, 137, 255]));
    page.value("of('exposure').value = 1; of('exposure').dispatchEvent(new Event('input'))");
    assert_eq!(page.value(color), json!([188, 188, 188, 255]));
    page.value("of('curve').value = 'reinhard'; of('curve').dispatchEvent(new Event('change'))");
    // 0.5 * (1 + 0.5 / 16) / 1.5 = 0.34375
    assert_eq!(page.value(color), json!([158, 158, 158, 255]));
    page.close();
}

#[test]
fn channels_false_color_and_values() {
    let Some(mut page) = Opened::new() else { return };
    assert_eq!(page.color([1, 1]), [137; 3]);
    let middle = page.color([30, 20]);
    assert!(middle[0] > middle[1] && middle[1] > middle[2]);
    for (channel, c) in [("red", 0), ("green", 1), ("blue", 2)] {
        page.choose("channel", channel);
        assert_eq!(page.color([30, 20]), [middle[c]; 3], "{channel}");
    }
    page.choose("channel", "false color");
    // A luminance of 2^-2, 6 of 10 stops from the end, within rounding: 1/4 is not exact in three coefficients.
    let ramp = "import(new URL('ramp.js', location.href)).then(({ AMOUNTS }) => [614, 615].map((i) => AMOUNTS.colors[i]))";
    let colors = page.value(ramp);
    let [red, green, blue] = page.color([1, 1]);
    let found = json!((255_u64 << 24) | blue << 16 | green << 8 | red);
    assert!(colors.as_array().unwrap().contains(&found), "{found} {colors}");
    assert_eq!([page.text("least"), page.text("most")], ["0.00391", "4.00"]);
    page.value("of('exposure').value = 1; of('exposure').dispatchEvent(new Event('input'))");
    assert_eq!([page.text("least"), page.text("most")], ["0.00195", "2.00"]);
    // All digits of the pixel under the mouse.
    let [x, y] = page.place(1.5 / 60.0, 1.5 / 40.0);
    page.browser.mouse("mouseMoved", [x, y]);
    page.browser.wait_for("of('pixel').textContent.includes('1, 1')");
    let text = page.text("pixel");
    assert!(text.split_whitespace().eq(["x,", "y", "1,", "1", "picture", "0.25", "0.25", "0.25"]), "{text}");
    page.close();
}

/// The camera stays where it is.
#[test]
fn a_zoomed_picture_moves_by_mouse_and_keys() {
    let Some(mut page) = Opened::new() else { return };
    let wheel = |page: &mut Opened, place: [f64; 2], turn: i32, modifiers: u32| {
        let [x, y] = place;
        let event = json!({"type": "mouseWheel", "x": x, "y": y, "deltaX": 0, "deltaY": turn, "modifiers": modifiers});
        page.browser.call("Input.dispatchMouseEvent", event);
    };
    let place = page.place(0.25, 0.25);
    wheel(&mut page, place, -100, 2);
    page.browser.wait_for("of('zoom').value === '16'");
    // With Ctrl: what is under the pointer stays there.
    let place = page.place(0.25, 0.25);
    wheel(&mut page, place, -100, 2);
    page.browser.wait_for("of('zoom').value === '32'");
    let after = page.place(0.25, 0.25);
    assert!(place.iter().zip(after).all(|(a, b)| (a - b).abs() < 2.0), "{place:?} {after:?}");
    assert_eq!(page.value("of('frame').clientWidth"), 60 * 32);
    assert_eq!(page.value("of('frame').hasAttribute('data-magnified')"), true);
    page.value("of('frame').focus()");
    page.browser.press("h", 72);
    page.browser.wait_for("of('drag').value === 'picture'");
    let from = page.place(0.25, 0.25);
    page.drag(from, [from[0] - 100.0, from[1] - 50.0]);
    let moved = page.place(0.25, 0.25);
    assert!((from[0] - moved[0] - 100.0).abs() < 2.0 && (from[1] - moved[1] - 50.0).abs() < 2.0, "{moved:?}");
    // Arrows go from pixel to pixel, and the picture follows.
    page.browser.press("ArrowRight", 39);
    let before = page.text("pixel");
    page.browser.press("ArrowRight", 39);
    let next = page.text("pixel");
    let column =
        |text: &str| text.split_whitespace().nth(2).unwrap().trim_end_matches(',').parse::<u32>().unwrap();
    assert_eq!(column(&before) + 1, column(&next), "{before} {next}");
    (0..60).for_each(|_| page.browser.press("ArrowRight", 39));
    assert_eq!(column(&page.text("pixel")), 59);
    let right = "of('frame').getBoundingClientRect().right <= of('room').getBoundingClientRect().right + 1";
    assert_eq!(page.value(right), true);
    page.browser.press("-", 189);
    page.browser.wait_for("of('zoom').value === '16'");
    page.browser.press("0", 48);
    page.browser.wait_for("of('zoom').value === '0'");
    assert_eq!([page.number("eye-x"), page.number("eye-z")], [0.0, -5.0]);
    page.close();
}

#[test]
fn a_reference_is_compared_with() {
    let Some(mut page) = Opened::new() else { return };
    page.value("of('keep').click()");
    page.browser.wait_for("of('reference').textContent === 'kept picture'");
    page.browser.wait_for("of('measures').textContent.includes('rmse            0 ')");
    let sky = page.color([1, 1]);
    page.viewer.write(&SCENE.replace("[.25 .25 .25]", "[.5 .25 .25]"));
    page.browser
        .wait_for("of('measures').textContent && !of('measures').textContent.includes('rmse            0 ')");
    assert_eq!(page.color([1, 1]), [188, 137, 137]);
    page.choose("show", "reference");
    assert_eq!(page.color([1, 1]), sky);
    page.choose("show", "wipe");
    assert_eq!([page.color([28, 1]), page.color([32, 1])], [sky, [188, 137, 137]]);
    // By keys, and by dragging the divider, which does not move the camera.
    page.value("of('wipe').focus()");
    (0..20).for_each(|_| page.browser.press("ArrowLeft", 37));
    page.browser.wait_for("of('wipe').valueAsNumber < 40");
    assert_eq!(page.color([28, 1]), [188, 137, 137]);
    let share = page.value("of('wipe').valueAsNumber / 100").as_f64().unwrap();
    let [from, to] = [page.place(share, 0.5), page.place(0.9, 0.5)];
    page.drag(from, to);
    page.browser.wait_for("of('wipe').valueAsNumber > 85");
    assert_eq!(page.color([50, 1]), sky);
    assert_eq!(page.number("eye-x"), 0.0);
    page.choose("show", "difference");
    let (brighter, least) = (page.color([1, 1]), page.text("least"));
    assert!(brighter[0] > brighter[2] + 50, "{brighter:?}");
    assert_eq!((least, page.text("most")), ("\u{2212}0.500".into(), "+0.500".into()));
    let [x, y] = page.place(0.02, 0.02);
    page.browser.mouse("mouseMoved", [x, y]);
    page.browser.wait_for("of('pixel').textContent.includes('difference')");
    let text = page.text("pixel").split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.ends_with("picture 0.5 0.25 0.25 reference 0.25 0.25 0.25 difference 0.25 0 0"), "{text}");
    // With errors of both, the verdict.
    page.value("of('error-layers').click()");
    page.browser.wait_for("of('error-layers').checked && of('verdict').textContent.startsWith('measured')");
    page.viewer.write(&SCENE.replace("pixelsamples\" 4", "pixelsamples\" 64"));
    page.browser.wait_for("of('samples').textContent.startsWith('finished: 64 of 64 samples')");
    page.value("of('keep').click()");
    page.browser.wait_for("of('verdict').className === 'agrees'");
    page.value("of('forget').click()");
    page.browser.wait_for("of('show').value === 'picture' && of('show').options[3].disabled");
    page.close();
}

#[test]
fn layers_and_errors_are_shown() {
    let Some(mut page) = Opened::new() else { return };
    page.choose("show", "depth");
    page.browser.wait_for("!of('scale').hidden && of('scale-name').textContent === 'depth'");
    assert_eq!(page.color([1, 1]), [0; 3], "nothing is there");
    let near = page.color([30, 18]);
    assert!(near[0] > 200, "{near:?}");
    page.choose("show", "normal");
    let black = |x: u32| {
        format!(
            "String([...of('picture').getContext('2d').getImageData({x}, 20, 1, 1).data]) === '0,0,0,255'"
        )
    };
    page.browser.wait_for(&format!("of('scale').hidden && {}", black(1)));
    // It follows the camera, and is there while it moves.
    let facing = page.color([30, 20]);
    page.value("of('frame').focus()");
    (0..5).for_each(|_| page.browser.press("-", 189));
    page.browser.wait_for("of('eye-z').valueAsNumber < -8");
    page.browser.wait_for(&black(22));
    assert!(facing[2] < 60, "{facing:?}");
    page.value("of('reset').click()");
    page.finish();
    // A click shows all layers of a pixel.
    let middle = page.place(0.5, 0.5);
    page.browser.click(middle);
    page.browser.wait_for("of('values').textContent.includes('albedo')");
    let values = page.text("values");
    assert!(values.contains("albedo0.5 0.4 0.3") && values.contains("shape1material1"), "{values}");
    // The mark stays at the place of the click.
    let mark = page.place(0.5, 0.5);
    let aside = page.place(0.1, 0.1);
    page.browser.mouse("mouseMoved", aside);
    let left = page.value("of('mark').getBoundingClientRect().x + 7.5").as_f64().unwrap();
    assert!((left - mark[0]).abs() < 1.0, "{left} {mark:?}");
    page.choose("show", "errors");
    page.browser.wait_for(
        "of('error-layers').checked && of('scale-name').textContent === 'relative error' && !of('scale').hidden",
    );
    page.finish();
    assert_eq!([page.text("least"), page.text("most")], ["0.1 %", "100 %"]);
    page.browser.mouse("mouseMoved", middle);
    page.browser.wait_for("of('pixel').textContent.includes('replicates')");
    page.choose("show", "picture");
    page.value("of('error-layers').click()");
    page.browser.wait_for("!of('error-layers').checked");
    page.finish();
    page.close();
}

#[test]
fn pictures_are_saved() {
    let Some(mut page) = Opened::new() else { return };
    // What would be downloaded.
    let saved = "(async () => {
        let found;
        const click = HTMLAnchorElement.prototype.click;
        HTMLAnchorElement.prototype.click = function () { found = this; };
        of('save-shown').click();
        while (!found) await new Promise((done) => setTimeout(done, 10));
        HTMLAnchorElement.prototype.click = click;
        const image = new Image();
        await new Promise((done) => { image.onload = done; image.src = found.href; });
        return [found.download, image.naturalWidth, image.naturalHeight];
    })()";
    assert_eq!(page.value(saved), json!(["scene-shown.png", 60, 40]));
    for kind in ["exr", "png"] {
        let link = format!(
            "fetch(of('save-{kind}').href).then((answer) => [of('save-{kind}').download, answer.status])"
        );
        assert_eq!(page.value(&link), json!([format!("scene.{kind}"), 200]));
    }
    page.close();
}

#[test]
fn everything_has_a_label_and_fits() {
    let Some(mut page) = Opened::new() else { return };
    for (width, height) in [(1280, 800), (400, 800)] {
        page.browser.resize(width, height);
        assert_eq!(page.value("document.documentElement.scrollWidth"), width, "{width}");
    }
    let unnamed = "[...document.querySelectorAll('input, select, button')]
        .filter((e) => !(e.labels?.length || e.getAttribute('aria-label') || e.textContent.trim())).length";
    assert_eq!(page.value(unnamed), 0);
    let twice = "[...document.querySelectorAll('[id]')].filter((e) => of(e.id) !== e).map((e) => e.id)";
    assert_eq!(page.value(twice), json!([]));
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
