//! `lookat compare`: how far a picture is from another one.

use std::fmt::Write;
use std::process::ExitCode;

use lookat_image::{
    Aligned, Encoded, Image, PIXELS_PER_DEGREE, align, hdr_flip, largest_difference, ldr_flip, means,
    percentile_difference, psnr, relative_mse_trimmed, rmse, share_above, ssim,
};
use serde_json::{Map, Value, json};

use crate::args::Compare;

/// A number that says how far pictures are apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Metric {
    Error,
    Mae,
    Rmse,
    RelMse,
    RelMseTrimmed,
    Smape,
    P99,
    Max,
    ShareAbove,
    Psnr,
    Ssim,
    Flip,
    HdrFlip,
}

impl Metric {
    /// Each with its name and what it is.
    const ALL: [(Metric, &'static str, &'static str); 13] = [
        (Metric::Error, "error", "mean signed error"),
        (Metric::Mae, "mae", "mean absolute error"),
        (Metric::Rmse, "rmse", "root mean squared error"),
        (Metric::RelMse, "relmse", "relative MSE, with 0.01 in the denominator"),
        (Metric::RelMseTrimmed, "relmse-trimmed", "the same without the worst 0.1 % of pixels"),
        (Metric::Smape, "smape", "symmetric relative error, 0 to 2"),
        (Metric::P99, "p99", "99th percentile of the difference"),
        (Metric::Max, "max", "largest difference"),
        (Metric::ShareAbove, "share-above", "share of pixels above the threshold"),
        (Metric::Psnr, "psnr", "PSNR in dB, of sRGB"),
        (Metric::Ssim, "ssim", "structural similarity of sRGB, to 1"),
        (Metric::Flip, "flip", "mean FLIP, 0 to 1"),
        (Metric::HdrFlip, "hdr-flip", "mean HDR-FLIP, 0 to 1"),
    ];

    pub fn from_name(name: &str) -> Option<Metric> {
        Metric::ALL.iter().find(|(_, known, _)| *known == name).map(|(metric, ..)| *metric)
    }

    pub fn names() -> String {
        Metric::ALL.map(|(_, name, _)| name).join(", ")
    }

    /// Whether more is better.
    fn is_likeness(self) -> bool {
        matches!(self, Metric::Psnr | Metric::Ssim)
    }

    /// Whether `value` is as good as `limit`.
    fn holds(self, value: f64, limit: f64) -> bool {
        if self.is_likeness() { value >= limit } else { value.abs() <= limit }
    }
}

/// One line of the result.
struct Measured {
    metric: Metric,
    value: f64,
    /// What else there is to say.
    remark: String,
}

/// Runs the command.
pub fn compare(arguments: &Compare) -> ExitCode {
    let pair = match load(arguments) {
        Ok(pair) => pair,
        Err(message) => {
            crate::say(&format!("error: {message}"));
            return ExitCode::from(crate::TROUBLE);
        }
    };
    let faults = [(&arguments.actual, &pair.actual), (&arguments.expected, &pair.expected)]
        .map(|(path, pixels)| (path.display().to_string(), not_finite(pixels, &pair)));
    let broken = faults.iter().any(|(_, fault)| fault.is_some());
    // No other number means anything then.
    let measured = if broken { Vec::new() } else { measure(arguments, &pair) };
    let exceeded = |m: &Measured| {
        arguments.max.iter().any(|(metric, limit)| *metric == m.metric && !metric.holds(m.value, *limit))
    };
    let printed = if arguments.json {
        crate::print_json(&as_json(&pair, &faults, &measured, &exceeded))
    } else {
        crate::print(&as_text(&pair, &faults, &measured, &exceeded))
    };
    let differs = broken || measured.iter().any(exceeded);
    ExitCode::from(if printed { u8::from(differs) } else { crate::TROUBLE })
}

fn load(arguments: &Compare) -> Result<Aligned, String> {
    let read = |path| Image::read(path).map_err(|error| error.to_string());
    let (actual, expected) = (read(&arguments.actual)?, read(&arguments.expected)?);
    align(&actual, &expected).map_err(|error| error.to_string())
}

/// How many pixels are infinite or not a number, and where the first is.
fn not_finite(pixels: &[[f32; 3]], pair: &Aligned) -> Option<(usize, [i32; 2])> {
    let bad = |pixel: &&[f32; 3]| !pixel.iter().all(|value| value.is_finite());
    let first = pixels.iter().position(|pixel| bad(&pixel))?;
    Some((pixels.iter().filter(bad).count(), place(first, pair)))
}

/// The place in the full picture of a pixel of the pair.
fn place(index: usize, pair: &Aligned) -> [i32; 2] {
    let width = pair.window.width as usize;
    [pair.window.x + (index % width) as i32, pair.window.y + (index / width) as i32]
}

/// The metrics that are asked for, and nothing else.
fn measure(arguments: &Compare, pair: &Aligned) -> Vec<Measured> {
    let asked = |metric: Metric| {
        arguments.only.is_empty()
            || arguments.only.contains(&metric)
            || arguments.max.iter().any(|(limited, _)| *limited == metric)
    };
    let (a, b) = (&pair.actual[..], &pair.expected[..]);
    let (width, height) = (pair.window.width as usize, pair.window.height as usize);
    let in_means = [Metric::Error, Metric::Mae, Metric::RelMse, Metric::Smape];
    let means = in_means.into_iter().any(asked).then(|| means(a, b));
    let shown = (asked(Metric::Psnr) || asked(Metric::Ssim)).then(|| [a, b].map(Encoded::from_linear));
    let mut measured = Vec::new();
    for (metric, ..) in Metric::ALL.into_iter().filter(|(metric, ..)| asked(*metric)) {
        let mut remark = String::new();
        let value = match metric {
            Metric::Error => means.as_ref().map(|means| {
                remark = format!("standard error {:.3e}, if pixels are independent", means.standard_error);
                means.error
            }),
            Metric::Mae => means.as_ref().map(|means| means.absolute),
            Metric::Rmse => Some(means.as_ref().map_or_else(|| rmse(a, b), |means| means.rmse)),
            Metric::RelMse => means.as_ref().map(|means| means.relative_mse),
            Metric::Smape => means.as_ref().map(|means| means.smape),
            Metric::RelMseTrimmed => Some(relative_mse_trimmed(a, b)),
            Metric::P99 => Some(percentile_difference(a, b, 0.99).into()),
            Metric::Max => {
                let largest = largest_difference(a, b, width);
                let [x, y] = place(largest.y * width + largest.x, pair);
                remark = format!("at x {x}, y {y}, {}", ["red", "green", "blue"][largest.channel]);
                Some(largest.difference.into())
            }
            Metric::ShareAbove => {
                remark = format!("above {}", arguments.threshold);
                Some(share_above(a, b, arguments.threshold))
            }
            Metric::Psnr => shown.as_ref().map(|[a, b]| psnr(a, b)),
            // Pictures of less than 11 pixels have none.
            Metric::Ssim => shown.as_ref().and_then(|[a, b]| ssim(a, b, width, height)),
            Metric::Flip => Some(ldr_flip(a, b, width, height, PIXELS_PER_DEGREE)),
            Metric::HdrFlip => Some(hdr_flip(a, b, width, height, PIXELS_PER_DEGREE)),
        };
        measured.extend(value.map(|value| Measured { metric, value, remark }));
    }
    measured
}

type Faults = [(String, Option<(usize, [i32; 2])>); 2];

fn as_text(
    pair: &Aligned,
    faults: &Faults,
    measured: &[Measured],
    exceeded: &dyn Fn(&Measured) -> bool,
) -> String {
    let mut text = String::new();
    if pair.left_out > 0 {
        let count = pair.left_out;
        let _ = writeln!(text, "{count} pixels that only one of the pictures has are left out");
    }
    for (path, fault) in faults {
        if let Some((count, [x, y])) = fault {
            let pixels = if *count == 1 { "1 pixel is".into() } else { format!("{count} pixels are") };
            let _ = writeln!(text, "{path}: {pixels} infinite or not a number; first at x {x}, y {y}");
        }
    }
    for line in measured {
        let (_, name, meaning) = Metric::ALL[line.metric as usize];
        let mark = if exceeded(line) { "  <- beyond --max" } else { "" };
        let remark =
            if line.remark.is_empty() { meaning.into() } else { format!("{meaning}, {}", line.remark) };
        let _ = writeln!(text, "{name:15} {:<12.6} {remark}{mark}", line.value);
    }
    text
}

fn as_json(
    pair: &Aligned,
    faults: &Faults,
    measured: &[Measured],
    exceeded: &dyn Fn(&Measured) -> bool,
) -> Value {
    let name = |line: &Measured| Metric::ALL[line.metric as usize].1;
    // JSON has no infinity: the PSNR of equal pictures is null.
    let metrics: Map<String, Value> =
        measured.iter().map(|line| (name(line).into(), json!(line.value))).collect();
    let broken: Map<String, Value> = faults
        .iter()
        .filter_map(|(path, fault)| {
            fault.map(|(count, [x, y])| (path.clone(), json!({"pixels": count, "x": x, "y": y})))
        })
        .collect();
    json!({
        "pixels": pair.window.area(),
        "left_out": pair.left_out,
        "not_finite": broken,
        "metrics": metrics,
        "beyond_max": measured.iter().filter(|line| exceeded(line)).map(name).collect::<Vec<_>>(),
    })
}
