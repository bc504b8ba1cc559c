//! What to say of the tests for noise.

use std::fmt::Write;
use std::path::Path;

use lookat_image::{Agreement, Aligned, Test};
use serde_json::{Value, json};

use crate::metric::COLORS;

/// The probability of a false alarm, where no limit is given.
pub const SIGNIFICANCE: f64 = 0.01;

/// Whether the values of a file of this name are rounded to 8 bits.
pub fn is_rounded(path: &Path) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase();
    !["exr", "pfm", "hdr"].contains(&ending.as_str())
}

/// Whether the pictures agree, in lines.
pub fn as_text(pair: &Aligned, agreement: &Agreement, significance: f64) -> String {
    let mut text = String::new();
    let mut line = |words: String| {
        let subject = if text.is_empty() { "noise" } else { "" };
        let _ = writeln!(text, "{subject:15} {words}");
    };
    let tests = agreement.count();
    if agreement.holds(significance) {
        line(format!("agree: the differences may all be noise ({tests} tests, significance {significance})"));
    } else {
        line(format!("differ: by more than noise ({tests} tests, significance {significance})"));
        for_each_difference(agreement, significance, &mut line);
    }
    let [mean, tile] = visible(pair, agreement, significance);
    line(format!("a bias would show from {mean} of the picture, {tile} of a 16 x 16 tile"));
    if !agreement.expected_is_known {
        line("EXPECTED has no error layers: it is taken to be no noisier than ACTUAL".into());
    }
    text
}

/// Says which tests found a difference.
fn for_each_difference(agreement: &Agreement, significance: f64, say: &mut dyn FnMut(String)) {
    let corrected = significance / agreement.count() as f64;
    let difference = |test: &Test| {
        let Test { channel, difference, standard_error, .. } = test;
        format!("{} {difference:+.3e}, standard error {standard_error:.1e}", COLORS[*channel])
    };
    for test in agreement.means.iter().filter(|test| test.p < corrected) {
        say(format!("mean: {}", difference(test)));
    }
    let tiles = agreement.differing_tiles(significance);
    if let Some(worst) = tiles.first() {
        let (x, y) = (worst.window.x, worst.window.y);
        let count = agreement.tiles.len();
        say(format!(
            "tiles: {} of {count} differ; worst at x {x}, y {y}: {}",
            tiles.len(),
            difference(worst)
        ));
    }
    for test in agreement.pixels.iter().filter(|test| test.p < corrected) {
        say(format!("pixels: {} differs by {:.2} times its noise", COLORS[test.channel], test.ratio.sqrt()));
    }
}

/// The smallest bias of the mean and of a tile that would be found, by the mean of the expected picture.
fn visible(pair: &Aligned, agreement: &Agreement, significance: f64) -> [String; 2] {
    let values = pair.expected.as_flattened();
    let mean = values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len() as f64;
    let percent = |bias: f64| format!("{:.2} %", 100.0 * bias / mean.abs());
    [agreement.visible_in_mean(significance), agreement.visible_in_tile(significance)].map(percent)
}

/// The same for programs.
pub fn as_json(agreement: &Agreement, significance: f64) -> Value {
    let test = |test: &Test| {
        json!({
            "channel": COLORS[test.channel], "x": test.window.x, "y": test.window.y,
            "width": test.window.width, "height": test.window.height,
            "difference": test.difference, "standard_error": test.standard_error, "p": test.p,
        })
    };
    json!({
        "agree": agreement.holds(significance),
        "significance": significance,
        "tests": agreement.count(),
        "p": agreement.p,
        "expected_has_error_layers": agreement.expected_is_known,
        "means": agreement.means.iter().map(test).collect::<Vec<_>>(),
        "differing_tiles": agreement.differing_tiles(significance).iter().map(test).collect::<Vec<_>>(),
        "pixels": agreement.pixels.iter().map(|pixels| json!({
            "channel": COLORS[pixels.channel], "pixels": pixels.pixels, "ratio": pixels.ratio, "p": pixels.p,
        })).collect::<Vec<_>>(),
        "visible_in_mean": agreement.visible_in_mean(significance),
        "visible_in_tile": agreement.visible_in_tile(significance),
    })
}
