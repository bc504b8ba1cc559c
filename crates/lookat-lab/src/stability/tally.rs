//! Counting over many random tries, on all threads, with the same result on any number of them.

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

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
            self.worsen(error);
        }
    }

    /// Adds an error of an answer that is counted already.
    pub fn worsen(&mut self, error: f64) {
        self.worst = Some(self.worst.map_or(error, |worst| worst.max(error)));
    }

    pub fn join(mut self, other: Tally) -> Tally {
        other.worst.into_iter().for_each(|error| self.worsen(error));
        Tally { tried: self.tried + other.tried, failed: self.failed + other.failed, ..self }
    }
}

/// Tries that share a stream of random numbers.
const CHUNK: u64 = 4096;

/// Calls `attempt` `tries` times with random numbers. Each call of this function needs a `seed` of its own.
pub(super) fn tally(tries: u64, seed: u64, attempt: impl Fn(&mut Pcg64Mcg, &mut Tally) + Sync) -> Tally {
    let chunk = |index: u64| {
        let mut random = Pcg64Mcg::seed_from_u64(seed << 32 | index);
        let mut tally = Tally::default();
        for _ in 0..CHUNK.min(tries - index * CHUNK) {
            attempt(&mut random, &mut tally);
        }
        tally
    };
    (0..tries.div_ceil(CHUNK)).into_par_iter().map(chunk).reduce(Tally::default, Tally::join)
}

/// Powers of ten, each the number nearest to its decimal.
pub(super) fn decades(exponents: impl IntoIterator<Item = i32>) -> impl Iterator<Item = f64> {
    exponents.into_iter().filter_map(|exponent| format!("1e{exponent}").parse().ok())
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    #[test]
    fn counts_are_those_of_any_number_of_threads() {
        let count = || tally(10_000, 7, |random, all| all.error(random.random::<f64>()));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let (many, one) = (count(), pool.install(count));
        assert_eq!((many.tried, many.failed, many.worst), (10_000, 0, one.worst));
    }
}
