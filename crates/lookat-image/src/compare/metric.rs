//! The metrics for differences between pictures.

use super::{
    Agreement, Aligned, Encoded, PIXELS_PER_DEGREE, Untestable, agreement, hdr_flip, largest_difference,
    ldr_flip, means, percentile_difference, psnr, relative_mse_trimmed, rmse, share_above, ssim,
};

/// A metric for the difference between two pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Metric {
    /// Mean signed error.
    Error,
    /// Mean absolute error.
    Mae,
    /// Root mean squared error.
    Rmse,
    /// Relative mean squared error.
    RelMse,
    /// The same without the worst 0.1 % of pixels.
    RelMseTrimmed,
    /// Symmetric relative error.
    Smape,
    /// 99th percentile of the difference.
    P99,
    /// Largest difference.
    Max,
    /// Share of pixels that differ by more than a threshold.
    ShareAbove,
    /// Peak signal-to-noise ratio of the sRGB pictures.
    Psnr,
    /// Structural similarity of the sRGB pictures.
    Ssim,
    /// Mean FLIP.
    Flip,
    /// Mean HDR-FLIP.
    HdrFlip,
    /// The p-value under noise only.
    NoiseP,
}

impl Metric {
    /// The metrics with their names and descriptions.
    const ALL: [(Metric, &'static str, &'static str); 14] = [
        (Metric::Error, "error", "mean signed error"),
        (Metric::Mae, "mae", "mean absolute error"),
        (Metric::Rmse, "rmse", "root mean squared error"),
        (Metric::RelMse, "relmse", "relative MSE, with 0.01 in the denominator"),
        (Metric::RelMseTrimmed, "relmse-trimmed", "relmse without the worst 0.1 % of pixels"),
        (Metric::Smape, "smape", "symmetric relative error, 0 to 2"),
        (Metric::P99, "p99", "99th percentile of the difference"),
        (Metric::Max, "max", "largest difference"),
        (Metric::ShareAbove, "share-above", "fraction of pixels above the threshold"),
        (Metric::Psnr, "psnr", "PSNR in dB, of sRGB"),
        (Metric::Ssim, "ssim", "structural similarity of sRGB, at most 1"),
        (Metric::Flip, "flip", "mean FLIP, 0 to 1"),
        (Metric::HdrFlip, "hdr-flip", "mean HDR-FLIP, 0 to 1"),
        (Metric::NoiseP, "noise-p", "p-value under noise only"),
    ];

    /// The metric of this name.
    pub fn from_name(name: &str) -> Option<Metric> {
        Metric::ALL.iter().find(|(_, known, _)| *known == name).map(|(metric, ..)| *metric)
    }

    /// The names of all metrics.
    pub fn names() -> [&'static str; 14] {
        Metric::ALL.map(|(_, name, _)| name)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        Metric::ALL[self as usize].1
    }

    /// Its meaning, in a few words.
    pub fn meaning(self) -> &'static str {
        Metric::ALL[self as usize].2
    }

    /// True if larger values are better.
    pub fn is_likeness(self) -> bool {
        matches!(self, Metric::Psnr | Metric::Ssim | Metric::NoiseP)
    }
}

/// The threshold of [`Metric::ShareAbove`], unless it is given.
pub const THRESHOLD: f32 = 0.01;

/// A limit of a metric: a maximum, or a minimum if larger values are better.
#[derive(Debug, Clone, Copy)]
pub struct Limit {
    /// The metric.
    pub metric: Metric,
    /// Its limit.
    pub value: f64,
}

/// One measured metric.
#[derive(Debug, Clone)]
pub struct Measured {
    /// The metric.
    pub metric: Metric,
    /// Its value.
    pub value: f64,
    /// A remark.
    pub remark: String,
}

/// The measured metrics.
#[derive(Debug)]
pub struct Measurement {
    /// The metrics, in the order of [`Metric`].
    pub metrics: Vec<Measured>,
    /// The result of the noise test, if requested.
    pub agreement: Option<Result<Agreement, Untestable>>,
}

impl Measurement {
    /// The measured metrics that exceed a limit.
    pub fn beyond(&self, limits: &[Limit]) -> Vec<Metric> {
        let exceeds = |line: &Measured, limit: f64| match line.metric {
            Metric::NoiseP => self.agrees(limit) == Some(false),
            metric if metric.is_likeness() => line.value < limit,
            _ => line.value.abs() > limit,
        };
        let is_beyond = |line: &&Measured| {
            limits.iter().any(|limit| limit.metric == line.metric && exceeds(line, limit.value))
        };
        self.metrics.iter().filter(is_beyond).map(|line| line.metric).collect()
    }

    /// Whether noise explains the differences. `None` if nobody can tell.
    pub fn agrees(&self, significance: f64) -> Option<bool> {
        self.agreement.as_ref()?.as_ref().ok()?.holds(significance)
    }

    /// True if there is a limit of noise-p, and the noise tests do not decide.
    pub fn is_undecided(&self, limits: &[Limit]) -> bool {
        limits.iter().any(|limit| limit.metric == Metric::NoiseP && self.agrees(limit.value).is_none())
    }

    /// The error for a limit on a metric that could not be measured.
    pub fn lacks(&self, limits: &[Limit]) -> Option<String> {
        limits.iter().find_map(|limit| self.why_without(limit.metric))
    }

    /// The reason why a metric was not measured.
    pub fn why_without(&self, metric: Metric) -> Option<String> {
        if value_of(&self.metrics, metric).is_some() {
            return None;
        }
        let reason = match self.agreement {
            Some(Err(reason)) if metric == Metric::NoiseP => why_not(reason),
            _ => "the pictures are less than 11 pixels wide or high".into(),
        };
        Some(format!("there is no {}: {reason}", metric.name()))
    }
}

/// The value of a measured metric.
pub fn value_of(metrics: &[Measured], metric: Metric) -> Option<f64> {
    metrics.iter().find(|line| line.metric == metric).map(|line| line.value)
}

/// Computes the metrics accepted by `is_requested`. `threshold` belongs to [`Metric::ShareAbove`].
pub fn measure(pair: &Aligned, threshold: f32, is_requested: &dyn Fn(Metric) -> bool) -> Measurement {
    let (a, b) = (&pair.actual[..], &pair.expected[..]);
    let (width, height) = (pair.window.width as usize, pair.window.height as usize);
    let in_means = [Metric::Error, Metric::Mae, Metric::RelMse, Metric::Smape];
    let means = in_means.into_iter().any(is_requested).then(|| means(a, b));
    let shown =
        (is_requested(Metric::Psnr) || is_requested(Metric::Ssim)).then(|| [a, b].map(Encoded::from_linear));
    let agreement = is_requested(Metric::NoiseP).then(|| agreement(pair));
    let mut metrics = Vec::new();
    for (metric, ..) in Metric::ALL.into_iter().filter(|(metric, ..)| is_requested(*metric)) {
        let mut remark = String::new();
        let value = match metric {
            Metric::Error => means.as_ref().map(|means| {
                if means.standard_error > 0.0 {
                    remark =
                        format!("standard error {:.3e}, if pixels are independent", means.standard_error);
                }
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
                if largest.difference > 0.0 {
                    let [x, y] = place(largest.y * width + largest.x, pair);
                    remark = format!("at x {x}, y {y}, {}", COLORS[largest.channel]);
                }
                Some(largest.difference.into())
            }
            Metric::ShareAbove => {
                remark = format!("which is {threshold}");
                Some(share_above(a, b, threshold))
            }
            Metric::Psnr => shown.as_ref().map(|[a, b]| psnr(a, b)),
            // Pictures with fewer than 11 pixels on a side have no SSIM.
            Metric::Ssim => shown.as_ref().and_then(|[a, b]| ssim(a, b, width, height)),
            Metric::Flip => Some(ldr_flip(a, b, width, PIXELS_PER_DEGREE)),
            Metric::HdrFlip => Some(hdr_flip(a, b, width, PIXELS_PER_DEGREE)),
            Metric::NoiseP => agreement.as_ref().and_then(|found| found.as_ref().ok()).map(|found| {
                let index = found.means.iter().map(|test| test.tail_index).fold(f64::INFINITY, f64::min);
                if index.is_finite() {
                    remark = format!("tail index {index:.2}");
                }
                found.p
            }),
        };
        metrics.extend(value.map(|value| Measured { metric, value, remark }));
    }
    Measurement { metrics, agreement }
}

/// The reason why noise and bias cannot be distinguished, with help.
pub fn why_not(reason: Untestable) -> String {
    match reason {
        Untestable::NoErrors => format!("{reason}; `lookat render --error-layers` writes them"),
        Untestable::Actual { .. } => format!("{reason}; `lookat render --spp` adds samples"),
        _ => reason.to_string(),
    }
}

/// The names of the channels.
pub const COLORS: [&str; 3] = ["red", "green", "blue"];

/// The position of a pixel of the pair in the full picture.
pub fn place(index: usize, pair: &Aligned) -> [i32; 2] {
    let width = pair.window.width as usize;
    [pair.window.x + (index % width) as i32, pair.window.y + (index / width) as i32]
}

/// The number of infinite or NaN pixels, and the position of the first.
pub fn not_finite(pixels: &[[f32; 3]], pair: &Aligned) -> Option<(usize, [i32; 2])> {
    let bad = |pixel: &&[f32; 3]| !pixel.iter().all(|value| value.is_finite());
    let first = pixels.iter().position(|pixel| bad(&pixel))?;
    Some((pixels.iter().filter(bad).count(), place(first, pair)))
}

/// Formats a value with enough digits.
pub fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        1e-3..1e6 => format!("{value:.6}"),
        _ => format!("{value:.3e}"),
    }
}
