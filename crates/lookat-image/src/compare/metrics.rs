//! Numbers that say how far a picture is from another one.
//!
//! Unless something else is said, pictures are linear, of the same size and with at least one pixel, and a mean
//! is over all pixels and channels. Values that are not finite give results that mean nothing. Results do not
//! depend on the number of threads.

use rayon::prelude::*;

use super::Encoded;

/// The term that keeps relative errors of dark values finite.
const DARK: f64 = 0.01;
/// The share of pixels that [`relative_mse_trimmed`] keeps.
const KEPT: f64 = 0.999;

/// The root of the mean squared error, in the unit of the pictures. 0 for equal pictures. One bright pixel can
/// rule it.
///
/// # Panics
///
/// If the pictures do not have the same size.
pub fn rmse(actual: &[[f32; 3]], expected: &[[f32; 3]]) -> f64 {
    let [squares] = sums(actual.as_flattened(), expected.as_flattened(), |a, b| [f64::from(a - b).powi(2)]);
    (squares / samples(actual)).sqrt()
}

/// The mean of all channels.
pub fn mean(pixels: &[[f32; 3]]) -> f64 {
    let values = pixels.as_flattened();
    values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len() as f64
}

/// Mean errors, all 0 for equal pictures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Means {
    /// The mean of actual minus expected, any number: what is left of the error when noise is averaged out.
    pub error: f64,
    /// The standard error of `error`, if the errors of pixels were independent draws of one distribution: the
    /// standard deviation over pixels of the mean of the channels, by the root of the number of pixels.
    /// Errors that differ from place to place for other reasons than noise make it too large, noise that is
    /// stratified over pixels too, and noise that neighbors share makes it too small. Infinite for a single
    /// pixel.
    pub standard_error: f64,
    /// The mean absolute error, in the unit of the pictures.
    pub absolute: f64,
    /// The root of the mean squared error, see [`rmse`].
    pub rmse: f64,
    /// The relative mean squared error, (a - b)^2 / (b^2 + 0.01) with b expected (after Rousselle, Knaus and
    /// Zwicker, "Adaptive Sampling and Reconstruction using Greedy Error Minimization", SIGGRAPH Asia 2011).
    pub relative_mse: f64,
    /// The symmetric mean absolute percentage error as a number in 0..2: 2 |a - b| / (|a| + |b| + 0.01). It
    /// hardly notices single bright pixels, and hides errors of dark ones.
    pub smape: f64,
}

/// Computes all mean errors at once.
///
/// # Panics
///
/// If the pictures do not have the same size.
pub fn means(actual: &[[f32; 3]], expected: &[[f32; 3]]) -> Means {
    let samples = samples(actual);
    let errors = sums(actual.as_flattened(), expected.as_flattened(), |&a, &b| {
        let (a, b) = (f64::from(a), f64::from(b));
        let difference = (a - b).abs();
        let symmetric = 2.0 * difference / (a.abs() + b.abs() + DARK);
        [difference, difference * difference, relative_square(a, b), symmetric]
    });
    let [absolute, square, relative_mse, smape] = errors.map(|sum| sum / samples);

    let pixels = actual.len() as f64;
    let [errors, squares] = sums(actual, expected, |a, b| {
        let error = (0..3).map(|i| f64::from(a[i]) - f64::from(b[i])).sum::<f64>() / 3.0;
        [error, error * error]
    });
    let error = errors / pixels;
    let spread = (squares - errors * error).max(0.0);
    let standard_error = if pixels > 1.0 { (spread / (pixels - 1.0) / pixels).sqrt() } else { f64::INFINITY };
    Means { error, standard_error, absolute, rmse: square.sqrt(), relative_mse, smape }
}

/// The relative mean squared error of [`Means`] without its worst pixels: the mean over the pixels
/// up to and with the nearest rank of 0.999, so that one pixel of each full thousand is left out. 0 for equal
/// pictures.
///
/// # Panics
///
/// If the pictures do not have the same size.
pub fn relative_mse_trimmed(actual: &[[f32; 3]], expected: &[[f32; 3]]) -> f64 {
    let of_pixel = |a: &[f32; 3], b: &[f32; 3]| {
        (0..3).map(|i| relative_square(f64::from(a[i]), f64::from(b[i]))).sum::<f64>() / 3.0
    };
    // Ranked by the root: at most a tenth of the largest difference once it is times 0.01, so that it fits `f32`.
    let root = |a: &[f32; 3], b: &[f32; 3]| (0.01 * of_pixel(a, b).sqrt()) as f32;
    let kept = nearest_rank(KEPT, actual.len());
    let last = ranked(actual.par_iter().zip(expected).map(|(a, b)| root(a, b)), kept);
    let [smaller, count, ties, tied] = sums(actual, expected, |a, b| match root(a, b) {
        value if value < last => [of_pixel(a, b), 1.0, 0.0, 0.0],
        value if value == last => [0.0, 0.0, of_pixel(a, b), 1.0],
        _ => [0.0; 4],
    });
    // The pixels at the last rank count in part.
    (smaller + ties / tied * (kept as f64 - count)) / kept as f64
}

/// The given percentile, as a share in 0..1, of |actual - expected| over all pixels and channels, in the unit
/// of the pictures: by the nearest rank, which is the smallest of the differences such that at least this
/// share of them is not larger. 0 for equal pictures.
///
/// # Panics
///
/// If the pictures do not have the same size.
pub fn percentile_difference(actual: &[[f32; 3]], expected: &[[f32; 3]], share: f64) -> f32 {
    assert_eq!(actual.len(), expected.len());
    let pairs = actual.as_flattened().par_iter().zip(expected.as_flattened());
    ranked(pairs.map(|(a, b)| (a - b).abs()), nearest_rank(share, 3 * actual.len()))
}

/// The largest difference and its position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Largest {
    /// |actual - expected|, in the unit of the pictures.
    pub difference: f32,
    /// The column.
    pub x: usize,
    /// The row.
    pub y: usize,
    /// 0 for red, 1 for green, 2 for blue.
    pub channel: usize,
}

/// The largest |actual - expected| over all pixels and channels, and the first place in reading order that has
/// it. NaN counts as 0.
///
/// # Panics
///
/// If the pictures do not have the same size.
pub fn largest_difference(actual: &[[f32; 3]], expected: &[[f32; 3]], width: usize) -> Largest {
    assert_eq!(actual.len(), expected.len());
    let mut largest = Largest { difference: 0.0, x: 0, y: 0, channel: 0 };
    for (i, (a, b)) in actual.as_flattened().iter().zip(expected.as_flattened()).enumerate() {
        let difference = (a - b).abs();
        if difference > largest.difference {
            let pixel = i / 3;
            largest = Largest { difference, x: pixel % width, y: pixel / width, channel: i % 3 };
        }
    }
    largest
}

/// The share of pixels, 0..1, of which some channel differs by more than the threshold. 0 for equal pictures.
///
/// # Panics
///
/// If the pictures do not have the same size.
pub fn share_above(actual: &[[f32; 3]], expected: &[[f32; 3]], threshold: f32) -> f64 {
    let [above] = sums(actual, expected, |a, b| {
        let above = |i: usize| (a[i] - b[i]).abs() > threshold;
        [f64::from(u8::from(above(0) | above(1) | above(2)))]
    });
    above / actual.len() as f64
}

/// The peak signal-to-noise ratio in decibels, 10 log10(1 / MSE), of what a display is given: clipped to 0..1
/// and on the sRGB curve. Infinite for equal pictures, 0 for black against white. Clipping hides fireflies.
///
/// # Panics
///
/// If the pictures do not have the same size.
pub fn psnr(actual: &Encoded, expected: &Encoded) -> f64 {
    -20.0 * rmse(&actual.pixels, &expected.pixels).log10()
}

fn relative_square(a: f64, b: f64) -> f64 {
    (a - b) * (a - b) / (b * b + DARK)
}

fn samples(pixels: &[[f32; 3]]) -> f64 {
    3.0 * pixels.len() as f64
}

/// The bytes that are worked on at a time.
const GRAIN: usize = size_of::<[f32; 3]>() << 14;

/// Sums of some terms over all pixels or samples of two pictures, on all threads. They are added in one order, whatever the number
/// of threads.
fn sums<T: Sync, const N: usize>(
    actual: &[T],
    expected: &[T],
    terms: impl Fn(&T, &T) -> [f64; N] + Sync,
) -> [f64; N] {
    assert_eq!(actual.len(), expected.len());
    let grain = GRAIN / size_of::<T>();
    let blocks = actual.par_chunks(grain).zip(expected.par_chunks(grain));
    let blocks: Vec<_> = blocks.map(|(actual, expected)| lane_sums(actual, expected, &terms)).collect();
    blocks.into_iter().fold([0.0; N], |sum, block| std::array::from_fn(|i| sum[i] + block[i]))
}

/// Sums of some terms over pairs. Eight sums of each term, which do not wait for each other.
fn lane_sums<T, const N: usize>(
    actual: &[T],
    expected: &[T],
    terms: impl Fn(&T, &T) -> [f64; N],
) -> [f64; N] {
    const LANES: usize = 8;
    let mut lanes = [[0.0; LANES]; N];
    let mut add = |lane: usize, a: &T, b: &T| {
        for (lanes, term) in lanes.iter_mut().zip(terms(a, b)) {
            lanes[lane] += term;
        }
    };
    let ((a_chunks, a_rest), (b_chunks, b_rest)) =
        (actual.as_chunks::<LANES>(), expected.as_chunks::<LANES>());
    for (a, b) in a_chunks.iter().zip(b_chunks) {
        for lane in 0..LANES {
            add(lane, &a[lane], &b[lane]);
        }
    }
    for (a, b) in a_rest.iter().zip(b_rest) {
        add(0, a, b);
    }
    lanes.map(|lanes| lanes.iter().sum())
}

/// The smallest number of values that are at least the given share of `count`: the nearest rank, from 1 to
/// `count`. The share is in 0..1.
pub(super) fn nearest_rank(share: f64, count: usize) -> usize {
    // A share such as 0.99 is not exact, and 0.99 * 100 is not to become 100.
    ((share * count as f64 * (1.0 - f64::EPSILON)).ceil() as usize).clamp(1, count.max(1))
}

/// The value with the given rank, 1 for the smallest, among values of which none is negative. NaN counts as the largest. 0 if
/// there is no such rank.
pub(super) fn ranked(values: impl ParallelIterator<Item = f32>, rank: usize) -> f32 {
    // Without the sign of NaN and of zero.
    let mut values: Vec<f32> = values.map(f32::abs).collect();
    if !(1..=values.len()).contains(&rank) {
        return 0.0;
    }
    *values.select_nth_unstable_by(rank - 1, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::flip::{PIXELS_PER_DEGREE, hdr_flip, ldr_flip};
    use crate::compare::ssim::ssim;
    use crate::compare::tests::{Sample, radiance, shown};

    fn close(name: &str, actual: f64, expected: f64) {
        assert!((actual / expected - 1.0).abs() < 1e-6, "{name}: {actual}, not {expected}");
    }

    /// All metrics of a pair of pictures.
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct Metrics {
        means: Means,
        relative_mse_trimmed: f64,
        percentile_99: f32,
        largest: Largest,
        share_above: f64,
        psnr: f64,
        ssim: Option<f64>,
        ldr_flip: f64,
        hdr_flip: f64,
    }

    fn measure(actual: &[[f32; 3]], expected: &[[f32; 3]], width: usize, height: usize) -> Metrics {
        let shown = [actual, expected].map(Encoded::from_linear);
        Metrics {
            means: means(actual, expected),
            relative_mse_trimmed: relative_mse_trimmed(actual, expected),
            percentile_99: percentile_difference(actual, expected, 0.99),
            largest: largest_difference(actual, expected, width),
            share_above: share_above(actual, expected, 0.01),
            psnr: psnr(&shown[0], &shown[1]),
            ssim: ssim(&shown[0], &shown[1], width, height),
            ldr_flip: ldr_flip(actual, expected, width, PIXELS_PER_DEGREE),
            hdr_flip: hdr_flip(actual, expected, width, PIXELS_PER_DEGREE),
        }
    }

    /// `means` are in the order of [`Means`].
    fn check(
        sample: &Sample,
        expected: [f64; 6],
        trimmed: f64,
        percentile_99: f32,
        largest: Largest,
        psnr: f64,
    ) {
        let Sample { actual: a, expected: b, width, .. } = sample;
        let means = means(a, b);
        close("error", means.error, expected[0]);
        close("standard error", means.standard_error, expected[1]);
        close("absolute", means.absolute, expected[2]);
        close("rmse", means.rmse, expected[3]);
        close("rmse alone", rmse(a, b), expected[3]);
        close("relative", means.relative_mse, expected[4]);
        close("symmetric", means.smape, expected[5]);
        close("trimmed", relative_mse_trimmed(a, b), trimmed);
        close("psnr", super::psnr(&Encoded::from_linear(a), &Encoded::from_linear(b)), psnr);
        assert_eq!(percentile_difference(a, b, 0.99), percentile_99);
        assert_eq!(largest_difference(a, b, *width), largest);
    }

    #[test]
    fn agrees_with_numpy() {
        // NumPy 2.4.6 in double precision, percentile(method="inverted_cdf"); PSNR by scikit-image 0.26.0.
        check(
            &shown(200, 150),
            [
                0.0014493567537361134,
                0.00015993869280142757,
                0.03951822988521308,
                0.049530181779663764,
                0.047186274171837524,
                0.27377026032077517,
            ],
            0.04515801759603071,
            0.07944492,
            Largest { difference: 0.67228365, x: 60, y: 59, channel: 0 },
            23.059384627946983,
        );
        check(
            &radiance(190, 131),
            [
                0.16776022243505442,
                0.0844740226394154,
                0.4098826458925603,
                13.898042945901935,
                3.655411640315832,
                0.258075358308291,
            ],
            1.5640884421652517,
            3.2986965,
            Largest { difference: 2473.5176, x: 134, y: 42, channel: 0 },
            21.47058856308552,
        );
    }

    #[test]
    fn shares_agree_with_numpy() {
        let Sample { actual, expected, .. } = shown(200, 150);
        close("0.01", share_above(&actual, &expected, 0.01), 0.9978333333333333);
        close("0.05", share_above(&actual, &expected, 0.05), 0.7152);
    }

    /// Also where its square is beyond `f32`.
    #[test]
    fn nothing_is_trimmed_of_few_pixels() {
        for bright in [2.0, 1e30, f32::MAX] {
            let actual = [[bright, 0.5, 0.0], [0.5; 3], [bright; 3]];
            let expected = [[0.0; 3], [0.5; 3], [0.5; 3]];
            let whole = means(&actual, &expected).relative_mse;
            assert!((relative_mse_trimmed(&actual, &expected) / whole - 1.0).abs() < 1e-12, "{bright}");
        }
    }

    #[test]
    fn one_firefly_of_a_thousand_is_trimmed() {
        let expected = vec![[1.0; 3]; 1000];
        let mut actual = expected.clone();
        actual[567][1] = 100.0;
        assert!(means(&actual, &expected).relative_mse > 3.0);
        assert_eq!(relative_mse_trimmed(&actual, &expected), 0.0);
        assert!(relative_mse_trimmed(&actual[1..], &expected[1..]) > 3.0);
        assert_eq!(percentile_difference(&actual, &expected, 0.99), 0.0);
        assert_eq!(percentile_difference(&actual, &expected, 1.0), 99.0);
        let place = Largest { difference: 99.0, x: 67, y: 5, channel: 1 };
        assert_eq!(largest_difference(&actual, &expected, 100), place);
        close("error", means(&actual, &expected).error, 0.033);
        // One pixel of 1000 is off by 33 on the mean of its channels: sd / sqrt(n) = 33 / 1000.
        close("standard error", means(&actual, &expected).standard_error, 0.033);
    }

    #[test]
    fn equal_pictures_are_equal() {
        let expected = shown(33, 20).expected;
        let metrics = measure(&expected, &expected, 33, 20);
        let zero = Means {
            error: 0.0,
            standard_error: 0.0,
            absolute: 0.0,
            rmse: 0.0,
            relative_mse: 0.0,
            smape: 0.0,
        };
        assert_eq!(metrics.means, zero);
        assert_eq!(metrics.relative_mse_trimmed, 0.0);
        assert_eq!(metrics.largest, Largest { difference: 0.0, x: 0, y: 0, channel: 0 });
        assert_eq!((metrics.share_above, metrics.psnr), (0.0, f64::INFINITY));
        assert_eq!((metrics.ldr_flip, metrics.hdr_flip), (0.0, 0.0));
        assert_eq!(means(&expected[..1], &expected[..1]).standard_error, f64::INFINITY);
    }

    #[test]
    fn threads_do_not_matter() {
        let Sample { actual, expected, width, height } = shown(200, 150);
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| measure(&actual, &expected, width, height))
        };
        assert_eq!(on(1), on(3));
    }

    #[test]
    fn odd_pixels_do_not_panic() {
        let odd =
            [[f32::NAN; 3], [f32::INFINITY; 3], [f32::NEG_INFINITY; 3], [-1.0; 3], [f32::MAX; 3], [0.0; 3]];
        let odd = odd.repeat(30);
        let even = vec![[0.5; 3]; 180];
        measure(&odd, &even, 12, 15);
        measure(&even, &odd, 15, 12);
        measure(&odd, &odd, 180, 1);
    }

    #[test]
    fn finds_what_sorting_finds() {
        let mut hash = 1_u32;
        let mut next = || {
            hash = hash.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            // Some equal numbers, some that differ in the last bit, over many orders of magnitude.
            f32::from_bits((hash >> 31) * 0x3f80_0000 + (hash >> 10 & 0x7fff) * (1 << (hash >> 5 & 15)))
        };
        let items: Vec<f32> = (0..1000).map(|_| next()).collect();
        let mut sorted = items.clone();
        sorted.sort_by(f32::total_cmp);
        for (i, &expected) in sorted.iter().enumerate() {
            assert_eq!(ranked(items.par_iter().copied(), i + 1), expected, "{i}");
        }
    }

    #[test]
    fn odd_values_have_a_place() {
        let items = [-f32::NAN, -0.0, f32::INFINITY, 2.0];
        let at = |rank| ranked(items.par_iter().copied(), rank);
        assert_eq!([at(1), at(2), at(3), at(5)], [0.0, 2.0, f32::INFINITY, 0.0]);
        assert!(at(4).is_nan());
        assert_eq!(at(0), 0.0);
        assert_eq!(ranked([0.0; 0].par_iter().copied(), 0), 0.0);
    }

    #[test]
    fn ranks_are_the_nearest() {
        let check =
            |share, count, expected| assert_eq!(nearest_rank(share, count), expected, "{share} {count}");
        check(0.99, 1, 1);
        check(0.99, 100, 99);
        check(0.99, 101, 100);
        check(0.999, 1000, 999);
        check(0.0, 5, 1);
        check(1.0, 5, 5);
        check(0.99, 0, 1);
    }
}
