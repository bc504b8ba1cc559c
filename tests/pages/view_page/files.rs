//! The files of the scene: errors, changes by hand, and what the page writes.

use serde_json::json;

use super::{Opened, SCENE};
use crate::browser::{self, Browser};

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
