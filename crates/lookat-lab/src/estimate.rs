//! Numbers from repetitions and counts, with 95 % intervals.

use serde::Serialize;
use statrs::distribution::{Beta, ContinuousCDF, StudentsT};

/// A number and its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// The ends of the interval.
    pub interval: [f64; 2],
}

impl Estimate {
    /// The mean of independent values, with an interval by Student's t: infinite for a single value.
    pub fn mean(values: &[f64]) -> Estimate {
        let (value, standard_error) = mean_and_error(values);
        let t = StudentsT::new(0.0, 1.0, values.len() as f64 - 1.0);
        let half = t.map_or(f64::INFINITY, |t| t.inverse_cdf(0.975) * standard_error);
        Estimate { value, interval: [value - half, value + half] }
    }

    /// The median, with the range of all values. At least one value. The range of 6 or more holds the median of their
    /// distribution with a probability above 95 %.
    pub fn median(values: &[f64]) -> Estimate {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len() - 1;
        let value = 0.5 * (sorted[last / 2] + sorted[last.div_ceil(2)]);
        Estimate { value, interval: [sorted[0], sorted[last]] }
    }

    /// The root of a number that cannot be negative; an end of the interval below 0 becomes 0.
    pub fn root(self) -> Estimate {
        let root = |x: f64| x.max(0.0).sqrt();
        Estimate { value: root(self.value), interval: self.interval.map(root) }
    }
}

/// The mean; NaN without values.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The mean, and its standard error from the scatter of the values.
pub fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let (count, mean) = (values.len() as f64, mean(values));
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (count - 1.0) / count).sqrt())
}

/// How fast an error falls: it is proportional to samples^slope.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Slope {
    /// The slope; -0.5 for independent samples.
    pub slope: f64,
    /// The ends of its 95 % interval, by Student's t over the seeds.
    pub interval: [f64; 2],
    /// The number of points that the line goes through.
    pub points: usize,
}

impl Slope {
    /// The mean slope of the lines of single seeds, each by least squares on logarithmic axes. A point is its samples and the
    /// squared error of each seed. `None` for fewer than three points, for fewer than two seeds, for samples that do not even
    /// double, and where an error is 0.
    pub fn new(points: &[(f64, &[f64])]) -> Option<Slope> {
        let seeds = points.first()?.1.len();
        let (least, most) = (points.first()?.0, points.last()?.0);
        let is_positive = points.iter().all(|(_, squares)| squares.iter().all(|square| *square > 0.0));
        if points.len() < 3 || seeds < 2 || most < 2.0 * least || !is_positive {
            return None;
        }
        let x: Vec<f64> = points.iter().map(|point| point.0.ln()).collect();
        let middle = x.iter().sum::<f64>() / x.len() as f64;
        let spread: f64 = x.iter().map(|x| (x - middle).powi(2)).sum();
        let slope_of = |seed: usize| {
            let errors = points.iter().map(|(_, squares)| 0.5 * squares[seed].ln());
            x.iter().zip(errors).map(|(x, error)| (x - middle) * error).sum::<f64>() / spread
        };
        let Estimate { value, interval } = Estimate::mean(&(0..seeds).map(slope_of).collect::<Vec<_>>());
        Some(Slope { slope: value, interval, points: points.len() })
    }
}

/// The interval of Clopper and Pearson for a share, at 95 %.
pub fn interval(count: u64, of: u64) -> [f64; 2] {
    interval_at(0.025, count, of)
}

/// The interval of Clopper and Pearson for a share. Each of its bounds is wrong with probability `tail`.
pub fn interval_at(tail: f64, count: u64, of: u64) -> [f64; 2] {
    let all = of.max(1) as f64;
    let low = match count {
        0 => 0.0,
        _ if count == of => tail.powf(1.0 / all),
        _ => quantile(count, of - count + 1, tail),
    };
    let high = match count {
        0 => 1.0 - tail.powf(1.0 / all),
        _ if count == of => 1.0,
        _ => quantile(count + 1, of - count, 1.0 - tail),
    };
    [low, high]
}

/// The quantile of the beta distribution, by halving: `inverse_cdf` of statrs does not return for large counts.
fn quantile(a: u64, b: u64, p: f64) -> f64 {
    let Ok(beta) = Beta::new(a as f64, b as f64) else { return f64::NAN };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if beta.cdf(middle) < p { low = middle } else { high = middle }
    }
    low
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    #[test]
    fn intervals_equal_those_of_tables() {
        let values = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
        let found = Estimate::mean(&values);
        // t of 7 degrees of freedom at 97.5 %; the variance of 1 to 8 is 6.
        let half = 2.364_624_252 * (6.0_f64 / 8.0).sqrt();
        assert!(found.value == 4.5 && (found.interval[1] - 4.5 - half).abs() < 1e-6, "{found:?}");
        assert_eq!(Estimate::median(&values), Estimate { value: 4.5, interval: [1.0, 8.0] });
        assert_eq!(Estimate::median(&[3.0, 1.0, 2.0]).value, 2.0);
        let root = Estimate { value: 4.0, interval: [-1.0, 9.0] }.root();
        assert_eq!(root, Estimate { value: 2.0, interval: [0.0, 3.0] });
    }

    fn slope(squares: &[Vec<f64>]) -> Option<Slope> {
        let point = |(i, squares): (usize, &Vec<f64>)| (f64::from(1 << i), squares.clone());
        let points: Vec<_> = squares.iter().enumerate().map(point).collect();
        let points: Vec<_> = points.iter().map(|(samples, squares)| (*samples, &squares[..])).collect();
        Slope::new(&points)
    }

    #[test]
    fn a_line_has_its_slope() {
        for expected in [-0.5, -0.75, 0.0, -1.5] {
            let squares = |i: i32| vec![(0.3 * 2.0_f64.powi(i).powf(expected)).powi(2); 8];
            let found = slope(&(0..6).map(squares).collect::<Vec<_>>()).unwrap();
            assert!((found.slope - expected).abs() < 1e-12 && found.points == 6, "{found:?}");
            assert!(found.interval.iter().all(|end| (end - expected).abs() < 1e-12), "{found:?}");
        }
        assert_eq!(slope(&[vec![1.0; 8], vec![0.5; 8]]), None);
        assert_eq!(slope(&[vec![1.0; 8], vec![0.5; 8], vec![0.0; 8]]), None);
        assert_eq!(slope(&[vec![1.0], vec![0.5], vec![0.2]]), None);
    }

    /// 95 % of the intervals of 1000 slopes hold the true one, where the scatter of the points differs.
    #[test]
    fn intervals_hold_the_slope() {
        const FITS: usize = 1000;
        let mut random = Pcg64Mcg::seed_from_u64(6);
        let mut squares = |i: i32| -> Vec<f64> {
            // The logarithm scatters around that of the line, by less with more samples.
            let spread = 0.4 / f64::from(1 + i);
            let mut even = || (0..4).map(|_| random.random::<f64>() - 0.5).sum::<f64>();
            (0..8).map(|_| 0.25_f64.powi(i) * (spread * even()).exp()).collect()
        };
        let mut holds = 0;
        for _ in 0..FITS {
            let found = slope(&(0..6).map(&mut squares).collect::<Vec<_>>()).unwrap();
            holds += usize::from(found.interval[0] <= -1.0 && -1.0 <= found.interval[1]);
        }
        // Five standard deviations of a count with p = 0.95 are 34.
        assert!((916..=984).contains(&holds), "{holds} of {FITS}");
    }

    const INTERVALS: [(u64, u64, [f64; 2]); 6] = [
        (0, 200, [0.0, 0.018275340355148807]),
        (3, 200, [0.003104107621555085, 0.043208281917709784]),
        (200, 200, [0.9817246596448512, 1.0]),
        (0, 10000000, [0.0, 3.6888789150222864e-07]),
        (2, 10000000, [2.4221136659589006e-08, 7.224685809698653e-07]),
        (3000000, 10000000, [0.2997159821652154, 0.3002841336338419]),
    ];

    #[test]
    fn intervals_of_shares_are_those_of_tables() {
        // SciPy 1.17, binomtest(k, n).proportion_ci().
        for (count, of, expected) in INTERVALS {
            let found = interval(count, of);
            // The gamma function of statrs has not all digits at such counts.
            for (found, expected) in found.into_iter().zip(expected) {
                assert!(
                    (found - expected).abs() <= 1e-4 * expected,
                    "{count} of {of}: {found}, not {expected}"
                );
            }
        }
    }
}
