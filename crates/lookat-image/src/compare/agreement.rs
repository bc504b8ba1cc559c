//! Tests whether two noisy pictures agree: by their means, tiles and pixels.
//!
//! The tests use the standard errors of [`PixelError`](crate::PixelError). Noise is assumed to be independent from pixel to pixel,
//! except as far as [`Shared`](crate::Shared) says.

#[cfg(test)]
mod tests;

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use super::noise::{Difference, FEWEST_PIXELS, Noise, Variance, tiles};
use crate::{Aligned, Window};

/// The power of [`Agreement::visible_in_mean`].
const POWER: f64 = 0.95;
/// The sum over fewer pixels than these is too skewed to be taken for normal.
const FEWEST_SQUARES: usize = 1000;

/// The result of testing one difference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Test {
    /// 0 for red, 1 for green, 2 for blue.
    pub channel: usize,
    /// The tested pixels: the whole window, or a tile of it.
    pub window: Window,
    /// The mean of actual minus expected there, in the unit of the pictures.
    pub difference: f64,
    /// The standard error of `difference`.
    pub standard_error: f64,
    /// The probability of such a difference, or a larger one, if there is nothing but noise. 0..1.
    pub p: f64,
    /// The tail index of the differences of its pixels. At least 0; infinite if they are equal. Below 2, few pixels make up most of
    /// the difference, as where light is rarely sampled.
    pub tail_index: f64,
    /// `p` without light that the samples of the actual picture may have missed because they rarely hit it: no pixel counts as far
    /// brighter in the expected picture, unless a block of nine pixels is brighter by about the same amount. At least `p`, and
    /// the same if the tail index is at least 2 or the expected picture has error layers, which tell of such light.
    pub p_without_rare: f64,
}

/// The result of testing the pixels of a channel all together, by the sum of their squared t.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelTest {
    /// 0 for red, 1 for green, 2 for blue.
    pub channel: usize,
    /// The pixels that could be tested.
    pub pixels: usize,
    /// The sum over what noise alone makes of it on the average: above 1, pixels differ by more than their noise.
    pub ratio: f64,
    /// The probability of such a sum, or a larger one, if there is nothing but noise. 0..1.
    pub p: f64,
}

/// The reason why two pictures cannot be tested.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Untestable {
    /// Without error layers, noise and bias look the same.
    #[error("the actual picture has no error layers")]
    NoErrors,
    /// A picture has [`Precision::Integer`](crate::Precision::Integer).
    #[error("a picture is stored as integers, and rounding is not noise")]
    Rounded,
    /// A value is infinite or not a number.
    #[error("a pixel is infinite or not a number")]
    NotFinite,
    /// There are too few pixels to estimate the noise of a picture without error layers.
    #[error(
        "the expected picture has no error layers, and fewer than {needed} pixels to estimate its noise from"
    )]
    Small {
        /// The required number of pixels.
        needed: usize,
    },
    /// The actual picture has pixels that cannot be tested, and could hide any difference.
    #[error(
        "the actual picture has pixels with fewer than {needed} samples or without a finite error ({pixels})"
    )]
    Actual {
        /// The number of such pixels.
        pixels: usize,
        /// The required number of samples.
        needed: u32,
    },
    /// The expected picture has error layers, and pixels that cannot be tested.
    #[error("the expected picture has pixels with fewer than 2 samples or without a finite error ({pixels})")]
    Expected {
        /// The number of such pixels.
        pixels: usize,
    },
}

/// The results of all tests of two pictures.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Agreement {
    /// True if the expected picture has error layers. Otherwise its noise is estimated from the differences.
    pub expected_is_known: bool,
    /// The means of the whole pictures, for each channel.
    pub means: Vec<Test>,
    /// The means of tiles of 16 x 16 pixels, for each channel.
    pub tiles: Vec<Test>,
    /// The means again, for each channel, with standard errors from how much the differences of pixels scatter: it finds
    /// small errors of pictures that share their noise. As the next ones, only of pixels that have error layers in both
    /// pictures, and about the same number of samples: the noise of others is skewed.
    pub paired: Vec<Test>,
    /// Pixel by pixel, for each channel that has pixels enough with at least 6 replicates and 64 samples.
    pub pixels: Vec<PixelTest>,
    /// The smallest p of all tests, corrected for their number: half of the chance of a false alarm is that of the tiles,
    /// half that of the tests of whole pictures, evenly within each (Bonferroni). 0..1. Pictures that differ by nothing but
    /// noise get less than x with a probability of at most x.
    pub p: f64,
    /// The smallest [`Test::p_without_rare`], corrected like `p`. At least `p`.
    pub p_without_rare: f64,
}

impl Agreement {
    /// True if the pictures agree up to noise. `None` if they differ only by light that the samples of the actual picture may rarely
    /// hit: more samples decide. `significance`, in 0..1, is the probability of a false alarm.
    pub fn holds(&self, significance: f64) -> Option<bool> {
        let holds = self.p >= significance;
        (holds || self.p_without_rare < significance).then_some(holds)
    }

    /// The smallest tail index of the differences that were found: of whole pictures, or else of tiles. Infinite if there are none.
    pub fn tail_index(&self, significance: f64) -> f64 {
        let level = self.level_of_whole(significance);
        let means = self.means.iter().filter(|test| test.p < level);
        let tiles = self.differing_tiles(significance);
        means.chain(&tiles).fold(f64::INFINITY, |least, test| least.min(test.tail_index))
    }

    /// The level of a test of whole pictures: it has found a difference if its p is below this.
    pub fn level_of_whole(&self, significance: f64) -> f64 {
        significance / (2 * self.of_whole().max(1)) as f64
    }

    /// The tests of tiles that have found a difference, the worst first: after Holm, "A Simple Sequentially Rejective
    /// Multiple Test Procedure", 1979.
    pub fn differing_tiles(&self, significance: f64) -> Vec<Test> {
        let mut tests = self.tiles.clone();
        tests.sort_by(|a, b| a.p.total_cmp(&b.p));
        let count = tests.len();
        let level = |i: usize| significance / (2 * (count - i)) as f64;
        let differing = tests.iter().enumerate().take_while(|(i, test)| test.p < level(*i)).count();
        tests.truncate(differing);
        tests
    }

    /// The smallest error of the mean that would be found with a probability of 95 %: the largest of the channels, in the
    /// unit of the pictures.
    pub fn visible_in_mean(&self, significance: f64) -> f64 {
        let errors = self.means.iter().map(|test| test.standard_error);
        visible(self.level_of_whole(significance)) * errors.fold(0.0, f64::max)
    }

    /// The smallest error of a tile that would be found with a probability of 95 %: the median over tiles and channels, in
    /// the unit of the pictures.
    pub fn visible_in_tile(&self, significance: f64) -> f64 {
        let mut errors: Vec<f64> = self.tiles.iter().map(|test| test.standard_error).collect();
        errors.sort_by(f64::total_cmp);
        visible(significance / (2 * errors.len()) as f64) * errors[errors.len() / 2]
    }

    fn of_whole(&self) -> usize {
        self.means.len() + self.paired.len() + self.pixels.len()
    }

    /// The smallest p of that kind, corrected.
    fn corrected(&self, p: fn(&Test) -> f64) -> f64 {
        let smallest = |values: &mut dyn Iterator<Item = f64>| values.fold(1.0, f64::min);
        let means = self.means.iter().chain(&self.paired).map(p);
        let whole = smallest(&mut means.chain(self.pixels.iter().map(|test| test.p)));
        let tiles = smallest(&mut self.tiles.iter().map(p));
        (2.0 * (whole * self.of_whole() as f64).min(tiles * self.tiles.len() as f64)).min(1.0)
    }
}

/// The smallest difference, in standard errors, that a test at this level finds with a probability of 95 %.
fn visible(level: f64) -> f64 {
    let normal = Normal::standard();
    normal.inverse_cdf(POWER) - normal.inverse_cdf(level / 2.0)
}

/// Tests whether two pictures agree up to noise.
///
/// An expected picture without error layers is assumed to be at least as noisy as the actual one, and noisier where the differences
/// show it. A picture with fewer samples than the other is assumed to be at least as noisy as the other would be with so few: rare
/// events that its samples missed do not count as a difference.
///
/// # Errors
///
/// If one picture or a single pixel of it cannot be tested.
pub fn agreement(pair: &Aligned) -> Result<Agreement, Untestable> {
    let noise = Noise::new(pair)?;
    let mut result = Agreement { expected_is_known: pair.expected_errors.is_some(), ..Agreement::default() };
    for channel in 0..3 {
        let differences = noise.differences(pair, channel);
        let without_rare = noise.without_rare(pair, channel);
        let test = |pixels: &[usize], window: Window| {
            let of = |differences: &[Difference]| test_mean(pixels, differences, channel, window);
            let mut test = of(&differences);
            if let Some(rest) = without_rare.as_deref().filter(|_| test.tail_index < FINITE_VARIANCE) {
                test.p_without_rare = of(rest).p.max(test.p);
            }
            test
        };
        let all: Vec<usize> = (0..differences.len()).collect();
        result.means.push(test(&all, pair.window));
        result
            .tiles
            .extend(tiles(pair).map(|tile| test(&pair.window.indices(tile).collect::<Vec<_>>(), tile)));
        result.paired.extend(test_paired(&differences, channel, pair.window));
        result.pixels.extend(test_pixels(&differences, channel));
    }
    result.p = result.corrected(|test| test.p);
    result.p_without_rare = result.corrected(|test| test.p_without_rare);
    Ok(result)
}

/// Tests the mean of a part of the pictures.
fn test_mean(pixels: &[usize], differences: &[Difference], channel: usize, window: Window) -> Test {
    let (mut value, mut variance, mut rounding) = (0.0, Variance::default(), 0.0);
    for difference in pixels.iter().map(|pixel| &differences[*pixel]) {
        value += difference.value;
        variance = variance.plus(difference.in_mean);
        rounding += difference.rounding;
    }
    let count = window.area() as f64;
    let standard_error = (variance.value + rounding * rounding).sqrt() / count;
    let difference = value / count;
    let p = two_sided(difference / standard_error, variance.freedom());
    let tail_index = tail_index(pixels.iter().map(|pixel| differences[*pixel].value));
    Test { channel, window, difference, standard_error, p, tail_index, p_without_rare: p }
}

/// Tests the mean by how the differences of pixels scatter.
fn test_paired(differences: &[Difference], channel: usize, window: Window) -> Option<Test> {
    let pixels: Vec<&Difference> = differences.iter().filter(|pixel| pixel.is_even).collect();
    let count = pixels.len() as f64;
    let mean = |value: fn(&Difference) -> f64| pixels.iter().map(|pixel| value(pixel)).sum::<f64>() / count;
    let (difference, rounding) = (mean(|pixel| pixel.value), mean(|pixel| pixel.rounding));
    let squares = pixels.iter().map(|pixel| (pixel.value - difference).powi(2)).sum::<f64>();
    let area = mean(|pixel| pixel.noise_area);
    let shared = mean(|pixel| pixel.in_mean.value) / mean(|pixel| pixel.variance.value);
    let shared = if shared.is_finite() { shared } else { area };
    let standard_error = (shared * squares / (count * (count - 1.0)) + rounding.powi(2)).sqrt();
    let p = two_sided(difference / standard_error, (count - 1.0) / area);
    let tail_index = tail_index(pixels.iter().map(|pixel| pixel.value));
    let test = Test { channel, window, difference, standard_error, p, tail_index, p_without_rare: p };
    (pixels.len() >= FEWEST_PIXELS).then_some(test)
}

/// Tests the pixels of a channel together.
fn test_pixels(differences: &[Difference], channel: usize) -> Option<PixelTest> {
    let mut sums = [0.0; 3];
    let mut pixels = 0;
    for pixel in differences {
        let n = pixel.variance.freedom();
        // The variance of t squared is finite above 4; black and rounded pixels have nothing to say.
        if !pixel.is_even
            || !pixel.has_many_samples
            || n.is_nan()
            || n <= 4.5
            || pixel.variance.value < pixel.rounding.powi(2)
        {
            continue;
        }
        let mean = n / (n - 2.0);
        sums[0] += pixel.value.powi(2) / (pixel.variance.value + pixel.rounding.powi(2));
        sums[1] += mean;
        sums[2] += pixel.noise_area * 2.0 * mean.powi(2) * (n - 1.0) / (n - 4.0);
        pixels += 1;
    }
    let [sum, expected, variance] = sums;
    let p = Normal::standard().sf((sum - expected) / variance.sqrt());
    (pixels >= FEWEST_SQUARES).then_some(PixelTest { channel, pixels, ratio: sum / expected, p })
}

/// The probability that Student's t is at least so far from 0. One that is no number comes from equal values without noise.
fn two_sided(t: f64, freedom: f64) -> f64 {
    if t.is_nan() {
        return 1.0;
    }
    // Without noise there is only rounding, of which many degrees of freedom are as good as any.
    let freedom = if freedom.is_nan() { 1e6 } else { freedom.clamp(1.0, 1e6) };
    StudentsT::new(0.0, 1.0, freedom).map_or(1.0, |student| 2.0 * student.sf(t.abs()))
}

/// Below this tail index, the variance of the values is infinite: their standard error says nothing of their mean.
const FINITE_VARIANCE: f64 = 2.0;

/// The tail index of distances from 0: they are larger than x with a probability that falls as x to the power of minus this. That of
/// Hill, "A Simple General Approach to Inference About the Tail of a Distribution", 1975, over as many values as Vehtari et al.,
/// "Pareto Smoothed Importance Sampling", 2024, take for the tail. Infinite for equal values; 0 if fewer than these differ from 0.
fn tail_index(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.map(f64::abs).collect();
    let count = values.len() as f64;
    let tail = (0.2 * count).min(3.0 * count.sqrt()).ceil() as usize;
    if tail >= values.len() {
        return f64::INFINITY;
    }
    values.select_nth_unstable_by(tail, |a, b| b.total_cmp(a));
    let threshold = values[tail];
    // Equal values may all be 0.
    let above = values[..tail].iter().filter(|value| **value > threshold);
    tail as f64 / above.fold(0.0, |sum, value| sum + (value / threshold).ln())
}
