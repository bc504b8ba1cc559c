//! The page of `lookat verify --report`, in a browser. Without one, the tests are skipped, except in CI.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::browser::{self, Browser};
use lookat_image::{Image, Window};
use serde_json::{Value, json};
use tempfile::TempDir;

/// A scene of one color, and a reference that it differs from.
struct Case {
    name: &'static str,
    size: [u32; 2],
    actual: f32,
    expected: fn(u32, u32) -> f32,
}

/// All numbers are half floats.
const CASES: [Case; 5] = [
    Case { name: "even", size: [48, 32], actual: 0.25, expected: |_, _| 0.25 },
    Case {
        name: "steps & <b>\"quotes\"",
        size: [48, 32],
        actual: 0.25,
        expected: |x, y| (x + y) as f32 / 64.0,
    },
    Case {
        name: "bright",
        size: [16, 16],
        actual: 512.0,
        expected: |x, _| if x < 8 { 512.0 } else { 256.0 },
    },
    Case {
        name: "broken",
        size: [16, 16],
        actual: 0.25,
        expected: |x, y| if (x, y) == (3, 2) { f32::NAN } else { 0.25 },
    },
    Case { name: "large", size: [1200, 1000], actual: 0.5, expected: |x, _| x as f32 / 2048.0 },
];
const STEPS: &str = CASES[1].name;

impl Case {
    /// A scene in which there is nothing but a sky of one color.
    fn write(&self, folder: &Path) {
        let [width, height] = self.size;
        let scene = format!(
            "Camera \"perspective\" Sampler \"random\" \"integer pixelsamples\" 1 Integrator \"path\"
             Film \"image\" \"integer xresolution\" {width} \"integer yresolution\" {height}
             WorldBegin LightSource \"infinite\" \"rgb L\" [{0} {0} {0}] WorldEnd",
            self.actual
        );
        std::fs::write(folder.join(format!("{}.pbrt", self.name)), scene).unwrap();
        let window = Window { x: 0, y: 0, width, height };
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let pixels: Vec<[f32; 3]> = places.map(|(x, y)| [(self.expected)(x, y); 3]).collect();
        let file = folder.join(format!("{}.exr", self.name));
        Image::from_rgb(window, window, &pixels).write(&file).unwrap();
    }
}

/// Writes the page of all cases, and of a scene whose reference cannot be read.
fn report(folder: &Path) -> PathBuf {
    CASES.iter().for_each(|case| case.write(folder));
    std::fs::copy(folder.join("even.pbrt"), folder.join("lost.pbrt")).unwrap();
    std::fs::write(folder.join("lost.exr"), "not a picture").unwrap();
    let page = folder.join("page.html");
    let arguments = ["verify", folder.to_str().unwrap(), "--max", "rmse=0.001", "--report"];
    let output = Command::new(env!("CARGO_BIN_EXE_lookat")).args(arguments).arg(&page).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stderr));
    page
}

/// The page, open in a browser.
struct Opened {
    browser: Browser,
    _folder: TempDir,
}

impl Opened {
    fn new() -> Option<Opened> {
        let program = browser::find()?;
        let folder = tempfile::tempdir().unwrap();
        let page = report(folder.path());
        let mut browser = Browser::start(&program);
        browser.resize(1400, 900);
        browser.visit(&format!("file://{}", page.display()));
        // What the scripts of the checks have in common.
        browser.evaluate(
            "window.scene = (name) => [...document.querySelectorAll('article')]
                 .find((article) => article.querySelector('h2').textContent === name);
             window.painted = () => new Promise((done) =>
                 requestAnimationFrame(() => requestAnimationFrame(() => done(true))));",
        );
        Some(Opened { browser, _folder: folder })
    }

    /// Waits until the pictures of a scene are there.
    fn show(&mut self, name: &str) {
        let scene = json!(name);
        self.browser.evaluate(&format!("scene({scene}).scrollIntoView()"));
        self.browser.wait_for(&format!("'ready' in scene({scene}).querySelector('.viewer').dataset"));
    }

    /// The color of a pixel of a canvas.
    fn color(&mut self, name: &str, pane: &str, [x, y]: [u32; 2]) -> [u64; 3] {
        let (scene, canvas) = (json!(name), json!(format!("[data-shows={pane}] canvas")));
        let color = self.browser.evaluate(&format!(
            "painted().then(() => [...scene({scene}).querySelector({canvas}).getContext('2d')
                 .getImageData({x}, {y}, 1, 1).data])"
        ));
        assert_eq!(color[3], 255, "{name} {pane}");
        std::array::from_fn(|c| color[c].as_u64().unwrap())
    }

    /// Left, top, width and height of an element within a scene, in the window.
    fn bounds(&mut self, name: &str, selector: &str) -> [f64; 4] {
        let (scene, selector) = (json!(name), json!(selector));
        let bounds = self.browser.evaluate(&format!(
            "(({{ x, y, width, height }}) => [x, y, width, height])
                 (scene({scene}).querySelector({selector}).getBoundingClientRect())"
        ));
        std::array::from_fn(|i| bounds[i].as_f64().unwrap())
    }

    /// Sets a range as a person does: with an event.
    fn set(&mut self, range: &str, value: f64) {
        self.browser.evaluate(&format!(
            "{range}.value = {value}; {range}.dispatchEvent(new Event('input', {{bubbles: true}})); painted()"
        ));
    }

    fn names(&mut self, selector: &str) -> Value {
        let selector = json!(selector);
        self.browser
            .evaluate(&format!("[...document.querySelectorAll({selector})].map((e) => e.textContent)"))
    }

    /// Nothing went wrong on the way.
    fn close(self) {
        assert!(self.browser.faults.is_empty(), "{}", self.browser.faults.join("\n"));
    }
}

/// The sRGB level of a linear value.
fn level(linear: f32) -> [u64; 3] {
    let linear = f64::from(linear).clamp(0.0, 1.0);
    let curve = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    [(255.0 * curve).round() as u64; 3]
}

/// What the reference of `STEPS` has at a place.
fn expected([x, y]: [u32; 2]) -> f32 {
    (CASES[1].expected)(x, y)
}

#[test]
fn the_wipe_shows_expected_left_and_actual_right() {
    let Some(mut page) = Opened::new() else { return };
    page.show(STEPS);
    let (left, right) = ([3, 5], [44, 20]);
    assert_eq!(page.color(STEPS, "wipe", left), level(expected(left)));
    assert_eq!(page.color(STEPS, "wipe", right), level(0.25));
    let range = format!("scene({}).querySelector('figure > input')", json!(STEPS));
    page.set(&range, 0.0);
    assert_eq!(page.color(STEPS, "wipe", left), level(0.25));
    page.set(&range, 100.0);
    assert_eq!(page.color(STEPS, "wipe", right), level(expected(right)));

    // The mouse drags it, on the picture.
    let [x, y, width, height] = page.bounds(STEPS, "[data-shows=wipe] .frame");
    let at = |share: f64| [x + share * width, y + height / 2.0];
    page.browser.mouse("mousePressed", at(0.9));
    page.browser.mouse("mouseMoved", at(0.5));
    page.browser.mouse("mouseMoved", at(0.25));
    page.browser.mouse("mouseReleased", at(0.25));
    assert_eq!(page.color(STEPS, "wipe", [11, 3]), level(expected([11, 3])));
    assert_eq!(page.color(STEPS, "wipe", [13, 3]), level(0.25));
    // So do the arrow keys then.
    (0..4).for_each(|_| page.browser.press("ArrowRight", 39));
    assert_eq!(page.color(STEPS, "wipe", [13, 3]), level(expected([13, 3])));
    let percent = page.browser.evaluate(&format!("{range}.valueAsNumber"));
    assert!((percent.as_f64().unwrap() - 29.0).abs() < 0.5, "{percent}");
    page.close();
}

#[test]
fn exposure_multiplies_linear_values() {
    let Some(mut page) = Opened::new() else { return };
    page.show(STEPS);
    let place = [20, 11];
    let slider = "document.getElementById('exposure')";
    for stops in [1.0_f32, -3.25, 10.0, -10.0] {
        page.set(slider, stops.into());
        let gain = stops.exp2();
        assert_eq!(page.color(STEPS, "actual", place), level(gain * 0.25), "{stops}");
        for place in [place, [1, 0], [47, 31]] {
            assert_eq!(
                page.color(STEPS, "expected", place),
                level(gain * expected(place)),
                "{stops} {place:?}"
            );
        }
    }
    page.browser.evaluate("document.querySelector('.bar button').click()");
    assert_eq!(page.color(STEPS, "actual", place), level(0.25));

    // Each of many dark values is encoded exactly.
    page.set(slider, -2.0);
    page.show("large");
    let row = page.browser.evaluate(
        "Array.from(scene('large').querySelector('[data-shows=expected] canvas').getContext('2d')
             .getImageData(0, 0, 500, 1).data)",
    );
    for x in 0..500 {
        assert_eq!(row[4 * x], level((4 * x + 1) as f32 / 4096.0 / 4.0)[0], "{x}");
    }
    page.set(slider, 0.0);

    // A picture that would be white starts darker by a whole number of stops: 512 * 2^-9 is 1.
    page.show("bright");
    assert_eq!(page.color("bright", "expected", [2, 2]), level(1.0));
    assert_eq!(page.color("bright", "expected", [12, 2]), level(0.5));
    page.close();
}

#[test]
fn differences_are_exact_and_colored() {
    let Some(mut page) = Opened::new() else { return };
    page.show(STEPS);
    // Actual minus expected is 0 at x + y = 16; on one side red is most, on the other one blue.
    let [none, below, above] =
        [[10, 6], [47, 31], [0, 0]].map(|place| page.color(STEPS, "difference", place));
    assert!(none.iter().all(|level| *level > 220), "{none:?}");
    assert!(below[2] > below[0] + 50 && above[0] > above[2] + 20, "{below:?} {above:?}");
    page.browser.evaluate(&format!("scene({}).querySelector('.finer').click()", json!(STEPS)));
    assert_ne!(page.color(STEPS, "difference", [0, 0]), above, "half the range");

    // The numbers of the pixel under the mouse.
    let [x, y, width, height] = page.bounds(STEPS, "[data-shows=difference] .frame");
    page.browser.mouse("mouseMoved", [x + width * 40.5 / 48.0, y + height * 8.5 / 32.0]);
    let reading = format!("scene({}).querySelector('.reading').textContent", json!(STEPS));
    let numbers = page.browser.evaluate(&reading);
    let words: Vec<&str> = numbers.as_str().unwrap().split_whitespace().collect();
    let text = words.join(" ");
    let said =
        "x, y 40, 8 expected 0.750 0.750 0.750 actual 0.250 0.250 0.250 difference -0.500 -0.500 -0.500";
    assert_eq!(text, said);

    // What is not a number is magenta, where it is.
    page.show("broken");
    let colors = ["expected", "actual", "difference"].map(|pane| page.color("broken", pane, [3, 2]));
    assert_eq!(colors, [[255, 0, 255], level(0.25), [255, 0, 255]]);

    // A large picture is shown by means: of two by two pixels here.
    page.show("large");
    let size = page
        .browser
        .evaluate("(({width, height}) => [width, height])(scene('large').querySelector('canvas'))");
    assert_eq!(size, json!([600, 500]));
    assert_eq!(page.color("large", "expected", [301, 7]), level(602.5 / 2048.0));
    page.close();
}

#[test]
fn the_table_sorts_by_any_column() {
    let Some(mut page) = Opened::new() else { return };
    let rows = "tbody th";
    // Differing scenes by error, then trouble, then the rest; so are the scenes below.
    let start = page.names(rows);
    assert_eq!(start, json!(["large", STEPS, "bright", "broken", "lost", "even"]));
    assert_eq!(page.names("h2"), start);
    assert_eq!(page.names(".counts"), json!(["6 scenes: 1 agrees, 4 differ, 1 failed"]));

    let click = |page: &mut Opened, column: &str| {
        let column = json!(column);
        let place = page.browser.evaluate(&format!(
            "scrollTo(0, 0);
             (({{x, y, width, height}}) => [x + width / 2, y + height / 2])
                 ([...document.querySelectorAll('thead button')].find((button) => button.textContent === {column})
                     .getBoundingClientRect())"
        ));
        page.browser.click(std::array::from_fn(|i| place[i].as_f64().unwrap()));
    };
    let by_rmse = json!(["bright", STEPS, "large", "even", "broken", "lost"]);
    click(&mut page, "rmse");
    assert_eq!(page.names(rows), by_rmse);
    assert_eq!(page.names("h2"), by_rmse);
    click(&mut page, "rmse");
    assert_eq!(
        page.names(rows),
        json!(["even", "large", STEPS, "bright", "broken", "lost"]),
        "what has none is last"
    );
    click(&mut page, "scene");
    assert_eq!(page.names(rows), json!(["bright", "broken", "even", "large", "lost", STEPS]));

    // A row leads to its scene.
    page.browser.evaluate("document.querySelectorAll('tbody tr')[3].cells[3].click(); painted()");
    assert_eq!(page.browser.evaluate("document.querySelector(':target h2').textContent"), "large");
    page.close();
}

#[test]
fn it_looks_like_something() {
    let Some(mut page) = Opened::new() else { return };
    let title = page.browser.evaluate("document.title");
    assert!(title.as_str().unwrap().starts_with("lookat verify "), "{title}");
    for (width, scheme) in [(1400, "light"), (400, "dark")] {
        page.browser.resize(width, 900);
        page.browser.prefer(scheme);
        page.show(STEPS);
        page.browser.evaluate("painted()");
        let overflow = page.browser.evaluate("document.documentElement.scrollWidth - innerWidth");
        assert_eq!(overflow, 0, "at {width} pixels");
        let [x, y, picture_width, picture_height] = page.bounds(STEPS, "[data-shows=wipe] canvas");
        assert!(picture_width >= 0.75 * f64::from(width.min(640)), "{picture_width}");
        let bytes = page.browser.screenshot();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let frame = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((frame.width, frame.height), (width, 900));
        let samples = frame.color_type.samples();
        let color = |x: f64, y: f64| {
            let at = (y as usize * frame.width as usize + x as usize) * samples;
            [pixels[at], pixels[at + 1], pixels[at + 2]]
        };
        // 48 columns and 32 rows, of which the left half has a color for each of 55 diagonals.
        let colors: HashSet<[u8; 3]> = (0..48 * 32)
            .map(|i| [f64::from(i % 48) + 0.5, f64::from(i / 48) + 0.5])
            .map(|[column, row]| color(x + picture_width * column / 48.0, y + picture_height * row / 32.0))
            .collect();
        assert!(colors.len() > 40, "{} colors at {width} pixels", colors.len());
        // The rest of the page is of the scheme.
        assert_eq!(color(2.0, 800.0)[0] > 128, scheme == "light");
    }
    page.close();
}

#[test]
fn nothing_is_shown_before_it_is_near() {
    let Some(mut page) = Opened::new() else { return };
    page.browser.resize(1400, 300);
    page.browser.evaluate("scrollTo(0, 0); painted()");
    page.show("bright");
    assert_eq!(
        page.browser.evaluate("scene('even').querySelector('canvas').width"),
        300,
        "as browsers make it"
    );
    page.show("even");
    page.close();
}
