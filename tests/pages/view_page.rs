//! The page of `lookat view`, in a browser. Without one, the tests are skipped, except in CI.

mod camera;
mod files;
mod looking;

use crate::browser::{self, Browser};
use crate::viewer::Viewer;
use serde_json::{Value, json};

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
        let program = browser::find()?;
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
