//! The files of the page, inside the program.

/// A file of the page.
pub struct PageFile {
    pub name: &'static str,
    /// Its media type.
    pub kind: &'static str,
    pub text: &'static str,
}

const fn script(name: &'static str, text: &'static str) -> PageFile {
    PageFile { name, kind: "text/javascript; charset=utf-8", text }
}

const fn style(name: &'static str, text: &'static str) -> PageFile {
    PageFile { name, kind: "text/css; charset=utf-8", text }
}

/// The page has no name.
pub const FILES: &[PageFile] = &[
    PageFile { name: "", kind: "text/html; charset=utf-8", text: include_str!("../../page/index.html") },
    style("viewer.css", include_str!("../../page/viewer.css")),
    style("style.css", include_str!("../../page/style.css")),
    script("main.js", include_str!("../../page/main.js")),
    script("ask.js", include_str!("../../page/ask.js")),
    script("blur.js", include_str!("../../page/blur.js")),
    script("parameters.js", include_str!("../../page/parameters.js")),
    script("pointing.js", include_str!("../../page/pointing.js")),
    script("places.js", include_str!("../../page/places.js")),
    script("socket.js", include_str!("../../page/socket.js")),
    script("picture.js", include_str!("../../page/picture.js")),
    script("display.js", include_str!("../../page/display.js")),
    script("zoom.js", include_str!("../../page/zoom.js")),
    script("compare.js", include_str!("../../page/compare.js")),
    script("layers.js", include_str!("../../page/layers.js")),
    script("reading.js", include_str!("../../page/reading.js")),
    script("status.js", include_str!("../../page/status.js")),
    script("save.js", include_str!("../../page/save.js")),
    script("paint.js", include_str!("../../page/paint.js")),
    script("ramp.js", include_str!("../../page/ramp.js")),
    script("readout.js", include_str!("../../page/readout.js")),
    script("wipe.js", include_str!("../../page/wipe.js")),
    script("typing.js", include_str!("../../page/typing.js")),
    script("tone.js", include_str!("../../page/tone.js")),
    script("camera.js", include_str!("../../page/camera.js")),
    script("gestures.js", include_str!("../../page/gestures.js")),
    script("panel.js", include_str!("../../page/panel.js")),
    script("edit.js", include_str!("../../page/edit.js")),
];
