//! How fast an error falls: the slope of its logarithm over the logarithm of the number of samples.

use super::estimate::{moments, t_quantile};

/// A line through errors that are drawn on logarithmic axes: `error = scale * samples^slope`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// The slope; -0.5 for independent samples.
    pub slope: f64,
    /// Half of its 95 % interval: by Student's t over the seeds. It says nothing of how straight the line is.
    pub half_width: f64,
    /// The error that the line has at one sample per pixel.
    pub scale: f64,
    /// How far off the line a point is at most, as the logarithm of the ratio.
    pub deviation: f64,
    /// How many points it goes through.
    pub rungs: usize,
}

/// What one number of samples gave: the mean squared error for each seed.
pub(super) struct RungErrors<'a> {
    pub samples: f64,
    pub squares: &'a [f64],
}

/// Weighted least squares of the logarithm of the root of the mean square. The weights are the inverse variances of these
/// logarithms, each variance averaged with the mean of all: eight seeds tell a variance only to within half of itself, and
/// where it comes out small by chance it must not rule the line. `None` for less than three points or two seeds.
pub(super) fn fit(rungs: &[RungErrors]) -> Option<Fit> {
    let seeds = rungs.first()?.squares.len();
    let samples = || rungs.iter().map(|rung| rung.samples);
    // A slope over hardly any range says nothing.
    let is_wide = samples().fold(0.0, f64::max) >= 2.0 * samples().fold(f64::INFINITY, f64::min);
    let squares: Vec<f64> = rungs.iter().map(|rung| moments(rung.squares).mean).collect();
    let can_be_drawn = squares.iter().all(|square| *square > 0.0 && square.is_finite());
    let is_regular = seeds >= 2 && rungs.iter().all(|rung| rung.squares.len() == seeds);
    if rungs.len() < 3 || !is_wide || !can_be_drawn || !is_regular {
        return None;
    }
    let x: Vec<f64> = rungs.iter().map(|rung| rung.samples.ln()).collect();
    let y: Vec<f64> = squares.iter().map(|square| 0.5 * square.ln()).collect();
    let influences = influences(rungs, &squares);
    let weights = weights(&influences);
    let center = |of: &[f64]| dot(&weights, of) / weights.iter().sum::<f64>();
    let (x_center, y_center) = (center(&x), center(&y));
    let spread: f64 = x.iter().zip(&weights).map(|(x, weight)| weight * (x - x_center).powi(2)).sum();
    let share: Vec<f64> =
        x.iter().zip(&weights).map(|(x, weight)| weight * (x - x_center) / spread).collect();
    let slope = dot(&share, &y);
    let of_seeds: Vec<f64> = (0..seeds)
        .map(|seed| share.iter().zip(&influences).map(|(share, rung)| share * rung[seed]).sum())
        .collect();
    let at = |x: f64| y_center + slope * (x - x_center);
    let deviation = x.iter().zip(&y).map(|(x, y)| (y - at(*x)).abs()).fold(0.0, f64::max);
    let half_width = t_quantile(seeds) * moments(&of_seeds).standard_error;
    Some(Fit { slope, half_width, scale: at(0.0).exp(), deviation, rungs: rungs.len() })
}

/// How each seed moves the logarithm of the root of the mean square, to first order.
fn influences(rungs: &[RungErrors], means: &[f64]) -> Vec<Vec<f64>> {
    let of_rung = |(rung, mean): (&RungErrors, &f64)| {
        rung.squares.iter().map(|square| 0.5 * (square / mean - 1.0)).collect()
    };
    rungs.iter().zip(means).map(of_rung).collect()
}

fn weights(influences: &[Vec<f64>]) -> Vec<f64> {
    let variances: Vec<f64> = influences.iter().map(|rung| moments(rung).standard_error.powi(2)).collect();
    let mean = variances.iter().sum::<f64>() / variances.len() as f64;
    if mean <= 0.0 {
        return vec![1.0; variances.len()];
    }
    variances.iter().map(|variance| 2.0 / (variance + mean)).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    fn fitted(squares: &[Vec<f64>]) -> Option<Fit> {
        let rung = |(i, squares): (usize, &Vec<f64>)| (f64::from(1 << i), squares.clone());
        let rungs: Vec<_> = squares.iter().enumerate().map(rung).collect();
        let rungs: Vec<RungErrors> =
            rungs.iter().map(|(samples, squares)| RungErrors { samples: *samples, squares }).collect();
        fit(&rungs)
    }

    #[test]
    fn a_line_is_found_as_it_is() {
        for slope in [-0.5, -0.75, 0.0, -1.5] {
            // rmse = 0.3 n^slope.
            let squares = |i: i32| vec![(0.3 * 2.0_f64.powi(i).powf(slope)).powi(2); 8];
            let found = fitted(&(0..6).map(squares).collect::<Vec<_>>()).unwrap();
            assert!((found.slope - slope).abs() < 1e-12 && (found.scale - 0.3).abs() < 1e-12, "{found:?}");
            assert!(found.half_width < 1e-12 && found.deviation < 1e-12 && found.rungs == 6);
        }
        assert_eq!(fitted(&[vec![1.0; 8], vec![0.5; 8]]), None);
        assert_eq!(fitted(&[vec![1.0; 8], vec![0.5; 8], vec![0.0; 8]]), None);
        assert_eq!(fitted(&[vec![1.0], vec![0.5], vec![0.2]]), None);
    }

    /// The interval of 1000 fits has the true slope in 95 % of them, where rungs are of different spread.
    #[test]
    fn intervals_hold_what_they_promise() {
        const FITS: usize = 1000;
        let mut random = Pcg64Mcg::seed_from_u64(6);
        let mut squares = |i: i32| -> Vec<f64> {
            let spread = 0.4 / f64::from(1 + i);
            let mut even = || (0..4).map(|_| random.random::<f64>() - 0.5).sum::<f64>();
            (0..8).map(|_| 0.25_f64.powi(i) * (1.0 + spread * even())).collect()
        };
        let mut holds = 0;
        for _ in 0..FITS {
            let found = fitted(&(0..6).map(&mut squares).collect::<Vec<_>>()).unwrap();
            holds += usize::from((found.slope + 1.0).abs() <= found.half_width);
        }
        // Five standard deviations of a count with p = 0.95 are 34; estimated weights take a little.
        assert!((905..=985).contains(&holds), "{holds} of {FITS}");
    }
}
