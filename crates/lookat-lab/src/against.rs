//! Another renderer of the same scene files: error at equal samples, and time to equal error.

mod command;
mod scenes;
mod worlds;

use lookat_image::{means, relative_mse_trimmed};

use crate::estimate::{Estimate, mean, mean_and_error};
pub use command::Against;
use scenes::{Row, SIDE, pictures, rows};

/// How far apart the trimmed and the plain ratio of errors are if single pixels rule the plain one.
const FIREFLIES: f64 = 1.5;
/// The side of the blocks of [`disagreement`] in pixels: wider than the radius of a filter, so that blocks are independent.
const BLOCK: usize = 8;
/// The standard errors by which the means of two pictures of one scene differ at most.
const AGREE: f64 = 5.0;

/// One run of a program.
struct Run {
    /// Wall time of the whole process in seconds.
    seconds: f64,
    pixels: Vec<[f32; 3]>,
}

/// What a program took for a picture, and how far it is from the reference.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Outcome {
    /// Wall time of the whole process in seconds.
    pub seconds: f64,
    /// Squared relative error.
    pub error: f64,
    /// The same without the worst thousandth of the pixels.
    pub trimmed: f64,
}

/// A ratio of two errors or times.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Ratio {
    /// The ratio. If `fireflies`, without the worst thousandth of the pixels.
    pub value: f64,
    /// Whether single pixels rule the errors.
    pub fireflies: bool,
}

impl Outcome {
    /// The median time of some runs, and the mean of their errors.
    ///
    /// # Panics
    ///
    /// If a picture does not have the size of the reference.
    fn of(runs: &[Run], reference: &[[f32; 3]]) -> Outcome {
        let all = |value: &dyn Fn(&Run) -> f64| runs.iter().map(value).collect::<Vec<f64>>();
        Outcome {
            seconds: Estimate::median(&all(&|run| run.seconds)).value,
            error: mean(&all(&|run| means(&run.pixels, reference).relative_mse)),
            trimmed: mean(&all(&|run| relative_mse_trimmed(&run.pixels, reference))),
        }
    }

    /// This error over another one at the same samples.
    fn error_over(self, other: Outcome) -> Ratio {
        let [plain, trimmed] = [self.error / other.error, self.trimmed / other.trimmed];
        let fireflies = (plain / trimmed).ln().abs() > FIREFLIES.ln();
        Ratio { value: if fireflies { trimmed } else { plain }, fireflies }
    }

    /// How many times as fast as the other program this one reaches the same error, if squared error times time is constant.
    fn time_to_equal_error(self, other: Outcome) -> Ratio {
        let errors = self.error_over(other);
        Ratio { value: other.seconds / self.seconds / errors.value, ..errors }
    }
}

/// The relative difference of the means of two pictures, (actual - expected) / expected, if noise does not explain it. The scatter of
/// the means of blocks tells the noise, so it is too large if the pictures differ more in some places than in others.
fn disagreement(actual: &[[f32; 3]], expected: &[[f32; 3]]) -> Option<f64> {
    let side = SIDE as usize;
    let sum = |pixel: &[f32; 3]| pixel.iter().map(|value| f64::from(*value)).sum::<f64>();
    let blocks = side / BLOCK;
    let difference = |block: usize| {
        let [x, y] = [block % blocks, block / blocks].map(|i| i * BLOCK);
        let pixels = (0..BLOCK * BLOCK).map(|i| (y + i / BLOCK) * side + x + i % BLOCK);
        pixels.map(|i| sum(&actual[i]) - sum(&expected[i])).sum::<f64>()
    };
    let differences: Vec<f64> = (0..blocks * blocks).map(difference).collect();
    let (mean, standard_error) = mean_and_error(&differences);
    let whole = expected.iter().map(sum).sum::<f64>() / expected.len() as f64 * (BLOCK * BLOCK) as f64;
    (mean.abs() > AGREE * standard_error).then_some(mean / whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_of_known_numbers() {
        let own = Outcome { seconds: 0.5, error: 0.02, trimmed: 0.02 };
        let other = Outcome { seconds: 2.0, error: 0.04, trimmed: 0.04 };
        assert_eq!(own.error_over(other), Ratio { value: 0.5, fireflies: false });
        assert_eq!(own.time_to_equal_error(other).value, 8.0);
        let other = Outcome { trimmed: 0.02, ..other };
        assert_eq!(own.error_over(other), Ratio { value: 1.0, fireflies: true });
        assert_eq!(own.time_to_equal_error(other).value, 4.0);
    }

    #[test]
    fn an_offset_beyond_noise_is_a_disagreement() {
        let noisy = |offset: f32| -> Vec<[f32; 3]> {
            (0..SIDE * SIDE).map(|i| [0.5 + offset + 0.01 * (i * i % 17) as f32; 3]).collect()
        };
        let flat = vec![[0.58; 3]; (SIDE * SIDE) as usize];
        assert_eq!(disagreement(&noisy(0.0), &noisy(0.0)), None);
        let found = disagreement(&noisy(0.1), &flat).unwrap();
        assert!((found - 0.1 / 0.58).abs() < 0.01, "{found}");
    }

    #[test]
    fn outcomes_average_over_pictures() {
        let reference = vec![[1.0; 3]; 4];
        let runs = [1.0, 2.0].map(|value| Run { seconds: f64::from(value), pixels: vec![[value; 3]; 4] });
        let found = Outcome::of(&runs, &reference);
        assert_eq!(found.seconds, 1.5);
        assert!((found.error - 0.5 / 1.01).abs() < 1e-6, "{found:?}");
    }
}
