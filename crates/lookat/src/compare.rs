//! `lookat compare`: the difference between two pictures.

use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;

use lookat_image::{
    AlignError, Aligned, Format, Image, MemoryBudget, PanelOptions, PictureFile, Precision, Window, align,
    common_window, write_panel,
};
use serde_json::{Map, Value, json};

use crate::args::{Compare, way_out};
use crate::metric::{Limit, Measurement, Metric, measure, not_finite, number, why_not};
use crate::noise;
use crate::output::{check_folder, check_inputs, write_result};
use crate::source::open_layer;
use crate::visible::visible;

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
pub struct Comparison<'a> {
    names: [&'a str; 2],
    rules: Rules<'a>,
    pair: &'a Aligned,
    /// For each picture, the number of non-finite pixels and the first of them.
    faults: [Option<(usize, [i32; 2])>; 2],
    measurement: Measurement,
    /// The metrics that exceed a limit.
    beyond: Vec<Metric>,
}

/// Compares and prints. Returns the exit status.
fn run(arguments: &Compare) -> Result<u8, String> {
    if let Some(file) = &arguments.picture {
        check_folder(file)?;
        check_inputs(file, [&arguments.actual, &arguments.expected])?;
        if Format::from_path(file) != Some(Format::Png) {
            let file = file.display();
            return Err(format!("cannot write {file}: the name of this picture must end in .png"));
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
    let printed = if arguments.json {
        crate::print_json(&comparison.as_json())
    } else {
        crate::print(&comparison.as_text())
    };
    printed.and(drawn).map(|()| match comparison.differs() {
        false if comparison.measurement.is_undecided(&arguments.max) => crate::TROUBLE,
        differs => u8::from(differs),
    })
}

fn load(arguments: &Compare) -> Result<Aligned, String> {
    let is_exr = |path: &Path| Format::from_path(path) == Some(Format::Exr);
    if arguments.layer.is_some() && !is_exr(&arguments.actual) && !is_exr(&arguments.expected) {
        return Err("--layer chooses a part of an EXR file, but neither picture is an EXR file".into());
    }
    let memory = &arguments.memory.budget();
    let files = [open(&arguments.actual, arguments, memory)?, open(&arguments.expected, arguments, memory)?];
    let window = common_window(files.each_ref().map(PictureFile::placement));
    let window = window.map_err(|error| error.to_string())?;
    check_memory(window, window.area().saturating_mul(PIXEL_BYTES), memory)?;
    let [actual, expected] = files.map(|file| file.read().map_err(|error| error.to_string()));
    let (actual, expected) = (actual?, expected?);
    // The pair is a copy: three colors of a gray pixel, too.
    let copy = |image: &Image| image.bytes() + 8 * image.data_window.area();
    check_memory(window, copy(&actual.0) + copy(&expected.0), memory)?;
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
pub fn check_memory(window: Window, bytes: u64, memory: &MemoryBudget) -> Result<(), String> {
    let Window { width, height, .. } = window;
    let refused = |shortage| format!("comparing {width} x {height} pixels: {}", way_out(shortage));
    memory.reserve(bytes).map(drop).map_err(refused)
}

/// Measured bytes for each compared pixel: both pictures, and the working copies of FLIP and SSIM.
const PIXEL_BYTES: u64 = 80;
/// The same for the tests of [`agreement`](lookat_image::agreement), which need error layers.
const AGREEMENT_BYTES: u64 = 160;
/// The same for a figure with both pictures and their difference.
const DRAWING_BYTES: u64 = 40;

/// The bytes for each pixel of a pair, without a drawing.
pub fn pixel_bytes(pair: &Aligned) -> u64 {
    let has_errors = pair.actual_errors.is_some() || pair.expected_errors.is_some();
    PIXEL_BYTES + if has_errors { AGREEMENT_BYTES } else { 0 }
}

/// Opens the chosen layer. A file without layers counts as this layer.
fn open<'a>(path: &Path, arguments: &Compare, memory: &MemoryBudget) -> Result<PictureFile<'a>, String> {
    if path == Path::new("-") {
        return Err("compare does not read standard input: give the name of a file".into());
    }
    let file = match &arguments.layer {
        Some(layer) if Format::from_path(path) == Some(Format::Exr) => open_layer(path, layer, memory),
        _ => PictureFile::open(path, memory),
    };
    file.map_err(|error| error.to_string())
}

/// Draws both pictures and their difference.
fn draw(arguments: &Compare, pair: &Aligned, file: &Path) -> Result<(), String> {
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

fn pixels_are(count: usize) -> String {
    if count == 1 { "1 pixel is".into() } else { format!("{count} pixels are") }
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
        Ok(Comparison { names, rules, pair, faults, measurement, beyond })
    }

    /// True if a limit is exceeded or a pixel is not finite.
    fn differs(&self) -> bool {
        !self.beyond.is_empty() || self.faults.iter().any(Option::is_some)
    }

    fn limits(&self) -> &[Limit] {
        self.rules.limits
    }

    /// Whether noise explains the differences. `None` if nobody can tell.
    pub fn agrees(&self) -> Option<bool> {
        self.measurement.agrees(self.significance())
    }

    fn significance(&self) -> f64 {
        noise::significance(self.limits())
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
        if self.pair.left_out > 0 {
            let count = self.pair.left_out;
            let _ = writeln!(text, "{count} pixels are in only one of the pictures and are ignored");
        }
        for (i, fault) in self.faults.iter().enumerate() {
            if let Some((count, [x, y])) = fault {
                let path = visible(self.names[i]);
                let pixels = pixels_are(*count);
                let _ = writeln!(text, "{path}: {pixels} infinite or not a number; first at x {x}, y {y}");
            }
        }
        for (i, count) in clipped(self.pair).into_iter().enumerate().filter(|(_, count)| *count > 0) {
            let path = visible(self.names[i]);
            let pixels = pixels_are(count);
            let _ = writeln!(
                text,
                "{path}: {pixels} clipped at 1, where the other picture is brighter; compare .exr files instead"
            );
        }
        for line in &self.measurement.metrics {
            let (name, meaning) = (line.metric.name(), line.metric.meaning());
            let mark = if self.beyond.contains(&line.metric) { "  <- exceeds --max" } else { "" };
            let remark =
                if line.remark.is_empty() { meaning.into() } else { format!("{meaning}, {}", line.remark) };
            let _ = writeln!(text, "{name:15} {:<12} {remark}{mark}", number(line.value));
        }
        let is_broken = self.faults.iter().any(Option::is_some);
        if self.rules.only.contains(&Metric::Ssim) && !is_broken {
            text.extend(self.measurement.why_without(Metric::Ssim).map(|reason| reason + "\n"));
        }
        match &self.measurement.agreement {
            Some(Ok(agreement)) => text += &noise::as_text(self.pair, agreement, self.significance()),
            Some(Err(reason)) => {
                let reason = why_not(*reason);
                let _ = writeln!(text, "noise           cannot be distinguished from bias: {reason}");
            }
            None => {}
        }
        text
    }

    fn as_json(&self) -> Value {
        // JSON has no infinity, so the PSNR of equal pictures is null.
        let metrics = self.measurement.metrics.iter();
        let metrics: Map<String, Value> =
            metrics.map(|line| (line.metric.name().into(), json!(line.value))).collect();
        let broken: Map<String, Value> = (0..2)
            .filter_map(|i| {
                let (count, [x, y]) = self.faults[i]?;
                Some((self.names[i].into(), json!({"pixels": count, "x": x, "y": y})))
            })
            .collect();
        let noise = self.measurement.agreement.as_ref();
        let unknown = noise.and_then(|noise| noise.as_ref().err());
        let noise = noise.and_then(|noise| noise.as_ref().ok());
        json!({
            "pixels": self.pair.window.area(),
            "left_out": self.pair.left_out,
            "not_finite": broken,
            "metrics": metrics,
            "beyond_max": self.beyond.iter().map(|metric| metric.name()).collect::<Vec<_>>(),
            "differs": self.differs(),
            "noise_unknown": unknown.map(|reason| why_not(*reason)),
            "noise": noise.map(|agreement| noise::as_json(agreement, self.significance())),
        })
    }
}
