//! Counting over many random tries, on all threads, with the same result on any number of them.

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use statrs::distribution::{Beta, ContinuousCDF};

/// How often a method was tried and was wrong, and its largest error otherwise.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tally {
    pub tried: u64,
    pub failed: u64,
    pub worst: Option<f64>,
}

impl Tally {
    /// Counts an answer.
    pub fn answer(&mut self, is_right: bool) {
        self.tried += 1;
        self.failed += u64::from(!is_right);
    }

    /// Counts a right answer that is not exact. An error that is no number is a wrong answer.
    pub fn error(&mut self, error: f64) {
        self.answer(!error.is_nan());
        if !error.is_nan() {
            self.worst = Some(self.worst.map_or(error, |worst| worst.max(error)));
        }
    }

    pub fn join(self, other: Tally) -> Tally {
        let worst = match (self.worst, other.worst) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
        Tally { tried: self.tried + other.tried, failed: self.failed + other.failed, worst }
    }
}

/// Tries that share a stream of random numbers.
const CHUNK: u64 = 4096;

/// Calls `attempt` so often, with random numbers, to count for `N` methods. A `seed` of its own for each call of this.
pub(super) fn tally<const N: usize>(
    tries: u64,
    seed: u64,
    attempt: impl Fn(&mut Pcg64Mcg, &mut [Tally; N]) + Sync,
) -> [Tally; N] {
    let chunk = |index: u64| {
        let mut random = Pcg64Mcg::seed_from_u64(seed << 32 | index);
        let mut tallies = [Tally::default(); N];
        for _ in 0..CHUNK.min(tries - index * CHUNK) {
            attempt(&mut random, &mut tallies);
        }
        tallies
    };
    let join = |a: [Tally; N], b: [Tally; N]| std::array::from_fn(|i| a[i].join(b[i]));
    (0..tries.div_ceil(CHUNK)).into_par_iter().map(chunk).reduce(|| [Tally::default(); N], join)
}

/// The interval of Clopper and Pearson for a share, at 95 %.
pub fn interval(count: u64, of: u64) -> [f64; 2] {
    interval_at(0.025, count, of)
}

/// The same; each of its bounds is wrong with probability `tail`.
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

/// Of the beta distribution, by halving: `inverse_cdf` of statrs does not come back for large counts.
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
    use rand::RngExt;

    use super::*;

    const INTERVALS: [(u64, u64, [f64; 2]); 6] = [
        (0, 200, [0.0, 0.018275340355148807]),
        (3, 200, [0.003104107621555085, 0.043208281917709784]),
        (200, 200, [0.9817246596448512, 1.0]),
        (0, 10000000, [0.0, 3.6888789150222864e-07]),
        (2, 10000000, [2.4221136659589006e-08, 7.224685809698653e-07]),
        (3000000, 10000000, [0.2997159821652154, 0.3002841336338419]),
    ];

    #[test]
    fn intervals_are_those_of_tables() {
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

    #[test]
    fn counts_are_those_of_any_number_of_threads() {
        let count =
            || tally(10_000, 7, |random, [all]: &mut [Tally; 1]| all.error(random.random::<f64>()))[0];
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let (many, one) = (count(), pool.install(count));
        assert_eq!((many.tried, many.failed, many.worst), (10_000, 0, one.worst));
    }
}
