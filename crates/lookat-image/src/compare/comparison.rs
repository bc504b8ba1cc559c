//! Two pictures, and how they differ: the metrics, and whether noise explains it.

use std::collections::{BTreeMap, HashSet};

use serde::Serialize;

use super::metric::{COLORS, Limit, Measurement, Metric, measure, not_finite, why_not};
use super::{Agreement, Aligned, Test};
use crate::Window;

/// What is measured, and what is allowed.
#[derive(Debug, Clone, Copy)]
pub struct Rules<'a> {
    /// The limits.
    pub limits: &'a [Limit],
    /// All metrics if empty.
    pub only: &'a [Metric],
    /// Whether the pictures are layers, which have no error layers.
    pub is_layer: bool,
    /// The smallest channel difference that counts for [`Metric::ShareAbove`].
    pub threshold: f32,
}

/// Two pictures, and how they differ.
#[derive(Debug, Serialize)]
pub struct Comparison<'a> {
    /// Number of compared pixels.
    pub pixels: u64,
    /// Number of pixels in only one picture.
    pub left_out: u64,
    /// For each picture: number of infinite or NaN `pixels`, and `x`, `y` of the first.
    pub not_finite: BTreeMap<&'a str, NotFinite>,
    /// The metrics by [name](comparing.md#metrics).
    pub metrics: BTreeMap<&'static str, f64>,
    /// Names of the metrics over their `--max`.
    pub beyond_max: Vec<&'static str>,
    /// True if the exit status is 1.
    pub differs: bool,
    /// Result of the [noise tests](comparing.md#the-tests), or null.
    pub noise: Option<Noise>,
    /// Why there is none, or null.
    pub noise_unknown: Option<String>,
    #[serde(skip)]
    /// Their names.
    pub names: [&'a str; 2],
    #[serde(skip)]
    /// What was measured.
    pub rules: Rules<'a>,
    #[serde(skip)]
    /// Their common pixels.
    pub pair: &'a Aligned,
    #[serde(skip)]
    /// The metrics, and the noise test.
    pub measurement: Measurement,
}

/// Infinite or NaN pixels of a picture.
#[derive(Debug, Serialize)]
pub struct NotFinite {
    /// Their number.
    pub pixels: usize,
    /// Column of the first.
    pub x: i32,
    /// Row of the first.
    pub y: i32,
}

/// The result of the noise tests.
#[derive(Debug, Serialize)]
pub struct Noise {
    /// Whether noise explains the differences; null if [undecided](comparing.md#rare-light).
    pub agree: Option<bool>,
    /// The level of the tests.
    pub significance: f64,
    /// The p-value.
    pub p: f64,
    /// The p-value without possible rare light.
    pub p_without_rare: f64,
    /// Whether the reference has error layers.
    pub expected_has_error_layers: bool,
    /// Tests of the channel means.
    pub means: Vec<NoiseTest>,
    /// Tests by the scatter of pixel differences.
    pub paired: Vec<NoiseTest>,
    /// Tests of the tiles that differ.
    pub differing_tiles: Vec<NoiseTest>,
    /// For each `channel`: number of `pixels`, `ratio` of the differences to the noise, `p`.
    pub pixels: Vec<PixelNoise>,
    /// Smallest difference of the mean that the tests would find.
    pub visible_in_mean: f64,
    /// Smallest difference of a tile that the tests would find.
    pub visible_in_tile: f64,
    /// The differences found, the worst of each kind, in words.
    #[serde(skip)]
    pub lines: Vec<String>,
}

/// A test of a mean.
#[derive(Debug, Serialize)]
pub struct NoiseTest {
    /// `red`, `green` or `blue`.
    pub channel: &'static str,
    /// Left edge of the window.
    pub x: i32,
    /// Its top edge.
    pub y: i32,
    /// Its width.
    pub width: u32,
    /// Its height.
    pub height: u32,
    /// The mean difference.
    pub difference: f64,
    /// The standard error of the difference.
    pub standard_error: f64,
    /// The p-value.
    pub p: f64,
    /// The tail index of the pixels, or null if it is infinite.
    pub tail_index: f64,
}

/// A test of the pixels of a channel.
#[derive(Debug, Serialize)]
pub struct PixelNoise {
    /// `red`, `green` or `blue`.
    pub channel: &'static str,
    /// Number of pixels.
    pub pixels: usize,
    /// Ratio of the squared differences to the noise.
    pub ratio: f64,
    /// The p-value.
    pub p: f64,
}

/// The default probability of a false alarm.
pub const SIGNIFICANCE: f64 = 0.01;

/// The probability of a false alarm: the limit of noise-p, or [`SIGNIFICANCE`].
pub fn significance(limits: &[Limit]) -> f64 {
    let limit = limits.iter().find(|limit| limit.metric == Metric::NoiseP);
    limit.map_or(SIGNIFICANCE, |limit| limit.value)
}

impl<'a> Comparison<'a> {
    /// Measures. Fails if a limit cannot be measured.
    pub fn new(names: [&'a str; 2], pair: &'a Aligned, rules: Rules<'a>) -> Result<Comparison<'a>, String> {
        let faults = [&pair.actual, &pair.expected].map(|pixels| not_finite(pixels, pair));
        let broken = faults.iter().any(Option::is_some);
        let limited = |metric: Metric| rules.limits.iter().any(|limit| limit.metric == metric);
        let asked = |metric: Metric| rules.only.is_empty() || rules.only.contains(&metric) || limited(metric);
        // The error layers belong to the colors.
        let blind = |metric: Metric| metric == Metric::NoiseP && rules.is_layer;
        if rules.is_layer && limited(Metric::NoiseP) {
            return Err("noise-p does not work with --layer: the error layers belong to the colors".into());
        }
        // With a non-finite pixel, no metric has a meaning.
        let measurement =
            measure(pair, rules.threshold, &|metric| !broken && asked(metric) && !blind(metric));
        if let (Some(reason), false) = (measurement.lacks(rules.limits), broken) {
            return Err(reason);
        }
        let beyond = measurement.beyond(rules.limits);
        let significance = significance(rules.limits);
        let tested = measurement.agreement.as_ref();
        let broken_pictures = names.into_iter().zip(faults).filter_map(|(name, fault)| Some((name, fault?)));
        Ok(Comparison {
            pixels: pair.window.area(),
            left_out: pair.left_out,
            not_finite: broken_pictures
                .map(|(name, (pixels, [x, y]))| (name, NotFinite { pixels, x, y }))
                .collect(),
            metrics: measurement.metrics.iter().map(|line| (line.metric.name(), line.value)).collect(),
            differs: broken || !beyond.is_empty(),
            beyond_max: beyond.into_iter().map(Metric::name).collect(),
            noise: tested.and_then(|it| Some(Noise::new(it.as_ref().ok()?, significance))),
            noise_unknown: tested.and_then(|it| it.as_ref().err()).map(|reason| why_not(*reason)),
            names,
            rules,
            pair,
            measurement,
        })
    }

    /// Whether noise explains the differences. `None` if nobody can tell.
    pub fn agrees(&self) -> Option<bool> {
        self.noise.as_ref()?.agree
    }
}

impl Noise {
    fn new(agreement: &Agreement, significance: f64) -> Noise {
        let tests = |tests: &[Test]| tests.iter().map(NoiseTest::new).collect();
        let pixels = agreement.pixels.iter().map(|it| PixelNoise {
            channel: COLORS[it.channel],
            pixels: it.pixels,
            ratio: it.ratio,
            p: it.p,
        });
        let agree = agreement.holds(significance);
        let verdict = match agree {
            Some(true) => format!("agree: noise explains the differences (significance {significance})"),
            Some(false) => {
                format!("differ: noise does not explain the differences (significance {significance})")
            }
            None => format!("undecided: {}", undecided(agreement, significance)),
        };
        Noise {
            agree,
            significance,
            p: agreement.p,
            p_without_rare: agreement.p_without_rare,
            expected_has_error_layers: agreement.expected_is_known,
            means: tests(&agreement.means),
            paired: tests(&agreement.paired),
            differing_tiles: tests(&agreement.differing_tiles(significance)),
            pixels: pixels.collect(),
            visible_in_mean: agreement.visible_in_mean(significance),
            visible_in_tile: agreement.visible_in_tile(significance),
            lines: std::iter::once(verdict).chain(differences(agreement, significance)).collect(),
        }
    }
}

impl NoiseTest {
    fn new(test: &Test) -> NoiseTest {
        let Test { channel, window, difference, standard_error, p, tail_index, .. } = *test;
        let (channel, Window { x, y, width, height }) = (COLORS[channel], window);
        NoiseTest { channel, x, y, width, height, difference, standard_error, p, tail_index }
    }
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
