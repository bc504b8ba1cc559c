//! The filters of FLIP for one viewing distance, each as factors along one axis.

use std::f64::consts::PI;

/// Spreads of the contrast sensitivity functions, in degrees^2: luminance, red-green, and the two of
/// blue-yellow with their weights.
const LUMINANCE: f64 = 0.0047;
const RED_GREEN: f64 = 0.0053;
const BLUE_YELLOW: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];
/// The width of the feature detectors in degrees.
const FEATURE_WIDTH: f64 = 0.082;
/// Weights below this share of the middle one are left out.
const NEGLIGIBLE: f64 = 1e-8;

/// What the eye does to contrast, and how it finds edges and points. All weights are for a pixel and its
/// neighbors on one axis, their number is odd.
pub(super) struct Filters {
    /// The pixels that the widest filter reaches beyond the middle.
    pub(super) margin: usize,
    /// Sum 1.
    pub(super) luminance: Vec<f32>,
    /// Sum 1.
    pub(super) red_green: Vec<f32>,
    /// The filter is the sum of two products of these with themselves.
    pub(super) blue_yellow: [Vec<f32>; 2],
    /// A gaussian, sum 1.
    pub(super) smooth: Vec<f32>,
    /// Its first derivative; positive and negative weights sum to 1 and -1.
    pub(super) edge: Vec<f32>,
    /// Its second derivative; likewise.
    pub(super) point: Vec<f32>,
}

impl Filters {
    pub(super) fn new(pixels_per_degree: f64) -> Self {
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
    weights
        .iter()
        .map(
            |&weight| {
                if weight > 0.0 { weight / positive } else { weight / negative.abs().max(f64::MIN_POSITIVE) }
            },
        )
        .collect()
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
