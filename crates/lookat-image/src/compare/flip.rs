//! FLIP: how much two pictures seem to differ when they are flipped on one display.

use std::f32::consts::FRAC_1_SQRT_2;
use std::f64::consts::PI;
use std::ops::Range;

use rayon::prelude::*;

use super::display::{clip, cube_root};
use super::metrics::ranked;
use super::ssim::{along_rows, down_columns};

/// The default viewing distance: 0.7 m from a display that is 0.7 m wide and has 3840 columns.
pub const PIXELS_PER_DEGREE: f32 = 67.020_64;

/// The columns and rows that are worked on at a time, so that all planes stay in the cache.
const TILE: usize = 128;
const BAND: usize = 64;

/// The mean LDR-FLIP: 0 for equal pictures, at most 1.
///
/// The pictures are linear and are shown clipped to 0..1. (The paper starts from sRGB values and first makes
/// them linear.) Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A Difference
/// Evaluator for Alternating Images" (HPG 2020), with separable filters as in version 1.7 of the authors'
/// program.
///
/// # Panics
///
/// If the pictures differ in size or are no whole rows of `width` pixels, or `pixels_per_degree` is not positive and
/// finite.
pub fn ldr_flip(actual: &[[f32; 3]], expected: &[[f32; 3]], width: usize, pixels_per_degree: f32) -> f64 {
    mean_flip([actual, expected], width, pixels_per_degree, &[|rgb: [f32; 3]| rgb.map(clip)])
}

/// The mean HDR-FLIP: 0 for equal pictures, at most 1. For each pixel, it is the largest LDR-FLIP over all exposures, each shown
/// by the tone mapper ACES. Negative values count as 0.
///
/// Andersson, Nilsson, Shirley and Akenine-Möller, "Visualizing Errors in Rendered High Dynamic Range Images"
/// (Eurographics 2021).
///
/// # Panics
///
/// The conditions of [`ldr_flip`].
pub fn hdr_flip(actual: &[[f32; 3]], expected: &[[f32; 3]], width: usize, pixels_per_degree: f32) -> f64 {
    let display = |stops: f32| {
        let factor = stops.exp2();
        move |rgb: [f32; 3]| rgb.map(|value| aces(factor * value))
    };
    let displays: Vec<_> = exposures(expected).into_iter().map(display).collect();
    mean_flip([actual, expected], width, pixels_per_degree, &displays)
}

/// The exposures in stops at which HDR-FLIP shows the pictures, by the reference picture: at least two, evenly from where its largest
/// luminance is shown as 0.85 to where its median luminance (the upper one of two) is, in steps of about one stop. Below 2^-23 a
/// luminance counts as that.
fn exposures(expected: &[[f32; 3]]) -> Vec<f32> {
    // The weights of the authors' program.
    let luminance = |&[r, g, b]: &[f32; 3]| (0.2126 * r + 0.7152 * g + 0.0722 * b).max(0.0);
    let exposure = |rank: usize| {
        let luminance = ranked(expected.par_iter().map(luminance), rank).clamp(f32::EPSILON, f32::MAX);
        (aces_inverse(0.85) / luminance).log2()
    };
    let (start, stop) = (exposure(expected.len()), exposure(expected.len() / 2 + 1));
    let count = (stop - start).ceil().max(2.0) as usize;
    let step = (stop - start) / (count - 1) as f32;
    (0..count).map(|i| start + i as f32 * step).collect()
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

/// The mean over pixels of the largest FLIP of all ways of display.
fn mean_flip(
    pictures: [&[[f32; 3]]; 2],
    width: usize,
    pixels_per_degree: f32,
    displays: &[impl Fn([f32; 3]) -> [f32; 3] + Sync],
) -> f64 {
    assert!(pictures[0].len() == pictures[1].len() && pictures[0].len().is_multiple_of(width));
    assert!(pixels_per_degree > 0.0 && pixels_per_degree.is_finite());
    let filters = Filters::new(f64::from(pixels_per_degree));
    let scale = Scale::new();

    let mut map = vec![0.0_f32; pictures[0].len()];
    map.par_chunks_mut((BAND * width).max(1)).enumerate().for_each(|(band, map)| {
        let rows = band * BAND..band * BAND + map.len() / width;
        for left in (0..width).step_by(TILE) {
            let columns = left..width.min(left + TILE);
            for display in displays {
                let seen = pictures.map(|picture| {
                    let tile = [columns.clone(), rows.clone()];
                    filtered(
                        &surroundings(picture, width, tile, filters.margin, display),
                        columns.len(),
                        &filters,
                    )
                });
                let differences = compare(&seen, scale);
                for (row, differences) in
                    map.chunks_exact_mut(width).zip(differences.chunks_exact(columns.len()))
                {
                    for (largest, difference) in row[columns.clone()].iter_mut().zip(differences) {
                        *largest = largest.max(*difference);
                    }
                }
            }
        }
    });
    map.iter().map(|&value| f64::from(value)).sum::<f64>() / map.len() as f64
}

/// A tile of one picture as the eye sees it.
struct Filtered {
    /// Colors after the contrast sensitivity of the eye.
    lab: [Vec<f32>; 3],
    /// The strength of edges and points.
    features: [Vec<f32>; 2],
}

/// Filters the opponent colors of a tile.
fn filtered(planes: &[Vec<f32>; 3], width: usize, filters: &Filters) -> Filtered {
    let margin = filters.margin;
    let rows = |plane: &[f32], weights: &[f32]| along_rows(plane, width + 2 * margin, margin, weights);
    let columns = |plane: &[f32], weights: &[f32]| down_columns(plane, width, margin, weights);
    let both = |plane: &[f32], weights: &[f32]| columns(&rows(plane, weights), weights);

    let [luminance, red_green, blue_yellow] = planes;
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
    Filtered { lab, features }
}

/// The opponent colors of a tile, given by its columns and rows, and of a margin around it. Beyond its border the picture
/// goes on as at the border.
fn surroundings(
    picture: &[[f32; 3]],
    width: usize,
    [columns, rows]: [Range<usize>; 2],
    margin: usize,
    display: impl Fn([f32; 3]) -> [f32; 3],
) -> [Vec<f32>; 3] {
    let within = |i: usize, size: usize| i.saturating_sub(margin).min(size - 1);
    let [wide, high] = [&columns, &rows].map(|range| range.len() + 2 * margin);
    let mut planes = [(); 3].map(|()| Vec::with_capacity(wide * high));
    let mut colors = Vec::with_capacity(wide);
    for y in rows.start..rows.start + high {
        let row = &picture[within(y, picture.len() / width) * width..][..width];
        colors.clear();
        let x = columns.start..columns.start + wide;
        colors.extend(x.map(|x| opponent(display(row[within(x, width)]))));
        for (i, plane) in planes.iter_mut().enumerate() {
            plane.extend(colors.iter().map(|color| color[i]));
        }
    }
    planes
}

/// FLIP of each pixel of a tile.
fn compare([a, b]: &[Filtered; 2], scale: Scale) -> Vec<f32> {
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

/// Linear sRGB to CIE XYZ, each row divided by its sum, so that white is (1, 1, 1). Whatever FLIP does with XYZ
/// begins with a division by white.
const XYZ_FROM_RGB: [[f32; 3]; 3] = [
    [0.433_895_4, 0.376_242_37, 0.189_862_24],
    [0.212_636_82, 0.715_182_98, 0.072_180_2],
    [0.017_752_42, 0.109_465_63, 0.872_781_95],
];
const RGB_FROM_XYZ: [[f32; 3]; 3] = [
    [3.080_342, -1.537_399, -0.542_943],
    [-0.921_178_4, 1.875_93, 0.045_248_41],
    [0.052_881_29, -0.204_011_2, 1.151_129_9],
];

/// Exponent of the color difference (q_c), and the point (p_c of its maximum, p_t) at which its scale has a
/// knee.
const EXPONENT: f32 = 0.7;
const KNEE: f32 = 0.4;
const KNEE_VALUE: f32 = 0.95;

/// Luminance, red-green and blue-yellow: the space YCxCz less its factors 116, 500 and 200 and its offset
/// -16. They would cancel, since only weighted means are taken in that space.
fn opponent(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = transform(&XYZ_FROM_RGB, rgb);
    [y, x - y, y - z]
}

/// CIELAB of an opponent color, clipped to what a display can show, after the Hunt effect: a and b scaled by
/// L / 100. Inlined, so that the loop over pixels is vectorized.
#[inline(always)]
fn hunt_lab([y, red_green, blue_yellow]: [f32; 3]) -> [f32; 3] {
    let rgb = transform(&RGB_FROM_XYZ, [y + red_green, y, y - blue_yellow]).map(clip);
    let [x, y, z] = transform(&XYZ_FROM_RGB, rgb).map(|t| {
        let root = cube_root(t.max(0.008));
        if t > 216.0 / 24389.0 { root } else { t * (841.0 / 108.0) + 4.0 / 29.0 }
    });
    let l = 116.0 * y - 16.0;
    [l, 0.01 * l * 500.0 * (x - y), 0.01 * l * 200.0 * (y - z)]
}

/// The distance HyAB: city block between lightness and the rest, euclidean within the rest.
fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [l, red_green, blue_yellow] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    l.abs() + (red_green * red_green + blue_yellow * blue_yellow).sqrt()
}

/// Brings distances to 0..1.
#[derive(Clone, Copy)]
struct Scale {
    largest: f32,
}

impl Scale {
    /// The largest distance is that from green to blue.
    fn new() -> Self {
        let lab = |rgb| hunt_lab(opponent(rgb));
        Scale { largest: hyab(lab([0.0, 1.0, 0.0]), lab([0.0, 0.0, 1.0])).powf(EXPONENT) }
    }

    /// The color difference, 0..1, of a distance HyAB. Small differences get most of the range.
    fn difference(self, distance: f32) -> f32 {
        let power = distance.powf(EXPONENT);
        let knee = KNEE * self.largest;
        if power < knee {
            power * (KNEE_VALUE / knee)
        } else {
            KNEE_VALUE + (power - knee) / (self.largest - knee) * (1.0 - KNEE_VALUE)
        }
    }
}

fn transform(matrix: &[[f32; 3]; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    matrix.map(|[a, b, c]| a * x + b * y + c * z)
}

/// Spreads of the contrast sensitivity functions, in degrees^2: luminance, red-green, and the two of
/// blue-yellow with their weights.
const LUMINANCE: f64 = 0.0047;
const RED_GREEN: f64 = 0.0053;
const BLUE_YELLOW: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];
/// The width of the feature detectors in degrees.
const FEATURE_WIDTH: f64 = 0.082;
/// Weights below this share of the middle one are left out.
const NEGLIGIBLE: f64 = 1e-8;

/// The filters for the contrast sensitivity of the eye, and for edges and points. All weights are for a pixel and its
/// neighbors on one axis; their number is odd.
struct Filters {
    /// The pixels that the widest filter reaches beyond the middle.
    margin: usize,
    /// The contrast sensitivity of luminance, sum 1.
    luminance: Vec<f32>,
    /// The contrast sensitivity of red-green, sum 1.
    red_green: Vec<f32>,
    /// The contrast sensitivity of blue-yellow: the sum of the products of each with itself.
    blue_yellow: [Vec<f32>; 2],
    /// A gaussian, sum 1.
    smooth: Vec<f32>,
    /// The first derivative of the gaussian. Positive and negative weights sum to 1 and -1.
    edge: Vec<f32>,
    /// The second derivative of the gaussian. Positive and negative weights sum to 1 and -1.
    point: Vec<f32>,
}

impl Filters {
    fn new(pixels_per_degree: f64) -> Self {
        // Three standard deviations of the widest of the contrast sensitivities serve for all of them.
        let radius = (3.0 * (BLUE_YELLOW[0].1 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as usize;
        let spread = |b: f64| around(radius, |x| (-(PI * x / pixels_per_degree).powi(2) / b).exp());
        let parts =
            BLUE_YELLOW.map(|(a, b)| spread(b).iter().map(|g| (a * (PI / b).sqrt()).sqrt() * g).collect());
        let total = parts.iter().map(|part: &Vec<f64>| part.iter().sum::<f64>().powi(2)).sum::<f64>().sqrt();

        let sigma = 0.5 * FEATURE_WIDTH * pixels_per_degree;
        let feature_radius = (3.0 * sigma).ceil() as usize;
        let gaussian = |x: f64| (-0.5 * (x / sigma).powi(2)).exp();
        Filters {
            margin: radius.max(feature_radius),
            luminance: trimmed(normalized(spread(LUMINANCE))),
            red_green: trimmed(normalized(spread(RED_GREEN))),
            blue_yellow: parts.map(|part| trimmed(part.iter().map(|weight| weight / total).collect())),
            smooth: trimmed(normalized(around(feature_radius, gaussian))),
            edge: trimmed(normalized(around(feature_radius, |x| -x * gaussian(x)))),
            point: trimmed(normalized(around(feature_radius, |x| ((x / sigma).powi(2) - 1.0) * gaussian(x)))),
        }
    }
}

fn around(radius: usize, weight: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..=2 * radius).map(|i| weight(i as f64 - radius as f64)).collect()
}

/// Divides positive weights by their sum and negative ones by theirs.
fn normalized(weights: Vec<f64>) -> Vec<f64> {
    let positive: f64 = weights.iter().filter(|weight| **weight > 0.0).sum();
    let negative: f64 = weights.iter().filter(|weight| **weight < 0.0).sum();
    // Where there is no weight of a sign, none is divided.
    let sum = |weight: f64| if weight > 0.0 { positive } else { negative.abs().max(f64::MIN_POSITIVE) };
    weights.iter().map(|&weight| weight / sum(weight)).collect()
}

/// Leaves out what is negligible at both ends, which are alike but for their sign.
fn trimmed(weights: Vec<f64>) -> Vec<f32> {
    let largest = weights.iter().fold(0.0_f64, |largest, weight| largest.max(weight.abs()));
    let ends = weights.iter().take_while(|weight| weight.abs() <= NEGLIGIBLE * largest).count();
    let ends = ends.min(weights.len() / 2);
    weights[ends..weights.len() - ends].iter().map(|&weight| weight as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::tests::{Sample, radiance, shown};

    /// The expected numbers are from the authors' program: flip-evaluator 1.7 (PyPI), with default settings but
    /// for `ppd`; LDR on the clipped linear pictures with inputsRGB=False. Means are of its map, in double
    /// precision.
    fn check(sample: &Sample, pixels_per_degree: f32, ldr: f64, hdr: f64) {
        let Sample { actual, expected, width, height } = sample;
        for (name, flip, reference) in [
            ("LDR", ldr_flip(actual, expected, *width, pixels_per_degree), ldr),
            ("HDR", hdr_flip(actual, expected, *width, pixels_per_degree), hdr),
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
        let check = |sample: Sample, start: f32, stop: f32, count: usize| {
            let exposures = exposures(&sample.expected);
            assert!((exposures[0] - start).abs() < 1e-5, "{exposures:?}");
            assert!((exposures[count - 1] - stop).abs() < 1e-5, "{exposures:?}");
            assert_eq!(exposures.len(), count);
        };
        // The parameters that flip-evaluator 1.7 (PyPI) gives back.
        check(shown(200, 150), 0.994_477_15, 2.779_74, 2);
        check(radiance(190, 131), -5.253_451, 1.844_693_2, 8);
        check(radiance(9, 12), -4.195_838, 1.832_122_2, 7);
    }

    #[test]
    fn equal_pictures_have_no_difference() {
        let expected = radiance(40, 30).expected;
        assert_eq!(ldr_flip(&expected, &expected, 40, PIXELS_PER_DEGREE), 0.0);
        assert_eq!(hdr_flip(&expected, &expected, 40, PIXELS_PER_DEGREE), 0.0);
        let black = [[0.0; 3]; 6];
        assert_eq!(hdr_flip(&black, &black, 3, PIXELS_PER_DEGREE), 0.0);
    }

    #[test]
    fn odd_pixels_do_not_panic() {
        let odd =
            [[f32::NAN; 3], [f32::INFINITY; 3], [f32::NEG_INFINITY; 3], [-1.0; 3], [f32::MAX; 3], [0.0; 3]];
        let (odd, even) = (&odd, &[[0.5; 3]; 6]);
        for (actual, expected) in [(odd, even), (even, odd), (odd, odd)] {
            ldr_flip(actual, expected, 2, PIXELS_PER_DEGREE);
            hdr_flip(actual, expected, 3, 0.1);
        }
    }

    fn near(actual: [f32; 3], expected: [f32; 3], within: f32) {
        let is_near = actual.iter().zip(expected).all(|(a, b)| (a - b).abs() <= within);
        assert!(is_near, "{actual:?}, not {expected:?}");
    }

    #[test]
    fn the_matrices_are_inverse() {
        for rgb in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.3, 0.9, 0.1]] {
            near(transform(&RGB_FROM_XYZ, transform(&XYZ_FROM_RGB, rgb)), rgb, 1e-6);
        }
    }

    #[test]
    fn grays_have_no_color() {
        near(opponent([1.0; 3]), [1.0, 0.0, 0.0], 1e-6);
        near(hunt_lab([0.0; 3]), [0.0; 3], 1e-4);
        near(hunt_lab(opponent([0.001; 3])), [0.9033, 0.0, 0.0], 1e-4);
        near(hunt_lab(opponent([0.184_187; 3])), [50.0, 0.0, 0.0], 1e-3);
        near(hunt_lab(opponent([7.0; 3])), [100.0, 0.0, 0.0], 1e-3);
    }

    #[test]
    fn differences_are_from_0_to_1() {
        let scale = Scale::new();
        assert_eq!(scale.difference(0.0), 0.0);
        let largest = scale.largest.powf(1.0 / EXPONENT);
        assert!((scale.difference(largest) - 1.0).abs() < 1e-5);
        let knee = (KNEE * scale.largest).powf(1.0 / EXPONENT);
        assert!((scale.difference(knee * 0.999_99) - scale.difference(knee * 1.000_01)).abs() < 1e-4);
    }

    #[test]
    fn weights_have_the_right_sums() {
        for pixels_per_degree in [0.1, 1.0, 20.0, 67.0, 200.0] {
            let filters = Filters::new(pixels_per_degree);
            let sum = |weights: &[f32]| weights.iter().sum::<f32>();
            let check = |name: &str, sum: f32, expected: f32| {
                assert!((sum - expected).abs() < 1e-5, "{name} at {pixels_per_degree}: {sum}");
            };
            check("luminance", sum(&filters.luminance), 1.0);
            check("red-green", sum(&filters.red_green), 1.0);
            check("blue-yellow", filters.blue_yellow.iter().map(|part| sum(part).powi(2)).sum(), 1.0);
            check("smooth", sum(&filters.smooth), 1.0);
            check("edge", sum(&filters.edge), 0.0);
            // With less than a pixel to a feature there is only the middle weight left.
            let point = if pixels_per_degree < 1.0 { -1.0 } else { 0.0 };
            check("point", sum(&filters.point), point);
        }
    }

    #[test]
    fn reach_as_far_as_in_the_paper() {
        let filters = Filters::new(67.0);
        assert_eq!(filters.margin, 10);
        assert_eq!(filters.blue_yellow[0].len(), 21);
        assert_eq!(filters.smooth.len(), 19);
    }
}
