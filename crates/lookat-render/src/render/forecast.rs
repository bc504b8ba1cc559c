//! Estimates the remaining time and samples of a rendering.

use std::time::Instant;

use super::Progress;

/// Estimates the remaining time of a rendering.
#[derive(Debug, Clone, Default)]
pub struct TimeLeft {
    /// Seconds since the first call, and the samples done by then. Each time is at least 2 % more than the previous
    /// one.
    history: Vec<(f64, u64)>,
    started: Option<(Instant, u64)>,
}

/// The factor by which the time per sample may rise or fall, because other pixels are sampled and the machine has other
/// work.
const SLACK: f64 = 1.4;

/// Seconds until the rate of samples is reliable.
const SETTLED: f64 = 0.5;

impl TimeLeft {
    /// The least and the most remaining time, in seconds. `None` while it is unknown. Call this function regularly.
    ///
    /// The bounds cover two rates of samples: the rate since the start, and the rate in the second half of the elapsed
    /// time.
    pub fn update(&mut self, progress: &Progress) -> Option<[f64; 2]> {
        let (started, before) = *self.started.get_or_insert((Instant::now(), progress.done));
        let (time, done) = (started.elapsed().as_secs_f64(), progress.done.saturating_sub(before));
        self.at(time, done, progress.left?)
    }

    fn at(&mut self, time: f64, done: u64, [least, most]: [u64; 2]) -> Option<[f64; 2]> {
        if self.history.last().is_none_or(|(last, _)| time > 1.02 * last) {
            self.history.push((time, done));
        }
        if time < SETTLED {
            return None;
        }
        let half = self.history.iter().rev().find(|(then, _)| *then <= 0.5 * time);
        let rate = |(from, before): (f64, u64)| (time - from) / done.saturating_sub(before) as f64;
        let all = rate((0.0, 0));
        let recent = half.map_or(all, |then| rate(*then));
        let [fast, slow] = [all.min(recent) / SLACK, all.max(recent) * SLACK];
        let left = [least as f64 * fast, most as f64 * slow];
        left.iter().all(|seconds| seconds.is_finite()).then_some(left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_work_is_estimated_within_the_slack() {
        let mut left = TimeLeft::default();
        for step in 1..=100 {
            let [least, most] =
                left.at(f64::from(step), 1000 * step as u64, [1000 * (100 - step as u64); 2]).unwrap();
            let truth = f64::from(100 - step);
            assert!((least - truth / SLACK).abs() < 1e-9 && (most - truth * SLACK).abs() < 1e-9);
        }
    }

    /// Slower samples raise the upper bound, and later also the lower bound.
    #[test]
    fn slower_samples_are_noticed() {
        let mut left = TimeLeft::default();
        (1..=10_u64).for_each(|second| {
            left.at(second as f64, 1000 * second, [9000; 2]);
        });
        let [mut least, mut most] = [0.0; 2];
        for second in 11..=40_u64 {
            [least, most] = left.at(second as f64, 10_000 + 100 * (second - 10), [1000; 2]).unwrap();
        }
        assert!(most >= 10.0 && least > 1.0, "{least} {most}");
        assert_eq!(TimeLeft::default().at(1.0, 0, [10; 2]), None);
    }
}
