//! False colors of differences, and what they stand for.

use rayon::prelude::*;

use super::canvas::{Canvas, mix};
use crate::compare::display::is_finite;
use crate::compare::metrics::{nearest_rank, ranked};

/// Colors of signed differences, from the most negative (dark blue) over zero (nearly white) to the most
/// positive (dark red), at equal distances; between them, sRGB values are interpolated. Lightness falls
/// evenly with the magnitude on both sides, and people with color vision deficiencies can tell the sides
/// apart.
///
/// This is `vik` of the Scientific color maps 8.0 of Fabio Crameri, 33 points of the middle 80 %: the rest
/// is so dark that the sides look alike in single pixels. Copyright (c) 2023 Fabio Crameri, MIT License,
/// <https://doi.org/10.5281/zenodo.1243862>.
pub const DIFFERENCE_COLORS: [[u8; 3]; 33] = bytes([
    0x023a7a, 0x034481, 0x044e87, 0x08588e, 0x116496, 0x1f709e, 0x2f7ca6, 0x428aaf, 0x5697b8, 0x6aa4c1,
    0x7eb0c9, 0x92bdd2, 0xa7c9da, 0xbbd5e2, 0xcfe0e8, 0xe0e6e9, 0xece5e1, 0xeeddd3, 0xebd1c2, 0xe6c4b1,
    0xe1b8a0, 0xdcab8f, 0xd79f7f, 0xd2936f, 0xcd8860, 0xc87d51, 0xc37243, 0xbe6634, 0xb75a26, 0xae4b18,
    0xa13c0c, 0x932e06, 0x862306,
]);

/// The red, green and blue of colors.
const fn bytes<const N: usize>(colors: [u32; N]) -> [[u8; 3]; N] {
    let mut all = [[0; 3]; N];
    let mut i = 0;
    while i < N {
        let [_, r, g, b] = colors[i].to_be_bytes();
        all[i] = [r, g, b];
        i += 1;
    }
    all
}

/// The color of a pixel that is not finite. It is far from all of [`DIFFERENCE_COLORS`].
pub const NOT_FINITE_COLOR: [u8; 3] = [255, 0, 255];

/// The color, in 8-bit sRGB, of a difference as a share of the largest one, -1..1. What is beyond gets the
/// color of the end; NaN gets [`NOT_FINITE_COLOR`].
pub fn difference_color(share: f64) -> [u8; 3] {
    if share.is_nan() {
        return NOT_FINITE_COLOR;
    }
    let last = DIFFERENCE_COLORS.len() - 1;
    let position = (share.clamp(-1.0, 1.0) + 1.0) / 2.0 * last as f64;
    let before = (position as usize).min(last - 1);
    let (a, b) = (DIFFERENCE_COLORS[before], DIFFERENCE_COLORS[before + 1]);
    std::array::from_fn(|i| mix(a[i], b[i], position - before as f64))
}

/// The share of the differences other than 0 that the scale covers.
const HELD: f64 = 0.995;
/// A difference in 32-bit floats that should be 0.002 may be a little more.
const SLACK: f64 = 1.0 + 1e-6;

/// The range of differences that has colors of its own: -limit..limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ColorScale {
    /// 1, 2 or 5 times a power of ten.
    pub limit: f64,
    /// True if some difference is below the range; true if some difference is above it.
    pub beyond: [bool; 2],
}

impl ColorScale {
    /// The scale for these differences. NaN does not count. `None` if all are 0.
    pub fn of(differences: &[f32]) -> Option<ColorScale> {
        let limit = difference_limit(differences)?;
        let beyond = |sign: f64| differences.par_iter().any(|&x| sign * f64::from(x) > limit * SLACK);
        Some(ColorScale { limit, beyond: [beyond(-1.0), beyond(1.0)] })
    }

    /// The given number of ticks, odd and at least 3, from end to end.
    pub fn ticks(&self, count: usize) -> Vec<Tick> {
        let half = (count / 2) as f64;
        let tick = |i: usize| {
            let share = i as f64 / half - 1.0;
            let relation = match share {
                -1.0 if self.beyond[0] => "<= ",
                1.0 if self.beyond[1] => ">= ",
                _ => "",
            };
            let text = format!("{relation}{}", short(share * self.limit));
            Tick { position: (share + 1.0) / 2.0, text }
        };
        (0..count).map(tick).collect()
    }
}

/// A tick of the scale.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    /// 0 at the negative end, 1 at the positive one.
    pub position: f64,
    pub text: String,
}

/// The difference that has the last color, 1, 2 or 5 times a power of ten: no less than 99.5 % of the differences
/// that are neither 0 nor NaN. `None` if all are.
pub fn difference_limit(differences: &[f32]) -> Option<f64> {
    let count = |test: fn(&f32) -> bool| differences.par_iter().filter(|x| test(x)).count();
    let (zero, other) = (count(|x| *x == 0.0), count(|x| *x != 0.0 && !x.is_nan()));
    let rank = zero + nearest_rank(HELD, other);
    (other > 0).then(|| round_up(ranked(differences.par_iter().copied(), rank).into()))
}

/// The least of 1, 2 and 5 times a power of ten that is not smaller than a positive number.
fn round_up(value: f64) -> f64 {
    let power = value.log10().floor() as i32;
    let steps = (power - 1..=power + 1).flat_map(|power| [1, 2, 5].map(|digit| (digit, power)));
    // From text, because no other way gives the float that is nearest to the decimal number.
    let mut limits = steps.filter_map(|(digit, power)| format!("{digit}e{power}").parse::<f64>().ok());
    limits.find(|limit| value <= limit * SLACK).unwrap_or(f64::MAX)
}

/// A number in the shorter of the usual notations.
fn short(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 {
        "0".into()
    } else if (0.001..10_000.0).contains(&magnitude) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// A smaller picture: the means of boxes of `side` x `side` pixels, or fewer at the right and at the bottom. A pixel that is not finite makes its mean so.
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
    fn colors_are_interpolated_and_clamped() {
        assert_eq!(difference_color(0.0), [236, 229, 225]);
        assert_eq!(difference_color(1.0), [134, 35, 6]);
        assert_eq!(difference_color(f64::INFINITY), [134, 35, 6]);
        assert_eq!(difference_color(-7.0), [2, 58, 122]);
        assert_eq!(difference_color(1.0 / 16.0), DIFFERENCE_COLORS[17]);
        assert_eq!(difference_color(-1.0 / 32.0), [230, 230, 229]);
        assert_eq!(difference_color(f64::NAN), NOT_FINITE_COLOR);
    }

    #[test]
    fn a_larger_difference_is_darker() {
        let luma = |share: f64| {
            let [r, g, b] = difference_color(share).map(f64::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for i in 1..32 {
            let (less, more) = (f64::from(i) / 32.0, f64::from(i + 1) / 32.0);
            assert!(luma(less) > luma(more) && luma(-less) > luma(-more), "{i}");
        }
    }

    #[test]
    fn limits_are_rounded_up() {
        let check = |value: f64, expected: f64| assert_eq!(round_up(value), expected, "{value}");
        check(0.9, 1.0);
        check(1.0, 1.0);
        check(1.001, 2.0);
        check(2.1, 5.0);
        check(5.1, 10.0);
        check(999.0, 1000.0);
        check(0.002_f32.into(), 0.002);
        check(0.1_f32.into(), 0.1);
        check(4e-7, 5e-7);
        check(1e-45, 1e-45);
        check(f32::MAX.into(), 5e38);
    }

    #[test]
    fn the_scale_holds_all_but_the_largest_differences() {
        let differences = |few: f32| {
            let many = (1..=995).map(|i| i as f32 / 1000.0);
            many.chain([few; 5]).chain([0.0; 9000]).chain([f32::NAN; 10]).collect::<Vec<_>>()
        };
        let scale = |few| ColorScale::of(&differences(few)).unwrap();
        assert_eq!(scale(3.0), ColorScale { limit: 1.0, beyond: [false, true] });
        assert_eq!(scale(-3.0), ColorScale { limit: 1.0, beyond: [true, false] });
        assert_eq!(scale(1.0), ColorScale { limit: 1.0, beyond: [false, false] });
        // Of few, it holds all.
        assert_eq!(
            ColorScale::of(&[0.0, 0.001, -70.0]).unwrap(),
            ColorScale { limit: 100.0, beyond: [false; 2] }
        );
        assert_eq!(ColorScale::of(&[0.0, -0.0, f32::NAN]), None);
    }

    #[test]
    fn ticks_are_short() {
        let texts = |limit, beyond, count| {
            let ticks = ColorScale { limit, beyond }.ticks(count);
            ticks.into_iter().map(|tick| tick.text).collect::<Vec<_>>()
        };
        assert_eq!(texts(0.005, [false; 2], 5), ["-0.005", "-0.0025", "0", "0.0025", "0.005"]);
        assert_eq!(texts(1e-5, [true, false], 3), ["<= -1e-5", "0", "1e-5"]);
        assert_eq!(texts(20_000.0, [false, true], 3), ["-2e4", "0", ">= 2e4"]);
        let places: Vec<_> =
            ColorScale { limit: 1.0, beyond: [false; 2] }.ticks(5).iter().map(|t| t.position).collect();
        assert_eq!(places, [0.0, 0.25, 0.5, 0.75, 1.0]);
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
