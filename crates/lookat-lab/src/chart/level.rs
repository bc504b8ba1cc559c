//! What is left of an error however many samples are taken.

use super::estimate::moments;

/// The picture that a method has on average, as far as it differs from the reference: its bias, and the noise of the
/// reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// An estimate of its mean squared error; as an unbiased estimate of what may be 0 it may be negative.
    pub square: f64,
    /// The standard error of that, from how it scatters over pixels.
    pub standard_error: f64,
    /// The mean signed error.
    pub mean: f64,
    /// The standard error of that, from how it scatters over pixels: with the noise of the reference.
    pub mean_standard_error: f64,
}

/// Standard errors that a bias has at least.
const SIGNIFICANT: f64 = 4.0;

impl Level {
    /// The mean square of the bias; `None` if what there is may be chance, or be the noise of a reference of this mean
    /// square. The whole must exceed that twice, or the mean differ from 0.
    pub(super) fn bias_square(&self, noise_square: f64) -> Option<f64> {
        let rest = self.square - noise_square;
        let is_shifted = self.mean.abs() > SIGNIFICANT * self.mean_standard_error;
        let is_bias = is_shifted || rest > noise_square && rest > SIGNIFICANT * self.standard_error;
        is_bias.then(|| rest.max(self.mean * self.mean))
    }
}

/// Sums over the pictures of several seeds.
#[derive(Debug, Default)]
pub(super) struct Differences {
    seeds: u32,
    /// For each pixel and channel, the sum of its errors, and that of their squares.
    sums: Vec<[f64; 2]>,
}

impl Differences {
    /// Adds the picture of one seed.
    pub fn add(&mut self, actual: &[[f32; 3]], expected: &[[f32; 3]]) {
        let (actual, expected) = (actual.as_flattened(), expected.as_flattened());
        self.sums.resize(actual.len(), [0.0; 2]);
        self.seeds += 1;
        for (sum, (actual, expected)) in self.sums.iter_mut().zip(actual.iter().zip(expected)) {
            let error = f64::from(*actual) - f64::from(*expected);
            *sum = [sum[0] + error, sum[1] + error * error];
        }
    }

    /// From the mean product of the errors of different seeds, which is what they have in common. At least two seeds.
    pub fn level(&self) -> Level {
        let seeds = f64::from(self.seeds);
        let product = |[sum, squares]: &[f64; 2]| (sum * sum - squares) / (seeds * (seeds - 1.0));
        let of_pixels = |value: &dyn Fn(&[f64; 2]) -> f64| {
            let of_pixel =
                |channels: &[[f64; 2]]| channels.iter().map(value).sum::<f64>() / channels.len() as f64;
            moments(&self.sums.chunks(3).map(of_pixel).collect::<Vec<_>>())
        };
        let (squares, means) = (of_pixels(&product), of_pixels(&|[sum, _]| sum / seeds));
        Level {
            square: squares.mean,
            standard_error: squares.standard_error,
            mean: means.mean,
            mean_standard_error: means.standard_error,
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    /// Eight pictures of uniform noise about a bias of changing sign and a shift, against a reference of 0.
    fn level(bias: f32, shift: f32) -> Level {
        let mut random = Pcg64Mcg::seed_from_u64(3);
        let mut differences = Differences::default();
        let expected = vec![[0.0; 3]; 10_000];
        for _ in 0..8 {
            let mut noise = || random.random::<f32>() - 0.5;
            let mut pixel =
                |i: usize| [0; 3].map(|_| shift + if i.is_multiple_of(2) { bias } else { -bias } + noise());
            let actual: Vec<[f32; 3]> = (0..expected.len()).map(&mut pixel).collect();
            differences.add(&actual, &expected);
        }
        differences.level()
    }

    #[test]
    fn bias_is_told_from_noise() {
        // Noise of a mean square of 1/12; by closed form the level scatters by 1/12 sqrt(2 / (8 * 7 * 30000)), the mean by
        // sqrt(1/12 / 240000).
        let expected_error = (2.0_f64 / (56.0 * 30_000.0)).sqrt() / 12.0;
        let none = level(0.0, 0.0);
        assert!((none.standard_error / expected_error - 1.0).abs() < 0.05, "{none:?}");
        assert!((none.mean_standard_error * (12.0_f64 * 240_000.0).sqrt() - 1.0).abs() < 0.05, "{none:?}");
        assert_eq!(none.bias_square(0.0), None);
        // A bias without a mean shows in the square, unless the noise of the reference may be that.
        let some = level(0.05, 0.0);
        assert!((some.square - 0.0025).abs() < 4.0 * some.standard_error, "{some:?}");
        assert_eq!(
            [some.bias_square(0.0), some.bias_square(0.001)],
            [0.0, 0.001].map(|n| Some(some.square - n))
        );
        assert_eq!(some.bias_square(0.002), None);
        // A shift that the square does not show.
        let shifted = level(0.0, 0.004);
        assert!(shifted.square < 4.0 * shifted.standard_error, "{shifted:?}");
        assert_eq!(shifted.bias_square(1.0), Some(shifted.mean * shifted.mean));
    }
}
