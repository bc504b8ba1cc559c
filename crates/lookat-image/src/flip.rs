//! FLIP: how much two pictures seem to differ when they are flipped on one display.

mod color;
mod filter;

use std::f32::consts::FRAC_1_SQRT_2;

use rayon::prelude::*;

use self::color::{Scale, hunt_lab, hyab, opponent};
use self::filter::Filters;
use crate::convolution::{along_rows, down_columns};
use crate::display::clip;
use crate::rank::ranked;

/// The default viewing distance: 0.7 m from a display that is 0.7 m wide and has 3840 columns.
pub const PIXELS_PER_DEGREE: f32 = 67.020_64;

/// The columns and rows that are worked on at a time, so that all planes stay in the cache.
const TILE: usize = 128;
const BAND: usize = 64;

/// The mean of [`ldr_flip_map`]: 0 for equal pictures, at most 1.
///
/// # Panics
///
/// As [`ldr_flip_map`].
pub fn ldr_flip(
    actual: &[[f32; 3]],
    expected: &[[f32; 3]],
    width: usize,
    height: usize,
    pixels_per_degree: f32,
) -> f64 {
    mean(&ldr_flip_map(actual, expected, width, height, pixels_per_degree))
}

/// The mean of [`hdr_flip_map`]: 0 for equal pictures, at most 1.
///
/// # Panics
///
/// As [`ldr_flip_map`].
pub fn hdr_flip(
    actual: &[[f32; 3]],
    expected: &[[f32; 3]],
    width: usize,
    height: usize,
    pixels_per_degree: f32,
) -> f64 {
    let exposures = Exposures::of(expected);
    mean(&hdr_flip_map(actual, expected, width, height, pixels_per_degree, exposures))
}

/// LDR-FLIP for each pixel, row by row: 0 where no difference is seen, 1 for the largest one.
///
/// The pictures are linear and are shown clipped to 0..1. (The paper starts from sRGB values and first makes
/// them linear.) Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A Difference
/// Evaluator for Alternating Images" (HPG 2020), with separable filters as in version 1.7 of the authors'
/// program.
///
/// # Panics
///
/// If a picture does not have `width` times `height` pixels, or `pixels_per_degree` is not positive and
/// finite.
pub fn ldr_flip_map(
    actual: &[[f32; 3]],
    expected: &[[f32; 3]],
    width: usize,
    height: usize,
    pixels_per_degree: f32,
) -> Vec<f32> {
    largest_map([actual, expected], width, height, pixels_per_degree, &[|rgb: [f32; 3]| rgb.map(clip)])
}

/// HDR-FLIP for each pixel, row by row: the largest LDR-FLIP over all exposures, each shown by the tone
/// mapper ACES. Negative values count as 0.
///
/// Andersson, Nilsson, Shirley and Akenine-Möller, "Visualizing Errors in Rendered High Dynamic Range Images"
/// (Eurographics 2021).
///
/// # Panics
///
/// As [`ldr_flip_map`].
pub fn hdr_flip_map(
    actual: &[[f32; 3]],
    expected: &[[f32; 3]],
    width: usize,
    height: usize,
    pixels_per_degree: f32,
    exposures: Exposures,
) -> Vec<f32> {
    let display = |factor: f32| move |rgb: [f32; 3]| rgb.map(|value| aces(factor * value));
    let displays: Vec<_> = exposures.factors().map(display).collect();
    largest_map([actual, expected], width, height, pixels_per_degree, &displays)
}

/// The exposures at which HDR-FLIP shows the pictures, evenly from `start` to `stop`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposures {
    /// The first one, in stops: pictures are multiplied by 2^`start`.
    pub start: f32,
    /// The last one, in stops.
    pub stop: f32,
    /// How many, at least 2.
    pub count: usize,
}

impl Exposures {
    /// The choice of the paper for a reference picture: from where its largest luminance is shown as 0.85 to
    /// where its median luminance (the upper one of two) is, in steps of about one stop. Below 2^-23 a
    /// luminance counts as that.
    pub fn of(expected: &[[f32; 3]]) -> Self {
        let luminance = |i: usize| {
            let [r, g, b] = expected[i];
            [(0.2126 * r + 0.7152 * g + 0.0722 * b).max(0.0)]
        };
        let exposure = |rank: usize| {
            let luminance = ranked(expected.len(), luminance, rank).clamp(f32::EPSILON, f32::MAX);
            (aces_inverse(0.85) / luminance).log2()
        };
        let (start, stop) = (exposure(expected.len()), exposure(expected.len() / 2 + 1));
        Exposures { start, stop, count: (stop - start).ceil().max(2.0) as usize }
    }

    fn factors(self) -> impl Iterator<Item = f32> {
        let step = (self.stop - self.start) / (self.count.max(2) - 1) as f32;
        (0..self.count).map(move |i| (self.start + i as f32 * step).exp2())
    }
}

/// Narkowicz's fit of the ACES filmic curve, with its built-in exposure of 0.6 taken out, as coefficients of
/// value^2, value and 1: above and below the line.
const ACES: [[f32; 3]; 2] = [[0.36 * 2.51, 0.6 * 0.03, 0.0], [0.36 * 2.43, 0.6 * 0.59, 0.14]];

/// A tone-mapped value, 0..1.
fn aces(value: f32) -> f32 {
    // From 8 on it is 1; squares beyond are not to become infinite.
    let value = value.max(0.0);
    let value = if value < 1e6 { value } else { 1e6 };
    let [above, below] = ACES.map(|[a, b, c]| (a * value + b) * value + c);
    (above / below).min(1.0)
}

/// The positive value that the tone mapper takes to `shown`.
fn aces_inverse(shown: f32) -> f32 {
    let [a, b, c]: [f32; 3] = std::array::from_fn(|i| ACES[0][i] - shown * ACES[1][i]);
    let middle = -0.5 * b / a;
    middle + (middle * middle - c / a).sqrt()
}

/// Maps all ways of display, and keeps the largest difference of each pixel.
fn largest_map(
    pictures: [&[[f32; 3]]; 2],
    width: usize,
    height: usize,
    pixels_per_degree: f32,
    displays: &[impl Fn([f32; 3]) -> [f32; 3] + Sync],
) -> Vec<f32> {
    assert!(pictures.iter().all(|picture| picture.len() == width * height));
    assert!(pixels_per_degree > 0.0 && pixels_per_degree.is_finite());
    let filters = Filters::new(f64::from(pixels_per_degree));
    let scale = Scale::new();

    let mut map = vec![0.0_f32; width * height];
    let bands = map.par_chunks_mut((BAND * width).max(1)).enumerate();
    bands.for_each(|(band, map)| {
        for left in (0..width).step_by(TILE) {
            let tile =
                Tile { left, top: band * BAND, width: TILE.min(width - left), height: map.len() / width };
            for display in displays {
                let seen = pictures.map(|picture| see(picture, width, height, tile, &filters, display));
                let differences = compare(&seen, scale);
                for (row, differences) in
                    map.chunks_exact_mut(width).zip(differences.chunks_exact(tile.width))
                {
                    for (largest, difference) in row[left..].iter_mut().zip(differences) {
                        *largest = largest.max(*difference);
                    }
                }
            }
        }
    });
    map
}

/// A part of the picture, in pixels.
#[derive(Clone, Copy)]
struct Tile {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

/// What is seen of one picture in a tile.
struct Seen {
    /// Colors after the contrast sensitivity of the eye.
    lab: [Vec<f32>; 3],
    /// How strong edges and points are.
    features: [Vec<f32>; 2],
}

fn see(
    picture: &[[f32; 3]],
    width: usize,
    height: usize,
    tile: Tile,
    filters: &Filters,
    display: impl Fn([f32; 3]) -> [f32; 3],
) -> Seen {
    let margin = filters.margin;
    let planes = surroundings(picture, width, height, tile, margin, display);
    let rows = |plane: &[f32], weights: &[f32]| along_rows(plane, tile.width + 2 * margin, margin, weights);
    let columns = |plane: &[f32], weights: &[f32]| down_columns(plane, tile.width, margin, weights);
    let both = |plane: &[f32], weights: &[f32]| columns(&rows(plane, weights), weights);

    let [luminance, red_green, blue_yellow] = &planes;
    let [wide, narrow] = filters.blue_yellow.each_ref().map(|weights| both(blue_yellow, weights));
    let mut lab = [both(luminance, &filters.luminance), both(red_green, &filters.red_green), wide];
    let [l, a, b] = &mut lab;
    for (((l, a), b), narrow) in l.iter_mut().zip(a).zip(b).zip(narrow) {
        [*l, *a, *b] = hunt_lab([*l, *a, *b + narrow]);
    }

    let smooth = rows(luminance, &filters.smooth);
    let features = [&filters.edge, &filters.point].map(|weights| {
        let (x, y) = (columns(&rows(luminance, weights), &filters.smooth), columns(&smooth, weights));
        x.iter().zip(y).map(|(x, y)| (x * x + y * y).sqrt()).collect()
    });
    Seen { lab, features }
}

/// The opponent colors of a tile and of a margin around it. Beyond its border the picture goes on as at the
/// border.
fn surroundings(
    picture: &[[f32; 3]],
    width: usize,
    height: usize,
    tile: Tile,
    margin: usize,
    display: impl Fn([f32; 3]) -> [f32; 3],
) -> [Vec<f32>; 3] {
    let place = |start: usize, i: usize, size: usize| (start + i).saturating_sub(margin).min(size - 1);
    let size = (tile.width + 2 * margin) * (tile.height + 2 * margin);
    let mut planes = [(); 3].map(|()| Vec::with_capacity(size));
    let mut colors = Vec::with_capacity(tile.width + 2 * margin);
    for y in 0..tile.height + 2 * margin {
        let row = &picture[place(tile.top, y, height) * width..][..width];
        colors.clear();
        colors
            .extend((0..tile.width + 2 * margin).map(|x| opponent(display(row[place(tile.left, x, width)]))));
        for (i, plane) in planes.iter_mut().enumerate() {
            plane.extend(colors.iter().map(|color| color[i]));
        }
    }
    planes
}

/// FLIP of each pixel of a tile.
fn compare([a, b]: &[Seen; 2], scale: Scale) -> Vec<f32> {
    // This loop is vectorized, and the other one, with its powers, is not.
    let mut map = vec![0.0; a.lab[0].len()];
    let [planes_a, planes_b] = [a, b].map(|seen| seen.lab.each_ref().map(|plane| &plane[..map.len()]));
    for (i, distance) in map.iter_mut().enumerate() {
        *distance = hyab(planes_a.map(|plane| plane[i]), planes_b.map(|plane| plane[i]));
    }
    for (i, value) in map.iter_mut().enumerate() {
        let [edge, point] = [0, 1].map(|kind: usize| (a.features[kind][i] - b.features[kind][i]).abs());
        let feature = (edge.max(point) * FRAC_1_SQRT_2).sqrt();
        *value = scale.difference(*value).powf(1.0 - feature);
    }
    map
}

fn mean(map: &[f32]) -> f64 {
    map.iter().map(|&value| f64::from(value)).sum::<f64>() / map.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Sample, radiance, shown};

    /// The expected numbers are from the authors' program: flip-evaluator 1.7 (PyPI), with default settings but
    /// for `ppd`; LDR on the clipped linear pictures with inputsRGB=False. Means are of its map, in double
    /// precision.
    fn check(sample: &Sample, pixels_per_degree: f32, ldr: f64, hdr: f64) {
        let Sample { actual, expected, width, height } = sample;
        for (name, flip, reference) in [
            ("LDR", ldr_flip(actual, expected, *width, *height, pixels_per_degree), ldr),
            ("HDR", hdr_flip(actual, expected, *width, *height, pixels_per_degree), hdr),
        ] {
            println!("{name} {width} x {height} {pixels_per_degree}: {:.2e}", flip - reference);
            assert!((flip - reference).abs() < 1e-5, "{name} {width} x {height}: {flip}, not {reference}");
        }
    }

    #[test]
    fn agrees_with_the_authors_program() {
        let sample = shown(200, 150);
        check(&sample, PIXELS_PER_DEGREE, 0.104560523, 0.194657711);
        check(&sample, 30.0, 0.201051687, 0.306575433);
        check(&sample, 110.0, 0.079041505, 0.169245853);
        let sample = radiance(190, 131);
        check(&sample, PIXELS_PER_DEGREE, 0.197416186, 0.192385216);
        check(&sample, 30.0, 0.349268951, 0.339736552);
    }

    #[test]
    fn agrees_where_filters_are_wider_than_the_picture() {
        let sample = shown(31, 17);
        check(&sample, PIXELS_PER_DEGREE, 0.142247183, 0.224643900);
        check(&sample, 110.0, 0.108825211, 0.192874304);
        let sample = radiance(9, 12);
        check(&sample, PIXELS_PER_DEGREE, 0.218365850, 0.211844938);
        check(&sample, 30.0, 0.378889133, 0.356113445);
    }

    #[test]
    fn exposures_are_those_of_the_authors_program() {
        let check = |sample: Sample, start: f32, stop: f32, count| {
            let exposures = Exposures::of(&sample.expected);
            assert!((exposures.start - start).abs() < 1e-5, "{exposures:?}");
            assert!((exposures.stop - stop).abs() < 1e-5, "{exposures:?}");
            assert_eq!(exposures.count, count);
        };
        // The parameters that flip-evaluator 1.7 (PyPI) gives back.
        check(shown(200, 150), 0.994_477_15, 2.779_74, 2);
        check(radiance(190, 131), -5.253_451, 1.844_693_2, 8);
        check(radiance(9, 12), -4.195_838, 1.832_122_2, 7);
    }

    #[test]
    fn equal_pictures_have_no_difference() {
        let expected = radiance(40, 30).expected;
        assert_eq!(ldr_flip(&expected, &expected, 40, 30, PIXELS_PER_DEGREE), 0.0);
        assert_eq!(hdr_flip(&expected, &expected, 40, 30, PIXELS_PER_DEGREE), 0.0);
        let black = [[0.0; 3]; 6];
        assert_eq!(hdr_flip(&black, &black, 3, 2, PIXELS_PER_DEGREE), 0.0);
    }

    #[test]
    fn odd_pixels_do_not_panic() {
        let odd =
            [[f32::NAN; 3], [f32::INFINITY; 3], [f32::NEG_INFINITY; 3], [-1.0; 3], [f32::MAX; 3], [0.0; 3]];
        let (odd, even) = (&odd, &[[0.5; 3]; 6]);
        for (actual, expected) in [(odd, even), (even, odd), (odd, odd)] {
            ldr_flip(actual, expected, 2, 3, PIXELS_PER_DEGREE);
            hdr_flip(actual, expected, 3, 2, 0.1);
        }
    }
}
