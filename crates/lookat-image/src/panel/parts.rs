//! The three parts as pixels.

use rayon::prelude::*;

use super::canvas::Canvas;
use super::colors::{NOT_FINITE_COLOR, difference_color};
use super::scale::ColorScale;
use crate::display::Encoded;

/// The least width of a part, in pixels, to which pictures are magnified, and the most of its width and
/// height.
pub(super) const LEAST: usize = 256;
pub(super) const MOST: usize = 1280;

/// How large a picture is shown: each pixel as `up` x `up` ones, or `down` x `down` pixels as one. Both are
/// at least 1, and one of them is 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Zoom {
    pub up: usize,
    pub down: usize,
}

impl Zoom {
    pub fn of(width: usize, height: usize) -> Zoom {
        let longer = width.max(height);
        let up = LEAST.div_ceil(width).min(MOST / longer).max(1);
        Zoom { up, down: longer.div_ceil(MOST) }
    }

    /// In words; `None` if nothing changes.
    pub fn caption(self) -> Option<String> {
        match self {
            Zoom { up: 1, down: 1 } => None,
            Zoom { up: 1, down } => Some(format!("reduced to 1/{down}")),
            Zoom { up, .. } => Some(format!("magnified {up} times")),
        }
    }
}

/// A picture as a display shows it, times `gain`. A box of `down` x `down` pixels becomes their mean.
pub(super) fn shown(pixels: &[[f32; 3]], width: usize, down: usize, gain: f64) -> Canvas {
    let means = box_means(pixels, width, down);
    let linear: Vec<[f32; 3]> =
        means.par_iter().map(|mean| mean.map(|x| (gain * f64::from(x)) as f32)).collect();
    let color = |(mean, encoded): (&[f32; 3], &[f32; 3])| {
        if is_finite(mean) { encoded.map(|x| (255.0 * x).round() as u8) } else { NOT_FINITE_COLOR }
    };
    let encoded = Encoded::from_linear(&linear).pixels;
    Canvas { width: width.div_ceil(down), pixels: means.par_iter().zip(&encoded).map(color).collect() }
}

/// A smaller picture: the means of boxes of `side` x `side` pixels, those at the right and at the bottom of what
/// is left. A pixel that is not finite makes its mean so.
pub fn box_means(pixels: &[[f32; 3]], width: usize, side: usize) -> Vec<[f32; 3]> {
    let add = |sum: [f64; 4], pixel: [f32; 3]| {
        let [r, g, b] = pixel.map(f64::from);
        [sum[0] + r, sum[1] + g, sum[2] + b, sum[3] + 1.0]
    };
    let sums = boxes(pixels, width, side, [0.0; 4], add);
    sums.into_par_iter().map(|[r, g, b, count]| [r, g, b].map(|sum| (sum / count) as f32)).collect()
}

/// Differences in false color. A box of `down` x `down` pixels becomes the one of largest magnitude. Without
/// a scale all are 0 or NaN.
pub(super) fn false_color(
    differences: &[f32],
    width: usize,
    down: usize,
    scale: Option<ColorScale>,
) -> Canvas {
    let largest = |a: f32, b: f32| if b.is_nan() || b.abs() > a.abs() { b } else { a };
    let limit = scale.map_or(1.0, |scale| scale.limit);
    let pixels = boxes(differences, width, down, 0.0, largest)
        .into_par_iter()
        .map(|difference| difference_color(f64::from(difference) / limit))
        .collect();
    Canvas { width: width.div_ceil(down), pixels }
}

/// actual - expected for each pixel, of the channel where its magnitude is largest. NaN if a channel of
/// either is not finite.
pub(super) fn differences(actual: &[[f32; 3]], expected: &[[f32; 3]]) -> Vec<f32> {
    let difference = |(a, b): (&[f32; 3], &[f32; 3])| {
        if !(is_finite(a) && is_finite(b)) {
            return f32::NAN;
        }
        let channels: [f32; 3] = std::array::from_fn(|i| (a[i] - b[i]).clamp(f32::MIN, f32::MAX));
        channels.into_iter().fold(0.0, |largest: f32, x| if x.abs() > largest.abs() { x } else { largest })
    };
    actual.par_iter().zip(expected).map(difference).collect()
}

pub(super) fn is_finite(pixel: &[f32; 3]) -> bool {
    pixel.iter().all(|x| x.is_finite())
}

/// Folds each box of `side` x `side` values, row by row. The boxes at the right and at the bottom may be
/// smaller.
fn boxes<T: Copy + Sync, U: Copy + Send + Sync>(
    values: &[T],
    width: usize,
    side: usize,
    start: U,
    add: impl Fn(U, T) -> U + Sync,
) -> Vec<U> {
    let rows_of_boxes = values.par_chunks(width * side);
    let fold = |rows: &[T]| {
        let mut folded = vec![start; width.div_ceil(side)];
        for row in rows.chunks_exact(width) {
            for (folded, values) in folded.iter_mut().zip(row.chunks(side)) {
                *folded = values.iter().fold(*folded, |folded, &value| add(folded, value));
            }
        }
        folded
    };
    rows_of_boxes.flat_map_iter(fold).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_get_a_handy_size() {
        let check = |width, height, up, down| {
            assert_eq!(Zoom::of(width, height), Zoom { up, down }, "{width} x {height}");
        };
        check(8, 6, 32, 1);
        check(100, 80, 3, 1);
        check(256, 1, 1, 1);
        check(255, 100, 2, 1);
        check(1280, 1280, 1, 1);
        check(1281, 700, 1, 2);
        check(1920, 1080, 1, 2);
        check(3840, 2160, 1, 3);
        check(40, 600, 2, 1);
        check(1, 5000, 1, 4);
        check(1 << 28, 1, 1, 209_716);
        let captions =
            [(8, 6), (300, 200), (4000, 20)].map(|(width, height)| Zoom::of(width, height).caption());
        assert_eq!(captions, [Some("magnified 32 times".into()), None, Some("reduced to 1/4".into())]);
    }

    #[test]
    fn the_channel_that_differs_most_counts() {
        let difference = |actual, expected| differences(&[actual], &[expected])[0];
        assert_eq!(difference([1.0, 2.0, 3.0], [1.0, 4.0, 2.0]), -2.0);
        assert_eq!(difference([1.0; 3], [1.0; 3]), 0.0);
        assert_eq!(difference([f32::MAX; 3], [f32::MIN; 3]), f32::MAX);
        assert!(difference([1.0, f32::NAN, 1.0], [0.0; 3]).is_nan());
        assert!(difference([1.0; 3], [1.0, f32::INFINITY, 1.0]).is_nan());
        assert!(difference([f32::INFINITY; 3], [f32::INFINITY; 3]).is_nan());
    }

    #[test]
    fn reduced_pictures_are_means_of_light() {
        // 3 x 3 pixels in boxes of 2 x 2: the last column and row make boxes of their own.
        let mut pixels = [[0.0; 3]; 9];
        pixels[0] = [1.0, 0.5, 4.0];
        pixels[2] = [1.0; 3];
        pixels[8] = [f32::INFINITY, 0.0, 0.0];
        let shown = shown(&pixels, 3, 2, 2.0);
        assert_eq!(shown.width, 2);
        // 0.5, 0.25, 2; 1; 0.
        assert_eq!(shown.pixels, [[188, 137, 255], [255; 3], [0; 3], NOT_FINITE_COLOR]);
    }

    #[test]
    fn reduced_differences_keep_the_worst() {
        let mut differences = [0.0; 15];
        differences[0] = 0.5;
        differences[6] = -1.0;
        differences[2] = f32::NAN;
        differences[3] = 7.0;
        differences[7] = 1.0;
        differences[9] = 0.25;
        differences[14] = 1.0;
        let reduced = |scale| false_color(&differences, 5, 2, scale).pixels;
        let colors = [-1.0, f64::NAN, 0.25, 0.0, 0.0, 1.0].map(difference_color);
        assert_eq!(reduced(Some(ColorScale { limit: 1.0, beyond: [false; 2] })), colors);
    }
}
