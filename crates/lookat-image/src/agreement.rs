//! Whether two noisy pictures show the same: tests of their means, of tiles and of pixels.
//!
//! They rest on the standard errors of [`PixelError`]. Noise is taken to be independent from pixel to pixel.

use std::num::NonZeroU32;

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use crate::{Aligned, PixelError, Window};

/// Pixels on a side of a tile.
const TILE: u32 = 16;
/// The power of [`Agreement::visible_in_mean`].
const POWER: f64 = 0.95;
/// What rounding may do to a value, by the value: differences of this size are no sign of anything. For pictures by this
/// renderer, which sums in double precision,
const ROUNDING: f64 = 1.0 / (1 << 20) as f64;
/// for others, which may sum thousands of samples in single precision,
const SUM_ROUNDING: f64 = 1.0 / (1 << 13) as f64;
/// and for a picture that was stored in half precision.
const HALF_ROUNDING: f64 = 1.0 / (1 << 11) as f64;
/// How much larger the error of a mean of pixels may be than that of independent ones, because filters of several pixels
/// make neighbours alike.
const FILTERED: f32 = 2.0;
/// A pixel of fewer samples takes itself for exact too often to be held against one of which nothing is known.
const FEWEST_SAMPLES: u32 = 16;
/// Fewer pixels than these are not tested one by one.
const FEWEST_PIXELS: usize = 100;

/// The result of testing one difference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Test {
    /// 0 for red, 1 for green, 2 for blue.
    pub channel: usize,
    /// Where: the whole window, or a tile of it.
    pub window: Window,
    /// The mean of actual minus expected there, in the unit of the pictures.
    pub difference: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// The probability of such a difference, or a larger one, if there is nothing but noise. 0..1.
    pub p: f64,
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

/// What the tests say of two pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct Agreement {
    /// Whether the errors of the expected picture are known; if not, it was taken to be as noisy as the actual one.
    pub expected_is_known: bool,
    /// The means of the whole pictures, for each channel.
    pub means: Vec<Test>,
    /// The means of tiles of 16 x 16 pixels, for each channel.
    pub tiles: Vec<Test>,
    /// The means again, for each channel, with standard errors from how much the differences of pixels scatter: it finds
    /// small errors of pictures that share their noise. As the next ones, only of pixels of which both errors are known,
    /// and the number of samples is about the same: the noise of others is skewed.
    pub paired: Vec<Test>,
    /// Pixel by pixel, for each channel that has pixels enough with at least 6 replicates.
    pub pixels: Vec<PixelTest>,
    /// The smallest p of all tests, corrected for their number: half of the chance of a false alarm is that of the tiles,
    /// half that of the tests of whole pictures, evenly within each (Bonferroni). 0..1. Pictures that differ by nothing but
    /// noise get less than x with a probability of at most x.
    pub p: f64,
}

impl Agreement {
    /// Whether the pictures agree: nothing but noise tells them apart. `significance`, in 0..1, is the probability of a
    /// false alarm.
    pub fn holds(&self, significance: f64) -> bool {
        self.p >= significance
    }

    /// Below this p, a test of whole pictures has found a difference.
    pub fn level_of_whole(&self, significance: f64) -> f64 {
        significance / (2 * self.of_whole().count().max(1)) as f64
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

    fn of_whole(&self) -> impl Iterator<Item = f64> {
        let means = self.means.iter().chain(&self.paired).map(|test| test.p);
        means.chain(self.pixels.iter().map(|test| test.p))
    }

    /// The smallest p, corrected.
    fn corrected(&self) -> f64 {
        let smallest = |values: &mut dyn Iterator<Item = f64>| values.fold(1.0, f64::min);
        let whole = smallest(&mut self.of_whole()) * self.of_whole().count() as f64;
        let tiles = smallest(&mut self.tiles.iter().map(|test| test.p)) * self.tiles.len() as f64;
        (2.0 * whole.min(tiles)).min(1.0)
    }
}

/// The smallest difference, in standard errors, that a test at this level finds with a probability of 95 %.
fn visible(level: f64) -> f64 {
    let normal = Normal::standard();
    normal.inverse_cdf(POWER) - normal.inverse_cdf(level / 2.0)
}

/// Tests whether two pictures agree up to noise. `None` if the errors of the actual picture are not known: then nothing
/// tells noise from bias.
///
/// Where those of the expected picture are not known, it is taken to be as noisy as the actual one, or as the differences of
/// the pixels of a tile scatter if that is more; of the actual one only pixels of 16 samples or more count then. A picture
/// with fewer samples than the other is taken to be at least as noisy as the other would be with so few: rare events that
/// it has not met do not count as a difference.
pub fn agreement(pair: &Aligned) -> Option<Agreement> {
    let noise = Noise::new(pair)?;
    let whole = Window { x: 0, y: 0, ..pair.window };
    let mut result = Agreement {
        expected_is_known: pair.expected_errors.is_some(),
        means: Vec::new(),
        tiles: Vec::new(),
        paired: Vec::new(),
        pixels: Vec::new(),
        p: 1.0,
    };
    for channel in 0..3 {
        result.means.extend(noise.test_mean(pair, whole, channel));
        result.tiles.extend(tiles(whole).filter_map(|tile| noise.test_mean(pair, tile, channel)));
        result.paired.extend(noise.test_paired(pair, channel));
        result.pixels.extend(noise.test_pixels(pair, channel));
    }
    result.p = result.corrected();
    (!result.means.is_empty()).then_some(result)
}

/// The tiles of a window.
fn tiles(window: Window) -> impl Iterator<Item = Window> {
    let starts = |size: u32| (0..size).step_by(TILE as usize);
    let side = move |start: u32, size: u32| TILE.min(size - start);
    starts(window.height).flat_map(move |y| {
        starts(window.width).map(move |x| Window {
            x: x as i32,
            y: y as i32,
            width: side(x, window.width),
            height: side(y, window.height),
        })
    })
}

/// The pixels of a part of the pictures.
fn places(part: Window, pair: &Aligned) -> impl Iterator<Item = usize> {
    let (x0, y0, row) = (part.x as usize, part.y as usize, pair.window.width as usize);
    let (width, height) = (part.width as usize, part.height as usize);
    (y0..y0 + height).flat_map(move |y| (x0..x0 + width).map(move |x| y * row + x))
}

/// The noise of a pair of pictures.
struct Noise {
    expected_is_known: bool,
    actual: Vec<PixelError>,
    expected: Vec<PixelError>,
    rounding: f64,
}

/// The difference of two pixels in one channel.
struct Difference {
    value: f64,
    variance: f64,
    /// The sum of what the variance consists of, squared, by the degrees of freedom of each (Welch and Satterthwaite).
    spread: f64,
    /// What rounding may do, which is alike in neighbours.
    rounding: f64,
    /// Whether both have about as many samples, so that their difference is not skewed. Not if one is not known.
    is_even: bool,
}

impl Difference {
    /// The degrees of freedom of the variance.
    fn freedom(&self) -> f64 {
        self.variance * self.variance / self.spread
    }
}

impl Noise {
    fn new(pair: &Aligned) -> Option<Noise> {
        let actual = pair.actual_errors.clone()?;
        let expected = pair.expected_errors.clone().unwrap_or_else(|| scattered(pair, &actual));
        let is_half = |pixels: &[[f32; 3]]| {
            pixels.as_flattened().iter().all(|value| ::exr::prelude::f16::from_f32(*value).to_f32() == *value)
        };
        let rounding = match () {
            () if is_half(&pair.actual) || is_half(&pair.expected) => HALF_ROUNDING,
            () if pair.expected_errors.is_none() => SUM_ROUNDING,
            () => ROUNDING,
        };
        Some(Noise { expected_is_known: pair.expected_errors.is_some(), actual, expected, rounding })
    }

    /// The difference of a pixel; `None` if its error is not known.
    fn difference(&self, pair: &Aligned, pixel: usize, channel: usize) -> Option<Difference> {
        let (a, b) = (f64::from(pair.actual[pixel][channel]), f64::from(pair.expected[pixel][channel]));
        let (a_error, b_error) = (&self.actual[pixel], &self.expected[pixel]);
        let [a_variance, b_variance] =
            [a_error, b_error].map(|error| f64::from(error.standard_error[channel]).powi(2));
        if !self.expected_is_known && a_error.samples < FEWEST_SAMPLES {
            return None;
        }
        let freedom = |error: &PixelError| NonZeroU32::new(error.replicates.saturating_sub(1));
        let (a_freedom, b_freedom) = (freedom(a_error)?.get(), freedom(b_error)?.get());
        // At the same noise per sample.
        let ratio = f64::from(a_error.samples) / f64::from(b_error.samples);
        let a_variance = a_variance.max(if ratio < 1.0 { b_variance / ratio } else { 0.0 });
        let b_variance = b_variance.max(if ratio > 1.0 { a_variance * ratio } else { 0.0 });
        let variance = a_variance + b_variance;
        variance.is_finite().then(|| Difference {
            value: a - b,
            variance,
            spread: a_variance.powi(2) / f64::from(a_freedom) + b_variance.powi(2) / f64::from(b_freedom),
            rounding: self.rounding * a.abs().max(b.abs()),
            is_even: self.expected_is_known && (0.5..=2.0).contains(&ratio),
        })
    }

    /// Tests the mean of a part of the pictures. `None` if nothing is known of its pixels.
    fn test_mean(&self, pair: &Aligned, part: Window, channel: usize) -> Option<Test> {
        let mut sum = Difference { value: 0.0, variance: 0.0, spread: 0.0, rounding: 0.0, is_even: true };
        let mut count = 0.0;
        for pixel in places(part, pair).filter_map(|pixel| self.difference(pair, pixel, channel)) {
            sum.value += pixel.value;
            sum.variance += pixel.variance;
            sum.spread += pixel.spread;
            sum.rounding += pixel.rounding;
            count += 1.0;
        }
        let standard_error = (sum.variance + sum.rounding.powi(2)).sqrt() / count;
        let difference = sum.value / count;
        let window = Window { x: part.x + pair.window.x, y: part.y + pair.window.y, ..part };
        let p = two_sided(difference / standard_error, sum.freedom());
        (count > 0.0).then_some(Test { channel, window, difference, standard_error, p })
    }

    /// Tests the mean by how the differences of pixels scatter.
    fn test_paired(&self, pair: &Aligned, channel: usize) -> Option<Test> {
        let pixels = (0..pair.actual.len()).filter_map(|pixel| self.difference(pair, pixel, channel));
        let pixels: Vec<Difference> = pixels.filter(|pixel| pixel.is_even).collect();
        let count = pixels.len() as f64;
        let mean = |value: fn(&Difference) -> f64| pixels.iter().map(value).sum::<f64>() / count;
        let (difference, rounding) = (mean(|pixel| pixel.value), mean(|pixel| pixel.rounding));
        let squares = pixels.iter().map(|pixel| (pixel.value - difference).powi(2)).sum::<f64>();
        let standard_error = (squares / (count * (count - 1.0)) + rounding.powi(2)).sqrt();
        let p = two_sided(difference / standard_error, count - 1.0);
        (pixels.len() >= FEWEST_PIXELS).then_some(Test {
            channel,
            window: pair.window,
            difference,
            standard_error,
            p,
        })
    }

    /// Tests the pixels of a channel together.
    fn test_pixels(&self, pair: &Aligned, channel: usize) -> Option<PixelTest> {
        let mut sums = [0.0; 3];
        let mut pixels = 0;
        for at in 0..pair.actual.len() {
            let Some(pixel) = self.difference(pair, at, channel) else { continue };
            let n = pixel.freedom();
            // The variance of t squared is finite above 4; black and rounded pixels have nothing to say.
            if !pixel.is_even || n.is_nan() || n <= 4.5 || pixel.variance < pixel.rounding.powi(2) {
                continue;
            }
            let mean = n / (n - 2.0);
            sums[0] += pixel.value.powi(2) / (pixel.variance + pixel.rounding.powi(2));
            sums[1] += mean;
            sums[2] += 2.0 * mean.powi(2) * (n - 1.0) / (n - 4.0);
            pixels += 1;
        }
        let [sum, expected, variance] = sums;
        let p = Normal::standard().sf((sum - expected) / variance.sqrt());
        (pixels >= FEWEST_PIXELS).then_some(PixelTest { channel, pixels, ratio: sum / expected, p })
    }
}

/// The errors of the expected picture, guessed: those of the actual one, or what the differences scatter beyond those.
/// Other renderers have noise where this one has none.
fn scattered(pair: &Aligned, actual: &[PixelError]) -> Vec<PixelError> {
    let mut errors = actual.to_vec();
    let whole = Window { x: 0, y: 0, ..pair.window };
    for tile in tiles(whole) {
        for channel in 0..3 {
            let at = |pixel: usize| pair.actual[pixel][channel] - pair.expected[pixel][channel];
            let own =
                places(tile, pair).map(|pixel| f64::from(actual[pixel].standard_error[channel]).powi(2));
            let own = own.sum::<f64>() / f64::from(tile.width * tile.height);
            let all = f64::from(scatter(places(tile, pair).map(at).collect())).powi(2);
            let others = FILTERED * (all - own).max(0.0).sqrt() as f32;
            for pixel in places(tile, pair) {
                let error = &mut errors[pixel].standard_error[channel];
                *error = error.max(others);
            }
        }
    }
    errors
}

/// The standard deviation of values of which less than half have been moved, by their median distance from the median.
fn scatter(mut values: Vec<f32>) -> f32 {
    let middle = values.len() / 2;
    let median = |values: &mut [f32]| *values.select_nth_unstable_by(middle, f32::total_cmp).1;
    let center = median(&mut values);
    values.iter_mut().for_each(|value| *value = (*value - center).abs());
    1.4826 * median(&mut values)
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

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: u32 = 20;
    const HEIGHT: u32 = 18;

    fn pixels<T>(of: impl Fn(usize, usize) -> T) -> Vec<[T; 3]> {
        (0..(WIDTH * HEIGHT) as usize).map(|i| std::array::from_fn(|channel| of(i, channel))).collect()
    }

    fn values(step: usize) -> Vec<[f32; 3]> {
        pixels(|i, c| (1.0 + c as f64 + 0.01 * (((i * (7 + step) + 3 * c) % 23) as f64 - 11.0)) as f32)
    }

    fn errors(step: usize, factor: f32, samples: u32) -> Vec<PixelError> {
        let errors = pixels(|i, c| (0.05 + 0.01 * ((i * (5 + step) + c) % 7) as f64) as f32 * factor);
        errors
            .into_iter()
            .map(|standard_error| PixelError { standard_error, samples, replicates: 16 })
            .collect()
    }

    /// Two pictures of noise, of 64 and 128 samples; the first one is brighter in the green of the first tile.
    fn sample() -> Aligned {
        let mut actual = values(0);
        for (i, pixel) in actual.iter_mut().enumerate() {
            if i % WIDTH as usize / 16 + i / WIDTH as usize / 16 == 0 {
                pixel[1] = (f64::from(pixel[1]) + 0.03) as f32;
            }
        }
        Aligned {
            window: Window { x: 100, y: 50, width: WIDTH, height: HEIGHT },
            actual,
            expected: values(4),
            actual_errors: Some(errors(0, 1.0, 64)),
            expected_errors: Some(errors(6, 0.5, 128)),
            left_out: 0,
        }
    }

    fn close(actual: f64, expected: f64) {
        assert!((actual - expected).abs() <= 1e-6 * expected.abs(), "{actual}, not {expected}");
    }

    #[test]
    fn agrees_with_scipy() {
        // SciPy 1.17, from the formulas.
        let found = agreement(&sample()).unwrap();
        let check = |test: &Test, [difference, standard_error, p]: [f64; 3]| {
            close(test.difference, difference);
            close(test.standard_error, standard_error);
            close(test.p, p);
        };
        check(&found.means[0], [-0.0008055559462971158, 0.004913095198090966, 0.8697668737002262]);
        check(&found.means[1], [0.021166646480560304, 0.004935756655405461, 1.8249309798179844e-05]);
        check(&found.tiles[4], [0.02984372153878212, 0.00584715556829379, 3.4567807368930896e-07]);
        check(&found.tiles[11], [-0.01374998688697815, 0.03336001568077609, 0.6807496741946799]);
        check(&found.paired[0], [-0.0008055559462971158, 0.004844907582234274, 0.868039185650213]);
        check(&found.paired[1], [0.021166646480560304, 0.005479419753850177, 0.00013290067633635785]);
        for (test, [ratio, p]) in found.pixels.iter().zip([
            [1.0713656385899022, 0.18802505873985714],
            [1.3494413503895484, 7.3552171162983065e-06],
            [0.9980897729655746, 0.5094307904075166],
        ]) {
            close(test.ratio, ratio);
            close(test.p, p);
            assert_eq!(test.pixels, 360);
        }
        close(found.p, 8.296273768543415e-06);
        close(found.visible_in_mean(0.01), 0.02558575099012999);
        assert!(!found.holds(0.01) && found.holds(1e-6));
        let tiles = found.differing_tiles(0.01);
        assert_eq!(tiles, [found.tiles[4]]);
        assert_eq!(tiles[0].window, Window { x: 100, y: 50, width: 16, height: 16 });
    }

    #[test]
    fn without_errors_nothing_is_told() {
        assert!(agreement(&Aligned { actual_errors: None, ..sample() }).is_none());
        let unknown = PixelError { standard_error: [f32::INFINITY; 3], samples: 1, replicates: 1 };
        assert!(agreement(&Aligned { actual_errors: Some(vec![unknown; 360]), ..sample() }).is_none());
    }

    /// Noise of the expected picture that is not known shows in how the differences scatter; the mean of a tile does not.
    #[test]
    fn unknown_noise_is_seen_in_the_scatter() {
        let still = PixelError { standard_error: [0.0; 3], samples: 64, replicates: 16 };
        let mut pair = Aligned { actual_errors: Some(vec![still; 360]), expected_errors: None, ..sample() };
        pair.actual = vec![[1.0, 2.0, 3.0]; 360];
        let found = agreement(&pair).unwrap();
        assert!(!found.expected_is_known && found.pixels.is_empty() && found.holds(0.01), "{}", found.p);
        pair.actual.iter_mut().for_each(|pixel| pixel[2] += 0.1);
        assert!(!agreement(&pair).unwrap().holds(1e-6));
    }

    /// Few samples say nothing of skewed noise: neither where only they are known, nor against many.
    #[test]
    fn few_samples_are_not_believed() {
        let mut pair = sample();
        pair.expected_errors = None;
        assert!(agreement(&pair).is_some());
        pair.actual_errors.as_mut().unwrap().iter_mut().for_each(|error| error.samples = 15);
        assert_eq!(agreement(&pair), None);
        pair.expected_errors = Some(errors(6, 0.5, 1024));
        let found = agreement(&pair).unwrap();
        assert!(found.pixels.is_empty() && found.paired.is_empty());
    }

    /// Pictures with the same noise tell small errors by it.
    #[test]
    fn noise_in_common_cancels() {
        let mut pair = sample();
        pair.expected_errors.clone_from(&pair.actual_errors);
        pair.actual.clone_from(&pair.expected);
        assert_eq!(agreement(&pair).unwrap().p, 1.0);
        pair.actual.iter_mut().for_each(|pixel| pixel[0] *= 1.002);
        let found = agreement(&pair).unwrap();
        assert!(found.means[0].p > 0.5 && !found.holds(1e-6), "{found:?}");
    }

    /// Values without noise may differ by rounding, and by no more.
    #[test]
    fn rounding_is_no_difference() {
        let still = PixelError { standard_error: [0.0; 3], samples: 64, replicates: 16 };
        let errors = Some(vec![still; 360]);
        let pair = |factor: f32, expected_errors: &Option<Vec<PixelError>>| {
            let mut pair = sample();
            pair.actual.clone_from(&pair.expected);
            pair.actual.as_flattened_mut().iter_mut().for_each(|value| *value *= factor);
            agreement(&Aligned {
                actual_errors: errors.clone(),
                expected_errors: expected_errors.clone(),
                ..pair
            })
        };
        assert_eq!(pair(1.0, &errors).unwrap().p, 1.0);
        assert!(pair(1.000_001, &errors).unwrap().holds(0.01));
        assert!(!pair(1.000_01, &errors).unwrap().holds(0.01));
        // Sums of another renderer may be in single precision.
        assert!(pair(1.000_1, &None).unwrap().holds(0.01));
        assert!(!pair(1.001, &None).unwrap().holds(0.01));
    }

    /// One pixel that has not met what the other picture has is no difference.
    #[test]
    fn rare_events_that_few_samples_miss_are_no_difference() {
        let mut pair = sample();
        let (actual, expected) =
            (pair.actual_errors.as_mut().unwrap(), pair.expected_errors.as_mut().unwrap());
        pair.expected[7] = [40.0; 3];
        (actual[7].standard_error, expected[7].standard_error) = ([0.01; 3], [20.0; 3]);
        assert!(agreement(&pair).unwrap().tiles[0].p > 0.01);
    }
}
