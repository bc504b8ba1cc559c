//! The numbers that say how far pictures are apart, by name.

use lookat_image::{
    Agreement, Aligned, Encoded, PIXELS_PER_DEGREE, Untestable, agreement, hdr_flip, largest_difference,
    ldr_flip, means, percentile_difference, psnr, relative_mse_trimmed, rmse, share_above, ssim,
};

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
    NoiseP,
}

impl Metric {
    /// Each with its name and what it is.
    const ALL: [(Metric, &'static str, &'static str); 14] = [
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
        (Metric::NoiseP, "noise-p", "probability of such differences if all is noise"),
    ];

    pub fn from_name(name: &str) -> Option<Metric> {
        Metric::ALL.iter().find(|(_, known, _)| *known == name).map(|(metric, ..)| *metric)
    }

    pub fn names() -> String {
        Metric::ALL.map(|(_, name, _)| name).join(", ")
    }

    pub fn name(self) -> &'static str {
        Metric::ALL[self as usize].1
    }

    pub fn meaning(self) -> &'static str {
        Metric::ALL[self as usize].2
    }

    /// Whether more is better.
    pub fn is_likeness(self) -> bool {
        matches!(self, Metric::Psnr | Metric::Ssim | Metric::NoiseP)
    }
}

/// What a metric may be at most, or at least if more is better.
#[derive(Debug, Clone, Copy)]
pub struct Limit {
    pub metric: Metric,
    pub value: f64,
}

/// One line of the result.
#[derive(Debug)]
pub struct Measured {
    pub metric: Metric,
    pub value: f64,
    /// What else there is to say.
    pub remark: String,
}

impl Measured {
    /// Whether a limit of this metric is not kept.
    pub fn is_beyond(&self, limits: &[Limit]) -> bool {
        let within = |limit: f64| {
            if self.metric.is_likeness() { self.value >= limit } else { self.value.abs() <= limit }
        };
        limits.iter().any(|limit| limit.metric == self.metric && !within(limit.value))
    }
}

/// What is measured.
#[derive(Debug)]
pub struct Measurement {
    pub metrics: Vec<Measured>,
    /// Whether the pictures agree up to noise, if that was asked for.
    pub agreement: Option<Result<Agreement, Untestable>>,
}

impl Measurement {
    /// Which metric that has a limit was not measured, and why.
    pub fn lacks(&self, limits: &[Limit]) -> Option<String> {
        limits.iter().find_map(|limit| self.why_without(limit.metric))
    }

    /// Why a metric was not measured, if it was not.
    pub fn why_without(&self, metric: Metric) -> Option<String> {
        if self.value(metric).is_some() {
            return None;
        }
        let reason = match self.agreement {
            Some(Err(reason)) if metric == Metric::NoiseP => why_not(reason),
            _ => "the pictures are too small, less than 11 pixels wide or high".into(),
        };
        Some(format!("there is no {}: {reason}", metric.name()))
    }

    /// The value of a metric, if it was measured.
    pub fn value(&self, metric: Metric) -> Option<f64> {
        self.metrics.iter().find(|line| line.metric == metric).map(|line| line.value)
    }
}

/// Computes the metrics that are asked for, and nothing else. `threshold` is that of [`Metric::ShareAbove`].
pub fn measure(pair: &Aligned, threshold: f32, asked: &dyn Fn(Metric) -> bool) -> Measurement {
    let (a, b) = (&pair.actual[..], &pair.expected[..]);
    let (width, height) = (pair.window.width as usize, pair.window.height as usize);
    let in_means = [Metric::Error, Metric::Mae, Metric::RelMse, Metric::Smape];
    let means = in_means.into_iter().any(asked).then(|| means(a, b));
    let shown = (asked(Metric::Psnr) || asked(Metric::Ssim)).then(|| [a, b].map(Encoded::from_linear));
    let agreement = asked(Metric::NoiseP).then(|| agreement(pair));
    let mut metrics = Vec::new();
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
                remark = format!("at x {x}, y {y}, {}", COLORS[largest.channel]);
                Some(largest.difference.into())
            }
            Metric::ShareAbove => {
                remark = format!("above {threshold}");
                Some(share_above(a, b, threshold))
            }
            Metric::Psnr => shown.as_ref().map(|[a, b]| psnr(a, b)),
            // Pictures of less than 11 pixels have none.
            Metric::Ssim => shown.as_ref().and_then(|[a, b]| ssim(a, b, width, height)),
            Metric::Flip => Some(ldr_flip(a, b, width, height, PIXELS_PER_DEGREE)),
            Metric::HdrFlip => Some(hdr_flip(a, b, width, height, PIXELS_PER_DEGREE)),
            Metric::NoiseP => agreement.as_ref().and_then(|found| Some(found.as_ref().ok()?.p)),
        };
        metrics.extend(value.map(|value| Measured { metric, value, remark }));
    }
    Measurement { metrics, agreement }
}

/// Why noise and bias cannot be told apart, and what helps.
pub fn why_not(reason: Untestable) -> String {
    match reason {
        Untestable::NoErrors => format!("{reason}; `lookat render --error-layers` writes them"),
        Untestable::Actual { .. } => format!("{reason}; --spp gives samples"),
        _ => reason.to_string(),
    }
}

/// The channels, as people call them.
pub const COLORS: [&str; 3] = ["red", "green", "blue"];

/// The place in the full picture of a pixel of the pair.
pub fn place(index: usize, pair: &Aligned) -> [i32; 2] {
    let width = pair.window.width as usize;
    [pair.window.x + (index % width) as i32, pair.window.y + (index / width) as i32]
}

/// How many pixels are infinite or not a number, and where the first is.
pub fn not_finite(pixels: &[[f32; 3]], pair: &Aligned) -> Option<(usize, [i32; 2])> {
    let bad = |pixel: &&[f32; 3]| !pixel.iter().all(|value| value.is_finite());
    let first = pixels.iter().position(|pixel| bad(&pixel))?;
    Some((pixels.iter().filter(bad).count(), place(first, pair)))
}

/// A value with enough digits.
pub fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        1e-3..1e6 => format!("{value:.6}"),
        _ => format!("{value:.3e}"),
    }
}
