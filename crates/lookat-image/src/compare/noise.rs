//! The noise of each pixel of a pair of pictures.

use std::ops::Range;

use super::Untestable;
use crate::{Aligned, PixelError, Precision, Window};

/// Pixels on a side of a tile.
const TILE: u32 = 16;
/// Fewer pixels than these do not tell how far their mean is off.
pub(super) const FEWEST_PIXELS: usize = 100;

/// The relative rounding error of pictures by this renderer, which sums each channel in double precision. Smaller differences mean
/// nothing.
const ROUNDING: f64 = 1.0 / (1 << 20) as f64;
/// The rounding error of other renderers, relative to the brightest channel of the pixel: they may sum thousands of samples in single
/// precision, and pbrt-v3 sums XYZ, which mixes the channels.
const SUM_ROUNDING: f64 = 1.0 / (1 << 13) as f64;
/// The relative rounding error of a picture in half precision.
const HALF_ROUNDING: f64 = 1.0 / (1 << 11) as f64;
/// The smallest step of half precision, near 0.
const HALF_STEP: f64 = 1.0 / (1 << 24) as f64;
/// The fewest samples of a pixel to compare with a picture without error layers. With fewer, the standard error is too often 0.
const FEWEST_SAMPLES: u32 = 32;
/// With fewer samples than these, replicates have too few samples each for tests of single pixels: filters with
/// negative lobes gave false alarms in 5 of 100 pairs of pictures with 32.
const MANY_SAMPLES: u32 = 64;
/// Other renderers do not report the noise that neighboring pixels share. The error of a mean of their pixels is assumed to be at least
/// this many times that of independent ones.
const FILTERED: f32 = 2.0;

/// An event that does not occur in n samples has a probability of at most this over n, with a confidence of 95 % (Hanley and
/// Lippman-Hand, "If Nothing Goes Wrong, Is Everything All Right?", 1983).
const RULE_OF_THREE: f64 = 3.0;

/// Without rare light, a pixel of an expected picture without error layers exceeds the actual one by at most this many standard
/// errors.
const BOUND: f64 = 3.0;

/// The largest noise of a tile that counts as the noise of the picture, relative to nine of ten other tiles.
const MOST_OF_TILE: f64 = 4.0;

/// The difference of two pixels in one channel.
pub(super) struct Difference {
    /// Actual minus expected.
    pub value: f64,
    /// The variance of the pixel.
    pub variance: Variance,
    /// The part of the pixel in the variance of a mean of pixels. It differs from `variance` where neighbors share samples.
    pub in_mean: Variance,
    /// The number of pixels of which about one is independent.
    pub noise_area: f64,
    /// The rounding error, which is alike in neighbors.
    pub rounding: f64,
    /// True if both have about as many samples, so that their difference is not skewed. False if one number is unknown.
    pub is_even: bool,
    /// True if both have enough samples for their replicates to be about normally distributed.
    pub has_many_samples: bool,
}

/// The variance of a sum.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Variance {
    pub value: f64,
    /// The sum of what it consists of, squared, by the degrees of freedom of each (Welch and Satterthwaite).
    spread: f64,
}

impl Variance {
    fn new(value: f64, freedom: f64) -> Variance {
        Variance { value, spread: value * value / freedom }
    }

    pub fn plus(self, other: Variance) -> Variance {
        Variance { value: self.value + other.value, spread: self.spread + other.spread }
    }

    /// The degrees of freedom of the variance.
    pub fn freedom(self) -> f64 {
        self.value * self.value / self.spread
    }
}

/// The noise of a pair of pictures. The standard error of each pixel is known or estimated.
pub(super) struct Noise {
    expected_is_known: bool,
    actual: Vec<PixelError>,
    expected: Vec<PixelError>,
    /// The rounding error relative to the channel.
    rounding: f64,
    /// The rounding error relative to the brightest channel of the pixel.
    mixed_rounding: f64,
    step: f64,
}

impl Noise {
    pub fn new(pair: &Aligned) -> Result<Noise, Untestable> {
        if pair.precision == Precision::Integer {
            return Err(Untestable::Rounded);
        }
        let actual = pair.actual_errors.clone().ok_or(Untestable::NoErrors)?;
        if !pair.actual.iter().chain(&pair.expected).flatten().all(|value| value.is_finite()) {
            return Err(Untestable::NotFinite);
        }
        let expected_is_known = pair.expected_errors.is_some();
        if !expected_is_known && actual.len() < FEWEST_PIXELS {
            return Err(Untestable::Small { needed: FEWEST_PIXELS });
        }
        let needed = if expected_is_known { 2 } else { FEWEST_SAMPLES };
        let unknown = |errors: &[PixelError]| errors.iter().filter(|error| !is_known(error, needed)).count();
        match (unknown(&actual), pair.expected_errors.as_deref().map_or(0, unknown)) {
            (0, 0) => {}
            (0, pixels) => return Err(Untestable::Expected { pixels }),
            (pixels, _) => return Err(Untestable::Actual { pixels, needed }),
        }
        let expected = pair.expected_errors.clone().unwrap_or_else(|| estimated_errors(pair, &actual));
        let (rounding, step) = match pair.precision {
            Precision::Single => (ROUNDING, 0.0),
            _ => (HALF_ROUNDING, HALF_STEP),
        };
        let mixed_rounding = if expected_is_known { 0.0 } else { SUM_ROUNDING };
        Ok(Noise { expected_is_known, actual, expected, rounding, mixed_rounding, step })
    }

    /// The differences of all pixels.
    pub fn differences(&self, pair: &Aligned, channel: usize) -> Vec<Difference> {
        (0..pair.actual.len()).map(|pixel| self.difference(pair, pixel, channel, f64::INFINITY)).collect()
    }

    /// The differences without rare light, which the samples of the actual picture may have missed: no pixel of the expected picture
    /// is far above the actual one, except in [features](levels). `None` if the expected picture has error layers, which include
    /// such light.
    pub fn without_rare(&self, pair: &Aligned, channel: usize) -> Option<Vec<Difference>> {
        if self.expected_is_known {
            return None;
        }
        let bound = |pixel| BOUND * self.variances(pixel, channel).iter().sum::<f64>().sqrt();
        let excess = |pixel: usize| {
            let [a, b] = [&pair.actual, &pair.expected].map(|colors| f64::from(colors[pixel][channel]));
            if b - a > bound(pixel) { b - a } else { 0.0 }
        };
        let excess: Vec<f64> = (0..pair.actual.len()).map(excess).collect();
        let levels = levels(&excess, pair.window.width as usize).into_iter().enumerate();
        let bounded =
            |(pixel, level): (usize, f64)| self.difference(pair, pixel, channel, level.max(bound(pixel)));
        Some(levels.map(bounded).collect())
    }

    /// The variances of the actual and the expected value of a pixel, at the same noise per sample.
    fn variances(&self, pixel: usize, channel: usize) -> [f64; 2] {
        let errors = [&self.actual[pixel], &self.expected[pixel]];
        let [a, b] = errors.map(|error| f64::from(error.standard_error[channel]).powi(2));
        let ratio = self.ratio(pixel);
        let a = a.max(if ratio < 1.0 { b / ratio } else { 0.0 });
        [a, b.max(if ratio > 1.0 { a * ratio } else { 0.0 })]
    }

    /// The samples of the actual pixel, relative to the expected one.
    fn ratio(&self, pixel: usize) -> f64 {
        f64::from(self.actual[pixel].samples) / f64::from(self.expected[pixel].samples)
    }

    /// The difference of a pixel. The expected value exceeds the actual one by at most `bound`.
    fn difference(&self, pair: &Aligned, pixel: usize, channel: usize, bound: f64) -> Difference {
        let (colors, expected_colors) = (pair.actual[pixel], pair.expected[pixel]);
        let (a, b) = (f64::from(colors[channel]), f64::from(expected_colors[channel]));
        let (a_error, b_error) = (&self.actual[pixel], &self.expected[pixel]);
        let [a_freedom, b_freedom] = [a_error, b_error].map(|error| f64::from(error.replicates - 1));
        let [a_variance, b_variance] = self.variances(pixel, channel);
        let value = if self.expected_is_known { a - b } else { (a - b).max(-bound) };
        // The variance of a mean, of which events of that probability make up all.
        let rare = if self.expected_is_known { 0.0 } else { value * value / RULE_OF_THREE };
        let variance = |a_variance: f64, b_variance: f64| {
            Variance::new(a_variance, a_freedom).plus(Variance::new(b_variance.max(rare), b_freedom))
        };
        let brightest =
            colors.iter().chain(&expected_colors).fold(0.0_f32, |most, value| most.max(value.abs()));
        let rounding = self.rounding * a.abs().max(b.abs());
        Difference {
            value,
            variance: variance(a_variance, b_variance),
            in_mean: variance(
                a_variance * in_means(a_error, channel),
                b_variance * in_means(b_error, channel),
            ),
            noise_area: f64::from(a_error.noise_area().max(b_error.noise_area())),
            rounding: self.step.max(rounding).max(self.mixed_rounding * f64::from(brightest)),
            is_even: self.expected_is_known && (0.5..=2.0).contains(&self.ratio(pixel)),
            has_many_samples: a_error.samples.min(b_error.samples) >= MANY_SAMPLES,
        }
    }
}

/// True if the error can be used, and rests on so many samples.
fn is_known(error: &PixelError, samples: u32) -> bool {
    let is_finite = error.standard_error.iter().all(|error| error.is_finite());
    error.replicates >= 2 && error.samples >= samples && is_finite
}

/// All standard errors: red, green and blue of the pixel, then red, green and blue without the filter, if they are known.
fn each_error(error: &mut PixelError) -> impl Iterator<Item = &mut f32> {
    error.standard_error.iter_mut().chain(error.shared.iter_mut().flat_map(|shared| &mut shared.unfiltered))
}

/// The variance of a pixel in a mean over many pixels, relative to that of the pixel alone.
fn in_means(error: &PixelError, channel: usize) -> f64 {
    let [own, filtered] = [error.of_means(), error.standard_error].map(|error| f64::from(error[channel]));
    // An upper bound if the pixel has no noise.
    if filtered > 0.0 { (own / filtered).powi(2) } else { error.noise_area().into() }
}

/// Estimates the standard errors of an expected picture without error layers. They are the actual picture's errors, scaled so that
/// they explain all differences together. A tile whose differences scatter more gets larger errors, because other renderers have noise
/// where this one has none. [`Noise::difference`] adds the error of a rare event that only one of the pictures has in a pixel.
fn estimated_errors(pair: &Aligned, actual: &[PixelError]) -> Vec<PixelError> {
    let factor = relative_noise(pair, actual) as f32;
    let mut errors = actual.to_vec();
    errors.iter_mut().flat_map(each_error).for_each(|error| *error *= factor);
    for tile in tiles(pair) {
        for channel in 0..3 {
            let at = |pixel: usize| pair.actual[pixel][channel] - pair.expected[pixel][channel];
            let own = pair
                .window
                .indices(tile)
                .map(|pixel| f64::from(actual[pixel].standard_error[channel]).powi(2));
            let own = own.sum::<f64>() / tile.area() as f64;
            let all = f64::from(scatter(pair.window.indices(tile).map(at).collect())).powi(2);
            let others = (all - own).max(0.0).sqrt() as f32;
            for pixel in pair.window.indices(tile) {
                let filtered = (FILTERED / errors[pixel].noise_area().sqrt()).max(1.0);
                let error = &mut errors[pixel];
                let more = (filtered * others / error.standard_error[channel]).max(1.0);
                if more.is_finite() {
                    each_error(error).skip(channel).step_by(3).for_each(|error| *error *= more);
                } else {
                    error.standard_error[channel] = filtered * others;
                }
            }
        }
    }
    errors
}

/// The errors of the expected picture relative to those of the actual one, if all differences are noise; at least 1. A tile counts
/// little more than nine of ten others, so that an error in one tile is not taken for noise of all.
fn relative_noise(pair: &Aligned, actual: &[PixelError]) -> f64 {
    let sums = |tile: Window| {
        let (mut squares, mut own) = (0.0, 0.0);
        for pixel in pair.window.indices(tile) {
            for channel in 0..3 {
                let [a, b] = [&pair.actual, &pair.expected].map(|pixels| f64::from(pixels[pixel][channel]));
                squares += (a - b).powi(2);
                own += f64::from(actual[pixel].standard_error[channel]).powi(2);
            }
        }
        (squares, own)
    };
    let tiles: Vec<(f64, f64)> = tiles(pair).map(sums).filter(|(_, own)| *own > 0.0).collect();
    let mut ratios: Vec<f64> = tiles.iter().map(|(squares, own)| squares / own).collect();
    ratios.sort_by(f64::total_cmp);
    let Some(high) = ratios.get(ratios.len().saturating_sub(1) * 9 / 10) else { return 1.0 };
    let squares: f64 = tiles.iter().map(|(squares, own)| squares.min(MOST_OF_TILE * high * own)).sum();
    let own: f64 = tiles.iter().map(|(_, own)| own).sum();
    (squares / own - 1.0).max(1.0).sqrt()
}

/// The standard deviation of values of which less than half have been moved, by their median distance from the median.
fn scatter(mut values: Vec<f32>) -> f32 {
    let middle = values.len() / 2;
    let median = |values: &mut [f32]| *values.select_nth_unstable_by(middle, f32::total_cmp).1;
    let center = median(&mut values);
    values.iter_mut().for_each(|value| *value = (*value - center).abs());
    1.4826 * median(&mut values)
}

/// The tiles of the pair.
pub(super) fn tiles(pair: &Aligned) -> impl Iterator<Item = Window> {
    let Window { x: left, y: top, width, height } = pair.window;
    let starts = |size: u32| (0..size).step_by(TILE as usize);
    let side = move |start: u32, size: u32| TILE.min(size - start);
    starts(height).flat_map(move |y| {
        starts(width).map(move |x| Window {
            x: left + x as i32,
            y: top + y as i32,
            width: side(x, width),
            height: side(y, height),
        })
    })
}

/// Width and height of blocks of nine or ten pixels.
const BLOCKS: [[usize; 2]; 5] = [[3, 3], [5, 2], [2, 5], [9, 1], [1, 9]];
/// The least that the darkest pixel of a block has of the brightest one.
const SHARE: f64 = 2.0 / 3.0;

/// The part of each pixel's excess that belongs to a feature: the largest excess that all pixels of a block around it have, if they
/// agree; else 0. `excess` is 0 where noise explains it.
///
/// A feature is something that one picture lacks, such as a small lamp: several pixels that are brighter by about the same amount.
/// Light that samples rarely hit looks different. Where the expected picture has hit it a few times in each pixel, the numbers of hits
/// are Poisson distributed, and neighbors differ by about as much as they are bright. A filter spreads one hit over its footprint, but
/// unevenly: the darkest of 3 x 3 pixels has at most 2 % of the brightest one under the default `gaussian`, 25 % under `triangle`.
/// Where nine pixels agree within a third, each has about ten hits or more. Then the actual picture has hit this light, too, unless it
/// has less than a tenth of the samples; one hit in a tile is noise enough to hide the block.
fn levels(excess: &[f64], width: usize) -> Vec<f64> {
    let mut levels = vec![0.0_f64; excess.len()];
    let height = excess.len() / width;
    for [w, h] in BLOCKS {
        for first in starts(height, h).flat_map(|y| starts(width, w).map(move |x| y * width + x)) {
            let block = || (0..w * h).map(|i| first + i / w * width + i % w);
            if block().any(|pixel| excess[pixel] <= 0.0) {
                continue;
            }
            let least = block().fold(f64::INFINITY, |least, pixel| least.min(excess[pixel]));
            if block().all(|pixel| least >= SHARE * excess[pixel]) {
                for pixel in block() {
                    levels[pixel] = levels[pixel].max(least);
                }
            }
        }
    }
    levels
}

/// The first positions of blocks along an axis.
fn starts(size: usize, block: usize) -> Range<usize> {
    0..(size + 1).saturating_sub(block)
}
