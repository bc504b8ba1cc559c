//! `lookat compare`: the difference between two pictures, and whether noise explains it.

use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;

use lookat_image::{
    AlignError, Aligned, Comparison, Format, Image, MemoryBudget, Metric, Noise, NotFinite, PanelOptions,
    PictureFile, Precision, Rules, Window, align, common_window, mean, number, write_panel,
};

use crate::args::{Compare, way_out};
use crate::failure::Failure;
use crate::output::{check_folder, check_inputs, write_result};
use crate::readable::{plural, visible};
use crate::source::{open_layer, several_channels};

/// Runs the command.
pub fn compare(arguments: &Compare) -> ExitCode {
    crate::exit_code(run(arguments))
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
        if arguments.json { crate::print_json(&comparison) } else { crate::print(&as_text(&comparison)) };
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

/// As the command prints it.
pub fn as_text(comparison: &Comparison) -> String {
    let mut text = String::new();
    for (i, _) in comparison.pair.is_placed.iter().enumerate().filter(|(_, is_placed)| **is_placed) {
        let (path, Window { x, y, width, height }) = (visible(comparison.names[i]), comparison.pair.window);
        let _ = writeln!(
            text,
            "{path} is compared with the {width} x {height} pixels that start at x {x}, y {y}"
        );
    }
    if comparison.left_out > 0 {
        let count = comparison.left_out;
        let _ = writeln!(text, "{count} pixels are in only one of the pictures and are ignored");
    }
    for (name, NotFinite { pixels, x, y }) in &comparison.not_finite {
        let (path, pixels) = (visible(name), plural(*pixels as u64, "pixel is", "pixels are"));
        let _ = writeln!(text, "{path}: {pixels} infinite or not a number; first at x {x}, y {y}");
    }
    for (i, count) in clipped(comparison.pair).into_iter().enumerate().filter(|(_, count)| *count > 0) {
        let path = visible(comparison.names[i]);
        let pixels = plural(count as u64, "pixel is", "pixels are");
        let _ = writeln!(
            text,
            "{path}: {pixels} clipped at 1, where the other picture is brighter; compare .exr files instead"
        );
    }
    for line in &comparison.measurement.metrics {
        let (name, meaning) = (line.metric.name(), line.metric.meaning());
        let mark = match comparison.beyond_max.contains(&name) {
            true if line.metric.is_likeness() => "  <- below the minimum",
            true => "  <- exceeds --max",
            false => "",
        };
        let remark =
            if line.remark.is_empty() { meaning.into() } else { format!("{meaning}, {}", line.remark) };
        let _ = writeln!(text, "{name:15} {:<12} {remark}{mark}", number(line.value));
    }
    if comparison.rules.only.contains(&Metric::Ssim) && comparison.not_finite.is_empty() {
        text.extend(comparison.measurement.why_without(Metric::Ssim).map(|reason| reason + "\n"));
    }
    if let Some(noise) = &comparison.noise {
        text += &noise_as_text(noise, comparison.pair);
    }
    if let Some(reason) = &comparison.noise_unknown {
        let _ = writeln!(text, "noise           cannot be distinguished from bias: {reason}");
    }
    text
}

fn noise_as_text(noise: &Noise, pair: &Aligned) -> String {
    let mut lines = noise.lines.clone();
    if pair.actual == pair.expected {
        lines[0] = "agree: the pictures are identical".into();
    }
    if noise.agree == Some(true) {
        let share = |bias: f64| match mean(&pair.expected).abs() {
            0.0 => number(bias),
            mean => format!("{:.2} % of the mean value", 100.0 * bias / mean),
        };
        let [mean, tile] = [noise.visible_in_mean, noise.visible_in_tile].map(share);
        lines.push(format!("smallest detectable bias: {mean}, {tile} within a 16 x 16 tile"));
    }
    if !noise.expected_has_error_layers {
        lines.push(
            "the expected picture has no error layers: its noise is estimated from the differences".into(),
        );
    }
    let subjects = std::iter::once("noise").chain(std::iter::repeat(""));
    subjects.zip(lines).map(|(subject, line)| format!("{subject:15} {line}\n")).collect()
}
