//! Counts right and wrong answers, and the largest error.

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

/// Measures lookat at one place.
pub(super) type Measure = fn(&Trial) -> Tally;

/// What a case measures at one place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Trial {
    /// Random rays, above 0. Cases with a fixed number of questions ignore it.
    pub rays: u64,
    pub seed: u64,
    /// The place on the axis; NaN without one.
    pub at: f64,
}

/// How often lookat was asked and was wrong, and its largest error otherwise.
#[derive(Debug, Clone, Default)]
pub(super) struct Tally {
    pub tried: u64,
    pub failed: u64,
    pub worst: Option<f64>,
    /// Failures and details in words.
    pub remarks: Vec<String>,
    /// Parts of the answers, by name.
    pub parts: Vec<(&'static str, Tally)>,
}

impl Tally {
    /// Answers of which the largest error is known. If it is NaN, one answer is wrong.
    pub fn measured(tried: u64, error: f64) -> Tally {
        Tally { tried, failed: u64::from(error.is_nan()), worst: Some(error), ..Tally::default() }
    }

    /// Adds a remark.
    pub fn remark(mut self, remark: String) -> Tally {
        self.remarks.push(remark);
        self
    }

    /// Counts an answer.
    pub fn answer(&mut self, is_right: bool) {
        self.tried += 1;
        self.failed += u64::from(!is_right);
    }

    /// Counts an answer with a remark if it is wrong.
    pub fn check(&mut self, is_right: bool, otherwise: impl FnOnce() -> String) {
        self.answer(is_right);
        if !is_right {
            self.remarks.push(otherwise());
        }
    }

    /// Counts a right answer with its error. NaN is a wrong answer.
    pub fn error(&mut self, error: f64) {
        self.answer(!error.is_nan());
        if !error.is_nan() {
            self.worsen(error);
        }
    }

    /// Adds an error of an answer that is already counted.
    pub fn worsen(&mut self, error: f64) {
        self.worst = Some(self.worst.map_or(error, |worst| worst.max(error)));
    }

    pub fn join(mut self, other: Tally) -> Tally {
        self.tried += other.tried;
        self.failed += other.failed;
        self.remarks.extend(other.remarks);
        self.parts.extend(other.parts);
        if let Some(error) = other.worst {
            self.worsen(error);
        }
        self
    }

    /// Adds a copy of some answers as a part.
    pub fn part(mut self, name: &'static str, part: &Tally) -> Tally {
        self.parts.push((name, part.clone()));
        self
    }
}

impl FromIterator<Tally> for Tally {
    fn from_iter<I: IntoIterator<Item = Tally>>(all: I) -> Tally {
        all.into_iter().fold(Tally::default(), Tally::join)
    }
}

/// Tries that share a stream of random numbers.
const CHUNK: u64 = 4096;

/// Calls `attempt` `tries` times with random numbers, on all threads, with the same result on any number of them. Each call of this
/// function needs a `seed` of its own.
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

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    #[test]
    fn counts_equal_on_any_number_of_threads() {
        let count = || tally(10_000, 7, |random, all| all.error(random.random::<f64>()));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let (many, one) = (count(), pool.install(count));
        assert_eq!((many.tried, many.failed, many.worst), (10_000, 0, one.worst));
    }
}
