//! Numbers with 95 % intervals, from repetitions with different seeds.

use statrs::distribution::{Binomial, ContinuousCDF, DiscreteCDF, StudentsT};

/// A number, and the interval that has it with a probability of 95 %, or a little more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

impl Estimate {
    /// The same on another scale; `scale` must not decrease.
    pub(super) fn map(self, scale: impl Fn(f64) -> f64) -> Estimate {
        Estimate { value: scale(self.value), low: scale(self.low), high: scale(self.high) }
    }
}

/// The mean, with Student's t. At least two values.
pub(super) fn mean(values: &[f64]) -> Estimate {
    let Moments { mean, standard_error } = moments(values);
    let half = t_quantile(values.len()) * standard_error;
    Estimate { value: mean, low: mean - half, high: mean + half }
}

/// The mean of what cannot be negative, with Student's t on a logarithmic scale, so that the interval cannot be either.
pub(super) fn positive_mean(values: &[f64]) -> Estimate {
    let Moments { mean, standard_error } = moments(values);
    let factor = if mean > 0.0 { (t_quantile(values.len()) * standard_error / mean).exp() } else { 1.0 };
    Estimate { value: mean, low: mean / factor, high: mean * factor }
}

/// The median, between two of the values in order: whatever their distribution is, it lies between them with 95 % or more.
/// That takes 6 values; fewer give their whole range. At least one value.
pub(super) fn median(values: &[f64]) -> Estimate {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let count = sorted.len();
    let value = 0.5 * (sorted[(count - 1) / 2] + sorted[count / 2]);
    let outside = outside(count);
    Estimate { value, low: sorted[outside], high: sorted[count - 1 - outside] }
}

/// How many of so many values can be left out on each side: the median is beyond `k` of them on either side with the
/// probability that at most `k` of so many coins show heads.
fn outside(count: usize) -> usize {
    let Ok(heads) = Binomial::new(0.5, count as u64) else { return 0 };
    (0..count).take_while(|k| heads.cdf(*k as u64) <= 0.025).last().unwrap_or(0)
}

pub(super) struct Moments {
    pub mean: f64,
    /// Of the mean.
    pub standard_error: f64,
}

/// Of independent values; the standard error of a single one is infinite.
pub(super) fn moments(values: &[f64]) -> Moments {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    let standard_error = if count > 1.0 { (squares / (count - 1.0) / count).sqrt() } else { f64::INFINITY };
    Moments { mean, standard_error }
}

/// The half width of a 95 % interval in standard errors, for so many values.
pub(super) fn t_quantile(count: usize) -> f64 {
    StudentsT::new(0.0, 1.0, count as f64 - 1.0).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, expected: f64) {
        assert!((found / expected - 1.0).abs() < 1e-6, "{found}, not {expected}");
    }

    #[test]
    fn intervals_are_those_of_tables() {
        // t of 7 degrees of freedom at 97.5 %.
        close(t_quantile(8), 2.364_624_252);
        let values = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
        let found = mean(&values);
        close(found.value, 4.5);
        // The variance of 1 to 8 is 6.
        close(found.high - found.value, 2.364_624_252 * (6.0_f64 / 8.0).sqrt());
        let found = positive_mean(&values);
        close(found.high / found.value, (2.364_624_252 * (6.0_f64 / 8.0).sqrt() / 4.5).exp());
        close(found.value / found.low, found.high / found.value);
        assert_eq!(positive_mean(&[0.0; 8]), Estimate { value: 0.0, low: 0.0, high: 0.0 });
    }

    #[test]
    fn the_median_lies_between_values_in_order() {
        // The sign test at 5 %: all of 8 values, all but one on each side of 9 to 11, but two of 12 to 14, but 5 of 20.
        let first_to = |count: usize| median(&(0..count).rev().map(|i| i as f64).collect::<Vec<_>>());
        assert_eq!(first_to(8), Estimate { value: 3.5, low: 0.0, high: 7.0 });
        assert_eq!(first_to(9), Estimate { value: 4.0, low: 1.0, high: 7.0 });
        assert_eq!(first_to(12).low, 2.0);
        assert_eq!(first_to(20).low, 5.0);
        assert_eq!(first_to(3), Estimate { value: 1.0, low: 0.0, high: 2.0 });
    }
}
