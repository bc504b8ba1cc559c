//! How noisy each pixel of a pair of pictures is.

use super::{FEWEST_PIXELS, Untestable, in_tile, tiles};
use crate::{Aligned, PixelError, Precision, Window};

/// What rounding may do to a value, by the value: differences of this size are no sign of anything. For pictures by this
/// renderer, which sums in double precision,
const ROUNDING: f64 = 1.0 / (1 << 20) as f64;
/// for others, which may sum thousands of samples in single precision,
const SUM_ROUNDING: f64 = 1.0 / (1 << 13) as f64;
/// and for a picture that was stored in half precision.
const HALF_ROUNDING: f64 = 1.0 / (1 << 11) as f64;
/// A pixel of fewer samples takes itself for exact too often to be held against one of which nothing is known.
const FEWEST_SAMPLES: u32 = 16;
/// How much larger the error of a mean of pixels may be than that of independent ones, because filters of several pixels
/// make neighbours alike.
const FILTERED: f32 = 2.0;

/// The difference of two pixels in one channel.
pub(super) struct Difference {
    /// Actual minus expected.
    pub value: f64,
    pub variance: f64,
    /// The sum of what the variance consists of, squared, by the degrees of freedom of each (Welch and Satterthwaite).
    pub spread: f64,
    /// What rounding may do, which is alike in neighbours.
    pub rounding: f64,
    /// Whether both have about as many samples, so that their difference is not skewed. Not if one is not known.
    pub is_even: bool,
}

impl Difference {
    /// The degrees of freedom of the variance.
    pub fn freedom(&self) -> f64 {
        self.variance * self.variance / self.spread
    }
}

/// The noise of a pair of pictures, of which each pixel is known.
pub(super) struct Noise {
    expected_is_known: bool,
    actual: Vec<PixelError>,
    expected: Vec<PixelError>,
    rounding: f64,
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
        let unknown = |errors: &[PixelError]| errors.iter().filter(|error| !error.is_known(needed)).count();
        match (unknown(&actual), pair.expected_errors.as_deref().map_or(0, unknown)) {
            (0, 0) => {}
            (0, pixels) => return Err(Untestable::Expected { pixels }),
            (pixels, _) => return Err(Untestable::Actual { pixels, needed }),
        }
        let expected = pair.expected_errors.clone().unwrap_or_else(|| guessed(pair, &actual));
        let rounding = match (pair.precision, expected_is_known) {
            (Precision::Single, true) => ROUNDING,
            (Precision::Single, false) => SUM_ROUNDING,
            _ => HALF_ROUNDING,
        };
        Ok(Noise { expected_is_known, actual, expected, rounding })
    }

    /// The differences of all pixels.
    pub fn differences(&self, pair: &Aligned, channel: usize) -> Vec<Difference> {
        (0..pair.actual.len()).map(|pixel| self.difference(pair, pixel, channel)).collect()
    }

    fn difference(&self, pair: &Aligned, pixel: usize, channel: usize) -> Difference {
        let (a, b) = (f64::from(pair.actual[pixel][channel]), f64::from(pair.expected[pixel][channel]));
        let (a_error, b_error) = (&self.actual[pixel], &self.expected[pixel]);
        let [a_variance, b_variance] =
            [a_error, b_error].map(|error| f64::from(error.standard_error[channel]).powi(2));
        let freedom = |error: &PixelError| f64::from(error.replicates - 1);
        // At the same noise per sample.
        let ratio = f64::from(a_error.samples) / f64::from(b_error.samples);
        let a_variance = a_variance.max(if ratio < 1.0 { b_variance / ratio } else { 0.0 });
        let b_variance = b_variance.max(if ratio > 1.0 { a_variance * ratio } else { 0.0 });
        Difference {
            value: a - b,
            variance: a_variance + b_variance,
            spread: a_variance.powi(2) / freedom(a_error) + b_variance.powi(2) / freedom(b_error),
            rounding: self.rounding * a.abs().max(b.abs()),
            is_even: self.expected_is_known && (0.5..=2.0).contains(&ratio),
        }
    }
}

/// The errors of the expected picture where it does not give them. They are the largest of three: those of the actual picture,
/// times what all tiles together ask for; what the differences of a tile scatter, which single bright pixels make large;
/// and what most of its differences scatter beyond the errors of the actual picture, as other renderers have noise where
/// this one has none.
fn guessed(pair: &Aligned, actual: &[PixelError]) -> Vec<PixelError> {
    let factor = noisier(pair, actual) as f32;
    let mut errors = actual.to_vec();
    errors.iter_mut().flat_map(|error| &mut error.standard_error).for_each(|error| *error *= factor);
    for tile in tiles(pair) {
        for channel in 0..3 {
            let at = |pixel: usize| pair.actual[pixel][channel] - pair.expected[pixel][channel];
            let differences: Vec<f32> = in_tile(tile, pair).map(at).collect();
            let own =
                in_tile(tile, pair).map(|pixel| f64::from(actual[pixel].standard_error[channel]).powi(2));
            let own = own.sum::<f64>() / tile.area() as f64;
            let plain = (variance(&differences) - own).max(0.0).sqrt() as f32;
            let most = f64::from(scatter(differences)).powi(2);
            let others = plain.max(FILTERED * (most - own).max(0.0).sqrt() as f32);
            for pixel in in_tile(tile, pair) {
                let error = &mut errors[pixel].standard_error[channel];
                *error = error.max(others);
            }
        }
    }
    errors
}

/// How many times larger the errors of the expected picture are than those of the actual one, by nine tiles of ten: an error of
/// the others is none of noise. At least 1.
fn noisier(pair: &Aligned, actual: &[PixelError]) -> f64 {
    let ratio = |tile: Window| {
        let (mut squares, mut own) = (0.0, 0.0);
        for pixel in in_tile(tile, pair) {
            for channel in 0..3 {
                let difference =
                    f64::from(pair.actual[pixel][channel]) - f64::from(pair.expected[pixel][channel]);
                squares += difference.powi(2);
                own += f64::from(actual[pixel].standard_error[channel]).powi(2);
            }
        }
        (own > 0.0).then(|| squares / own)
    };
    let mut ratios: Vec<f64> = tiles(pair).filter_map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    let high = ratios.get(ratios.len().saturating_sub(1) * 9 / 10).copied().unwrap_or(0.0);
    (high - 1.0).max(1.0).sqrt()
}

fn variance(values: &[f32]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().map(|x| f64::from(*x)).sum::<f64>() / count;
    values.iter().map(|x| (f64::from(*x) - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0)
}

/// The standard deviation of values of which less than half have been moved, by their median distance from the median.
fn scatter(mut values: Vec<f32>) -> f32 {
    let middle = values.len() / 2;
    let median = |values: &mut [f32]| *values.select_nth_unstable_by(middle, f32::total_cmp).1;
    let center = median(&mut values);
    values.iter_mut().for_each(|value| *value = (*value - center).abs());
    1.4826 * median(&mut values)
}
