//! The output of the noise tests.

use std::collections::HashSet;
use std::fmt::Write;

use lookat_image::{Agreement, Aligned, Test, mean};
use serde_json::{Value, json};

use crate::metric::{COLORS, Limit, Metric, number};

/// The default probability of a false alarm.
pub const SIGNIFICANCE: f64 = 0.01;

/// The probability of a false alarm: the limit of noise-p, or [`SIGNIFICANCE`].
pub fn significance(limits: &[Limit]) -> f64 {
    let limit = limits.iter().find(|limit| limit.metric == Metric::NoiseP);
    limit.map_or(SIGNIFICANCE, |limit| limit.value)
}

/// The result of the noise tests as text.
pub fn as_text(pair: &Aligned, agreement: &Agreement, significance: f64) -> String {
    let mut lines = Vec::new();
    if pair.actual == pair.expected {
        lines.push("agree: the pictures are identical".into());
    } else {
        lines.push(match agreement.holds(significance) {
            Some(true) => format!("agree: noise explains the differences (significance {significance})"),
            Some(false) => {
                format!("differ: noise does not explain the differences (significance {significance})")
            }
            None => format!("undecided: {}", undecided(agreement, significance)),
        });
    }
    lines.extend(differences(agreement, significance));
    if agreement.holds(significance) == Some(true) {
        let [mean, tile] = visible(pair, agreement, significance);
        lines.push(format!("smallest detectable bias: {mean}, {tile} within a 16 x 16 tile"));
    }
    if !agreement.expected_is_known {
        lines.push(
            "the expected picture has no error layers: its noise is estimated from the differences".into(),
        );
    }
    let subjects = std::iter::once("noise").chain(std::iter::repeat(""));
    subjects.zip(lines).fold(String::new(), |mut text, (subject, line)| {
        let _ = writeln!(text, "{subject:15} {line}");
        text
    })
}

/// Why there is no verdict, and how to get one.
pub fn undecided(agreement: &Agreement, significance: f64) -> String {
    let index = agreement.tail_index(significance);
    format!(
        "only a few pixels differ, and the reference is brighter there (tail index {index:.2}): samples may rarely hit this \
         light; render more samples per pixel"
    )
}

/// The differences found, the worst of each kind.
pub fn differences(agreement: &Agreement, significance: f64) -> Vec<String> {
    let level = agreement.level_of_whole(significance);
    let difference = |test: &Test| {
        let Test { channel, difference, standard_error, .. } = test;
        format!("{} {difference:+.3e}, standard error {standard_error:.1e}", COLORS[*channel])
    };
    let worst = |tests: &[Test]| {
        tests.iter().filter(|test| test.p < level).min_by(|a, b| a.p.total_cmp(&b.p)).map(&difference)
    };
    let tiles = agreement.differing_tiles(significance);
    let places = |tests: &[Test]| {
        let corners: HashSet<[i32; 2]> = tests.iter().map(|test| [test.window.x, test.window.y]).collect();
        corners.len()
    };
    let (some, all) = (places(&tiles), places(&agreement.tiles));
    let mean = worst(&agreement.means).or_else(|| worst(&agreement.paired));
    let tile = tiles.first().map(|worst| {
        let (x, y) = (worst.window.x, worst.window.y);
        format!("tiles: {some} of {all} differ; worst at x {x}, y {y}: {}", difference(worst))
    });
    let pixels =
        agreement.pixels.iter().filter(|test| test.p < level).max_by(|a, b| a.ratio.total_cmp(&b.ratio));
    let pixels = pixels.map(|test| {
        format!("pixels: {} differs by {:.2} times its noise", COLORS[test.channel], test.ratio.sqrt())
    });
    mean.map(|mean| format!("mean: {mean}")).into_iter().chain(tile).chain(pixels).collect()
}

/// The smallest detectable bias of the mean and of a tile, relative to the mean of the expected picture.
fn visible(pair: &Aligned, agreement: &Agreement, significance: f64) -> [String; 2] {
    let share = |bias: f64| match mean(&pair.expected).abs() {
        0.0 => number(bias),
        mean => format!("{:.2} % of the mean value", 100.0 * bias / mean),
    };
    [agreement.visible_in_mean(significance), agreement.visible_in_tile(significance)].map(share)
}

/// The result of the noise tests as JSON.
pub fn as_json(agreement: &Agreement, significance: f64) -> Value {
    let test = |test: &Test| {
        json!({
            "channel": COLORS[test.channel], "x": test.window.x, "y": test.window.y,
            "width": test.window.width, "height": test.window.height,
            "difference": test.difference, "standard_error": test.standard_error, "p": test.p,
            "tail_index": test.tail_index,
        })
    };
    json!({
        "agree": agreement.holds(significance),
        "significance": significance,
        "p": agreement.p,
        "p_without_rare": agreement.p_without_rare,
        "expected_has_error_layers": agreement.expected_is_known,
        "means": agreement.means.iter().map(test).collect::<Vec<_>>(),
        "paired": agreement.paired.iter().map(test).collect::<Vec<_>>(),
        "differing_tiles": agreement.differing_tiles(significance).iter().map(test).collect::<Vec<_>>(),
        "pixels": agreement.pixels.iter().map(|pixels| json!({
            "channel": COLORS[pixels.channel], "pixels": pixels.pixels, "ratio": pixels.ratio, "p": pixels.p,
        })).collect::<Vec<_>>(),
        "visible_in_mean": agreement.visible_in_mean(significance),
        "visible_in_tile": agreement.visible_in_tile(significance),
    })
}
