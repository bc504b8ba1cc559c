//! `lookat compare`: the difference between two pictures, and whether noise explains it.

use std::collections::{BTreeMap, HashSet};
use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;

use lookat_image::{
    Agreement, AlignError, Aligned, Format, Image, MemoryBudget, PanelOptions, PictureFile, Precision, Test,
    Window, align, common_window, mean, write_panel,
};
use serde::Serialize;

use crate::args::{Compare, way_out};
use crate::failure::Failure;
use crate::metric::{COLORS, Limit, Measurement, Metric, measure, not_finite, number, why_not};
use crate::output::{check_folder, check_inputs, write_result};
use crate::readable::{plural, visible};
use crate::source::{open_layer, several_channels};

/// Runs the command.
pub fn compare(arguments: &Compare) -> ExitCode {
    crate::exit_code(run(arguments))
}

/// What is measured, and what is allowed.
pub struct Rules<'a> {
    pub limits: &'a [Limit],
    /// All metrics if empty.
    pub only: &'a [Metric],
    /// Whether the pictures are layers, which have no error layers.
    pub is_layer: bool,
    pub threshold: f32,
}

/// Two pictures, and how they differ.
#[derive(Serialize)]
pub struct Comparison<'a> {
    /// Number of compared pixels.
    pixels: u64,
    /// Number of pixels in only one picture.
    left_out: u64,
    /// For each picture: number of infinite or NaN `pixels`, and `x`, `y` of the first.
    not_finite: BTreeMap<&'a str, NotFinite>,
    /// The metrics by [name](comparing.md#metrics).
    metrics: BTreeMap<&'static str, f64>,
    /// Names of the metrics over their `--max`.
    beyond_max: Vec<&'static str>,
    /// True if the exit status is 1.
    differs: bool,
    /// Result of the [noise tests](comparing.md#the-tests), or null.
    noise: Option<Noise>,
    /// Why there is none, or null.
    noise_unknown: Option<String>,
    #[serde(skip)]
    names: [&'a str; 2],
    #[serde(skip)]
    rules: Rules<'a>,
    #[serde(skip)]
    pair: &'a Aligned,
    #[serde(skip)]
    measurement: Measurement,
}

#[derive(Serialize)]
struct NotFinite {
    pixels: usize,
    x: i32,
    y: i32,
}

/// The result of the noise tests.
#[derive(Serialize)]
struct Noise {
    /// Whether noise explains the differences; null if [undecided](comparing.md#rare-light).
    agree: Option<bool>,
    /// The level of the tests.
    significance: f64,
    /// The p-value.
    p: f64,
    /// The p-value without possible rare light.
    p_without_rare: f64,
    /// Whether the reference has error layers.
    expected_has_error_layers: bool,
    /// Tests of the channel means.
    means: Vec<NoiseTest>,
    /// Tests by the scatter of pixel differences.
    paired: Vec<NoiseTest>,
    /// Tests of the tiles that differ.
    differing_tiles: Vec<NoiseTest>,
    /// For each `channel`: number of `pixels`, `ratio` of the differences to the noise, `p`.
    pixels: Vec<PixelNoise>,
    /// Smallest difference of the mean that the tests would find.
    visible_in_mean: f64,
    /// Smallest difference of a tile that the tests would find.
    visible_in_tile: f64,
    /// The differences found, the worst of each kind, in words.
    #[serde(skip)]
    lines: Vec<String>,
}

#[derive(Serialize)]
struct NoiseTest {
    /// `red`, `green` or `blue`.
    channel: &'static str,
    /// Left edge of the window.
    x: i32,
    /// Its top edge.
    y: i32,
    /// Its width.
    width: u32,
    /// Its height.
    height: u32,
    /// The mean difference.
    difference: f64,
    /// The standard error of the difference.
    standard_error: f64,
    /// The p-value.
    p: f64,
    /// The tail index of the pixels, or null if it is infinite.
    tail_index: f64,
}

#[derive(Serialize)]
struct PixelNoise {
    channel: &'static str,
    pixels: usize,
    ratio: f64,
    p: f64,
}

/// Compares and prints. Returns the exit status.
fn run(arguments: &Compare) -> Result<u8, Failure> {
    if let Some(file) = &arguments.picture {
        check_folder(file)?;
        check_inputs(file, [&arguments.actual, &arguments.expected])?;
        if Format::from_path(file) != Some(Format::Png) {
            let file = file.display();
            bail!("cannot write {file}: the name of this picture must end in .png");
        }
    }
    let pair = &load(arguments)?;
    // Written elsewhere, it is told after the numbers.
    let drawn = arguments.picture.as_ref().map_or(Ok(()), |file| draw(arguments, pair, file));
    let names = [&arguments.actual, &arguments.expected].map(|path| path.display().to_string());
    let rules = Rules {
        limits: &arguments.max,
        only: &arguments.only,
        is_layer: arguments.layer.is_some(),
        threshold: arguments.threshold,
    };
    let comparison = Comparison::new(names.each_ref().map(String::as_str), pair, rules)?;
    let printed =
        if arguments.json { crate::print_json(&comparison) } else { crate::print(&comparison.as_text()) };
    printed.and(drawn).map(|()| match comparison.differs {
        false if comparison.measurement.is_undecided(&arguments.max) => crate::TROUBLE,
        differs => u8::from(differs),
    })
}

fn load(arguments: &Compare) -> Result<Aligned, Failure> {
    let is_exr = |path: &Path| Format::from_path(path) == Some(Format::Exr);
    if arguments.layer.is_some() && !is_exr(&arguments.actual) && !is_exr(&arguments.expected) {
        bail!("--layer chooses a part of an EXR file, but neither picture is an EXR file");
    }
    let memory = &arguments.memory.budget();
    let files = [open(&arguments.actual, arguments, memory)?, open(&arguments.expected, arguments, memory)?];
    let window = common_window(files.each_ref().map(PictureFile::placement));
    let window = window?;
    check_memory(window, window.area().saturating_mul(PIXEL_BYTES), memory)?;
    let [actual, expected] = files.map(|file| file.read().map_err(|error| error.to_string()));
    let (actual, expected) = (actual?, expected?);
    // The pair is a copy: three colors of a gray pixel, too.
    let copy = |image: &Image| image.bytes() + 8 * image.data_window.area();
    check_memory(window, copy(&actual.0) + copy(&expected.0), memory)?;
    for (path, (image, _)) in [(&arguments.actual, &actual), (&arguments.expected, &expected)] {
        if arguments.layer.is_some() && image.rgb_planes().is_none() {
            return Err(several_channels(path, image, arguments.layer.as_deref()).into());
        }
    }
    let pair = align(&actual.0, &expected.0).map_err(|error| match error {
        AlignError::Channels(..) => format!("{error}; choose one with --layer"),
        _ => error.to_string(),
    })?;
    drop((actual, expected));
    let drawing = if arguments.picture.is_some() { DRAWING_BYTES } else { 0 };
    check_memory(window, window.area() * (pixel_bytes(&pair) + drawing), memory)?;
    Ok(pair)
}

/// Fails without enough memory to compare these pixels.
pub fn check_memory(window: Window, bytes: u64, memory: &MemoryBudget) -> Result<(), Failure> {
    let Window { width, height, .. } = window;
    let refused = |shortage| format!("comparing {width} x {height} pixels: {}", way_out(shortage));
    Ok(memory.reserve(bytes).map(drop).map_err(refused)?)
}

/// Measured bytes for each compared pixel: both pictures, and the working copies of FLIP and SSIM.
const PIXEL_BYTES: u64 = 80;
/// Measured bytes for each compared pixel, for the tests of [`agreement`](lookat_image::agreement), which need error layers.
const AGREEMENT_BYTES: u64 = 160;
/// Measured bytes for each compared pixel, for a figure with both pictures and their difference.
const DRAWING_BYTES: u64 = 40;

/// The bytes for each pixel of a pair, without a drawing.
pub fn pixel_bytes(pair: &Aligned) -> u64 {
    let has_errors = pair.actual_errors.is_some() || pair.expected_errors.is_some();
    PIXEL_BYTES + if has_errors { AGREEMENT_BYTES } else { 0 }
}

/// Opens the chosen layer. A file without layers counts as this layer.
fn open<'a>(path: &Path, arguments: &Compare, memory: &MemoryBudget) -> Result<PictureFile<'a>, Failure> {
    if path == Path::new("-") {
        bail!("compare does not read standard input: give the name of a file");
    }
    let file = match &arguments.layer {
        Some(layer) if Format::from_path(path) == Some(Format::Exr) => open_layer(path, layer, memory),
        _ => PictureFile::open(path, memory),
    };
    Ok(file?)
}

/// Draws both pictures and their difference.
fn draw(arguments: &Compare, pair: &Aligned, file: &Path) -> Result<(), Failure> {
    let [actual, expected] = [&arguments.actual, &arguments.expected].map(|path| path.display().to_string());
    let options = PanelOptions { actual, expected, exposure: arguments.exposure };
    write_result(file, |path| write_panel(pair, &options, path))
}

/// For each picture, the number of pixels clipped by an integer format where the other picture is brighter.
fn clipped(pair: &Aligned) -> [usize; 2] {
    if pair.precision != Precision::Integer {
        return [0; 2];
    }
    [(&pair.actual, &pair.expected), (&pair.expected, &pair.actual)].map(|(own, other)| {
        let is_clipped = |(own, other): (&f32, &f32)| *own == 1.0 && *other > 1.0;
        own.iter().zip(other).filter(|(own, other)| own.iter().zip(*other).any(is_clipped)).count()
    })
}

impl<'a> Comparison<'a> {
    /// Measures. Fails if a limit cannot be measured.
    pub fn new(names: [&'a str; 2], pair: &'a Aligned, rules: Rules<'a>) -> Result<Comparison<'a>, Failure> {
        let faults = [&pair.actual, &pair.expected].map(|pixels| not_finite(pixels, pair));
        let broken = faults.iter().any(Option::is_some);
        let limited = |metric: Metric| rules.limits.iter().any(|limit| limit.metric == metric);
        let asked = |metric: Metric| rules.only.is_empty() || rules.only.contains(&metric) || limited(metric);
        // The error layers belong to the colors.
        let blind = |metric: Metric| metric == Metric::NoiseP && rules.is_layer;
        if rules.is_layer && limited(Metric::NoiseP) {
            bail!("noise-p does not work with --layer: the error layers belong to the colors");
        }
        // With a non-finite pixel, no metric has a meaning.
        let measurement =
            measure(pair, rules.threshold, &|metric| !broken && asked(metric) && !blind(metric));
        if let (Some(reason), false) = (measurement.lacks(rules.limits), broken) {
            return Err(reason.into());
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

    /// As the command prints it.
    pub fn as_text(&self) -> String {
        let mut text = String::new();
        for (i, _) in self.pair.is_placed.iter().enumerate().filter(|(_, is_placed)| **is_placed) {
            let (path, Window { x, y, width, height }) = (visible(self.names[i]), self.pair.window);
            let _ = writeln!(
                text,
                "{path} is compared with the {width} x {height} pixels that start at x {x}, y {y}"
            );
        }
        if self.left_out > 0 {
            let count = self.left_out;
            let _ = writeln!(text, "{count} pixels are in only one of the pictures and are ignored");
        }
        for (name, NotFinite { pixels, x, y }) in &self.not_finite {
            let (path, pixels) = (visible(name), plural(*pixels as u64, "pixel is", "pixels are"));
            let _ = writeln!(text, "{path}: {pixels} infinite or not a number; first at x {x}, y {y}");
        }
        for (i, count) in clipped(self.pair).into_iter().enumerate().filter(|(_, count)| *count > 0) {
            let path = visible(self.names[i]);
            let pixels = plural(count as u64, "pixel is", "pixels are");
            let _ = writeln!(
                text,
                "{path}: {pixels} clipped at 1, where the other picture is brighter; compare .exr files instead"
            );
        }
        for line in &self.measurement.metrics {
            let (name, meaning) = (line.metric.name(), line.metric.meaning());
            let mark = match self.beyond_max.contains(&name) {
                true if line.metric.is_likeness() => "  <- below the minimum",
                true => "  <- exceeds --max",
                false => "",
            };
            let remark =
                if line.remark.is_empty() { meaning.into() } else { format!("{meaning}, {}", line.remark) };
            let _ = writeln!(text, "{name:15} {:<12} {remark}{mark}", number(line.value));
        }
        if self.rules.only.contains(&Metric::Ssim) && self.not_finite.is_empty() {
            text.extend(self.measurement.why_without(Metric::Ssim).map(|reason| reason + "\n"));
        }
        if let Some(noise) = &self.noise {
            text += &noise.as_text(self.pair);
        }
        if let Some(reason) = &self.noise_unknown {
            let _ = writeln!(text, "noise           cannot be distinguished from bias: {reason}");
        }
        text
    }
}

/// The default probability of a false alarm.
pub const SIGNIFICANCE: f64 = 0.01;

/// The probability of a false alarm: the limit of noise-p, or [`SIGNIFICANCE`].
pub fn significance(limits: &[Limit]) -> f64 {
    let limit = limits.iter().find(|limit| limit.metric == Metric::NoiseP);
    limit.map_or(SIGNIFICANCE, |limit| limit.value)
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

    fn as_text(&self, pair: &Aligned) -> String {
        let mut lines = self.lines.clone();
        if pair.actual == pair.expected {
            lines[0] = "agree: the pictures are identical".into();
        }
        if self.agree == Some(true) {
            let share = |bias: f64| match mean(&pair.expected).abs() {
                0.0 => number(bias),
                mean => format!("{:.2} % of the mean value", 100.0 * bias / mean),
            };
            let [mean, tile] = [self.visible_in_mean, self.visible_in_tile].map(share);
            lines.push(format!("smallest detectable bias: {mean}, {tile} within a 16 x 16 tile"));
        }
        if !self.expected_has_error_layers {
            lines.push(
                "the expected picture has no error layers: its noise is estimated from the differences"
                    .into(),
            );
        }
        let subjects = std::iter::once("noise").chain(std::iter::repeat(""));
        subjects.zip(lines).map(|(subject, line)| format!("{subject:15} {line}\n")).collect()
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
