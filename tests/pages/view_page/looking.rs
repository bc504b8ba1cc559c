//! Looking at the picture closely, and how the page is arranged.

use serde_json::json;

use super::{Opened, SCENE};

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
