//! Structural similarity, and the separable filters that it shares with FLIP.

use std::ops::{Add, Mul};

use rayon::prelude::*;

use super::Encoded;

/// The window is this many pixels wide on both sides of its middle, 11 in all.
const RADIUS: usize = 5;
/// The standard deviation of the gaussian window in pixels.
const SIGMA: f64 = 1.5;
/// (K1 L)^2 and (K2 L)^2, which keep the quotients from being 0/0, for values in 0..1.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;
/// The columns and rows that are worked on at a time, so that all planes stay in the cache.
const TILE: usize = 128;
const BAND: usize = 64;

/// The mean structural similarity index of Wang, Bovik, Sheikh and Simoncelli, "Image Quality Assessment: From
/// Error Visibility to Structural Similarity" (IEEE Transactions on Image Processing 13, 2004).
///
/// 1 for equal pictures, near 0 if nothing is alike, down to -1 for opposites. It is a mean over the three
/// channels and over all places where the window of 11 x 11 pixels (gaussian with standard deviation 1.5; K1
/// = 0.01, K2 = 0.03, L = 1; variances of the population) lies within the picture. `None` if there is no such
/// place, that is if a side has fewer than 11 pixels.
///
/// It says how alike structures are and not how accurate values are: it rewards blur.
///
/// # Panics
///
/// If a picture does not have `width` times `height` pixels.
pub fn ssim(actual: &Encoded, expected: &Encoded, width: usize, height: usize) -> Option<f64> {
    assert!(actual.pixels.len() == width * height && expected.pixels.len() == width * height);
    let (columns, rows) = (width.checked_sub(2 * RADIUS)?, height.checked_sub(2 * RADIUS)?);
    if columns == 0 || rows == 0 {
        return None;
    }
    let band = |top: usize| {
        let tile = |left: usize| {
            let region = Region {
                left,
                width: TILE.min(columns - left) + 2 * RADIUS,
                start: top * width,
                end: (top + BAND.min(rows - top) + 2 * RADIUS) * width,
            };
            (0..3).map(|channel| similarity(actual, expected, width, &region, channel)).sum::<f64>()
        };
        (0..columns).step_by(TILE).map(tile).sum::<f64>()
    };
    // The sums are added in one order, whatever the number of threads.
    let bands: Vec<f64> = (0..rows.div_ceil(BAND)).into_par_iter().map(|i| band(i * BAND)).collect();
    Some(bands.iter().sum::<f64>() / (3 * columns * rows) as f64)
}

/// A rectangle of pixels: columns, and the whole rows that it lies in as a range of pixels.
struct Region {
    left: usize,
    width: usize,
    start: usize,
    end: usize,
}

/// The sum of the similarities of all windows within a region, of one channel.
fn similarity(actual: &Encoded, expected: &Encoded, width: usize, region: &Region, channel: usize) -> f64 {
    let plane = |picture: &Encoded| -> Vec<f64> {
        let rows = picture.pixels[region.start..region.end].chunks_exact(width);
        let cut = |row| <[[f32; 3]]>::iter(row).skip(region.left).take(region.width);
        rows.flat_map(cut).map(|pixel| f64::from(pixel[channel])).collect()
    };
    let (a, b) = (plane(actual), plane(expected));
    let pairs = || a.iter().zip(&b);

    let window = window();
    let local_mean = |plane: &[f64]| {
        let rows = along_rows(plane, region.width, RADIUS, &window);
        down_columns(&rows, region.width - 2 * RADIUS, RADIUS, &window)
    };
    // Of the two variances only the sum is needed, so the squares are added before they are filtered.
    let squares = local_mean(&pairs().map(|(a, b)| a * a + b * b).collect::<Vec<_>>());
    let products = local_mean(&pairs().map(|(a, b)| a * b).collect::<Vec<_>>());
    let (a, b) = (local_mean(&a), local_mean(&b));

    let index = |(((a, b), squares), products): (((&f64, &f64), &f64), &f64)| {
        let mean_squares = a * a + b * b;
        let luminance = (2.0 * a * b + C1) / (mean_squares + C1);
        let structure = (2.0 * (products - a * b) + C2) / (squares - mean_squares + C2);
        luminance * structure
    };
    a.iter().zip(&b).zip(&squares).zip(&products).map(index).sum()
}

/// The gaussian along one axis, with sum 1.
fn window() -> [f64; 2 * RADIUS + 1] {
    let gaussian: [f64; 2 * RADIUS + 1] =
        std::array::from_fn(|i| (-0.5 * ((i as f64 - RADIUS as f64) / SIGMA).powi(2)).exp());
    let sum: f64 = gaussian.iter().sum();
    gaussian.map(|weight| weight / sum)
}

/// `f32` where speed counts, `f64` where differences of large sums are taken.
pub(super) trait Number: Copy + Default + Add<Output = Self> + Mul<Output = Self> {}
impl Number for f32 {}
impl Number for f64 {}

/// Filters each row of a plane with `width` columns. What comes out has `margin` fewer columns on both sides.
/// The number of weights is odd and at most 2 * `margin` + 1; the middle one is for the pixel itself.
pub(super) fn along_rows<T: Number>(plane: &[T], width: usize, margin: usize, weights: &[T]) -> Vec<T> {
    let narrow = width - 2 * margin;
    let first = margin - weights.len() / 2;
    let mut out = vec![T::default(); plane.len() / width * narrow];
    for (row, out) in plane.chunks_exact(width).zip(out.chunks_exact_mut(narrow)) {
        weigh(weights, |k| &row[first + k..][..narrow], out);
    }
    out
}

/// Filters each column of a plane with `width` columns. What comes out has `margin` fewer rows above and
/// below. The weights are as in [`along_rows`].
pub(super) fn down_columns<T: Number>(plane: &[T], width: usize, margin: usize, weights: &[T]) -> Vec<T> {
    let first = margin - weights.len() / 2;
    let mut out = vec![T::default(); plane.len() - 2 * margin * width];
    for (y, out) in out.chunks_exact_mut(width).enumerate() {
        weigh(weights, |k| &plane[(y + first + k) * width..][..width], out);
    }
    out
}

/// `out` = sum of `weights[k] * rows(k)`; each of the rows is as long as `out`.
fn weigh<'a, T: Number + 'a>(weights: &[T], rows: impl Fn(usize) -> &'a [T], out: &mut [T]) {
    for (k, &weight) in weights.iter().enumerate() {
        for (out, &value) in out.iter_mut().zip(rows(k)) {
            *out = *out + weight * value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::tests::{Sample, radiance, shown};

    fn of(sample: &Sample) -> Option<f64> {
        let [actual, expected] =
            [&sample.actual, &sample.expected].map(|pixels| Encoded::from_linear(pixels));
        ssim(&actual, &expected, sample.width, sample.height)
    }

    #[test]
    fn agrees_with_scikit_image() {
        // skimage.metrics.structural_similarity of scikit-image 0.26.0 with gaussian_weights=True, sigma=1.5,
        // use_sample_covariance=False, data_range=1, channel_axis=2, on the clipped and encoded pictures in
        // double precision.
        let check = |sample: Sample, expected: f64| {
            let actual = of(&sample).unwrap();
            println!("{} x {}: {:.2e}", sample.width, sample.height, actual - expected);
            assert!((actual - expected).abs() < 1e-6, "{actual}, not {expected}");
        };
        check(shown(200, 150), 0.5761886136242967);
        check(shown(31, 17), 0.7392826261819835);
        check(radiance(190, 131), 0.2578798114027072);
    }

    #[test]
    fn needs_room_for_the_window() {
        assert_eq!(of(&shown(10, 40)), None);
        assert_eq!(of(&shown(40, 10)), None);
        assert!(of(&shown(11, 11)).is_some());
    }

    #[test]
    fn equal_pictures_give_one() {
        let expected = Encoded::from_linear(&shown(150, 80).expected);
        let index = ssim(&expected, &expected, 150, 80).unwrap();
        assert!((index - 1.0).abs() < 1e-12);
    }

    #[test]
    fn weighs_neighbors() {
        // Five rows of 21 columns, more than sixteen inside the margin; each number tells its place.
        let plane: Vec<f64> = (0..5 * 21).map(|i| f64::from(i % 21 + 100 * (i / 21))).collect();
        let rows = along_rows(&plane, 21, 2, &[1.0, 0.0, 10.0]);
        assert_eq!(rows.len(), 5 * 17);
        for (i, &value) in rows.iter().enumerate() {
            let at = |x: usize| plane[i / 17 * 21 + i % 17 + x];
            assert_eq!(value, at(1) + 10.0 * at(3), "{i}");
        }

        let columns = down_columns(&plane, 21, 1, &[1.0, 0.0, 10.0]);
        assert_eq!(columns.len(), 3 * 21);
        for (i, &value) in columns.iter().enumerate() {
            assert_eq!(value, plane[i] + 10.0 * plane[i + 42], "{i}");
        }
        assert_eq!(down_columns(&plane, 21, 2, &[1.0]), plane[42..63]);
    }
}
