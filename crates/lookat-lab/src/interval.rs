//! What a count of random events says of their probability.

use statrs::distribution::{Beta, ContinuousCDF};

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
}
