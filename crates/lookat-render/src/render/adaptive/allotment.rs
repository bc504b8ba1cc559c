//! How the samples of a picture are shared out among its pixels.

use rayon::prelude::*;

/// A pixel gets at least the mean divided by this: neighbours do not know of a light in a single pixel.
pub(super) const LEAST: u32 = 2;
/// A pixel gets at most the mean times this, so that the noise around one bright sample does not take all.
const MOST: u32 = 64;
/// And at most the mean of as many pixels as the picture has over this. What a pixel brings its neighbours is taken from all
/// others, itself too: by this its say stays small.
const SHARE: usize = 256;
/// How far away a neighbour may be, in pixels across and down. Fewer neighbours know less: the counts that follow scatter, and
/// the errors become larger.
const REACH: usize = 2;
/// What pixels need whose neighbours have shown no noise, relative to the largest need.
const QUIET: f64 = 1e-6;
/// The errors of Sobol's samples, squared, fall about with the square of their number: then the sum over pixels of
/// `variance / count^2` is least where the counts are as the cubic roots of the variances.
const EXPONENT: f64 = 1.0 / 3.0;

/// How many samples each pixel should have, relative to others: by the variance of the samples of its neighbours. Row by
/// row, as all that follows.
pub(super) fn needs(variances: &[f64], width: usize) -> Vec<f64> {
    let height = variances.len() / width;
    let around = |at: usize, end: usize| at.saturating_sub(REACH)..=(at + REACH).min(end - 1);
    let need = |at: usize| {
        let (x, y) = (at % width, at / width);
        let (mut sum, mut count) = (0.0, 0);
        for row in around(y, height) {
            for column in around(x, width).filter(|column| (*column, row) != (x, y)) {
                sum += variances[row * width + column];
                count += 1;
            }
        }
        (sum / f64::from(count.max(1))).powf(EXPONENT)
    };
    let mut needs: Vec<f64> = (0..variances.len()).into_par_iter().map(need).collect();
    let largest = needs.iter().copied().fold(0.0, f64::max);
    let quiet = if largest > 0.0 { QUIET * largest } else { 1.0 };
    needs.iter_mut().for_each(|need| *need = need.max(quiet));
    needs
}

/// How many samples each pixel is to have: in proportion to its need, by powers of two, for which patterns are best; `mean`
/// on average. None has less than its count so far, or than half of the mean.
pub(super) fn allotted(needs: &[f64], counts: &[u32], mean: u32) -> Vec<u32> {
    // Pixels that need alike do not all double at once.
    let jitter = |at: usize| 0.98 + 0.04 * (at as f64 * GOLDEN).fract();
    let level = |at: usize| (needs[at] * jitter(at)).log2();
    let levels: Vec<f64> = (0..needs.len()).into_par_iter().map(level).collect();
    let (least, most) = (mean / LEAST, mean.saturating_mul(most_times(needs.len())));
    let goal = |at: usize, scale: f64| {
        let wanted = 1_u32 << (scale + levels[at]).round().clamp(0.0, 31.0) as u32;
        wanted.min(most).max(least).max(counts[at])
    };
    let total = needs.len() as u64 * u64::from(mean);
    let sum = |scale: f64| (0..needs.len()).into_par_iter().map(|at| u64::from(goal(at, scale))).sum::<u64>();
    // At the first scale nobody gets more than the least, at the other all get the most.
    let (lowest, highest) = levels
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), level| (a.min(*level), b.max(*level)));
    let (mut low, mut high) = (-highest - 1.0, 33.0 - lowest);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if sum(middle) <= total { low = middle } else { high = middle }
    }
    let mut rest = total - sum(low);
    let spend = |at: usize| {
        let more = u64::from(goal(at, high) - goal(at, low)).min(rest);
        rest -= more;
        goal(at, low) + more as u32
    };
    (0..needs.len()).map(spend).collect()
}

/// How many times the mean a pixel of so many may get; 1 where all are to have alike many.
fn most_times(pixels: usize) -> u32 {
    MOST.min((pixels / SHARE) as u32).max(1)
}

/// Of the interval in which the scale is looked for: then few pixels are left to share the rest.
const HALVINGS: u32 = 40;

/// Its multiples are spread evenly, whatever the width of a picture.
const GOLDEN: f64 = 0.618_033_988_749_895;

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    /// Of one noisy pixel only the others around hear.
    #[test]
    fn a_pixel_has_no_say_in_its_own_samples() {
        let mut variances = vec![0.0; 11 * 11];
        variances[5 * 11 + 5] = 24.0;
        for (at, need) in needs(&variances, 11).into_iter().enumerate() {
            let distance = (at % 11).abs_diff(5).max((at / 11).abs_diff(5));
            assert_eq!(need, if (1..=REACH).contains(&distance) { 1.0 } else { QUIET }, "{at}");
        }
        assert_eq!(needs(&[3.0], 1), [1.0]);
    }

    #[test]
    fn goals_spend_what_there_is_by_need() {
        /// So many that a pixel may get the most.
        const PIXELS: usize = MOST as usize * SHARE;
        let spent = |goals: &[u32]| goals.iter().map(|goal| u64::from(*goal)).sum::<u64>();
        // Alike: as powers of two allow, and mixed well.
        let even = allotted(&[1.0; PIXELS], &[8; PIXELS], 24);
        assert_eq!(spent(&even), 24 * PIXELS as u64);
        assert!(even.iter().filter(|goal| [16, 32].contains(*goal)).count() >= PIXELS - 1);
        assert!(even.chunks_exact(64).all(|some| (20 * 64..28 * 64).contains(&spent(some))));
        // By need, as powers of two allow, in between bounds.
        let needs: Vec<f64> = (0..PIXELS).map(|at| (at + 1) as f64).collect();
        let by_need = allotted(&needs, &[8; PIXELS], 32);
        assert_eq!(spent(&by_need), 32 * PIXELS as u64);
        assert!(by_need[..PIXELS / 4].iter().all(|goal| *goal == 16));
        assert!(by_need[PIXELS - 99..].iter().all(|goal| *goal == 64));
        let mut spike = vec![1e-6; PIXELS];
        spike[500] = 1.0;
        let spiked = allotted(&spike, &[8; PIXELS], 16);
        assert_eq!((spent(&spiked), spiked[500]), (16 * PIXELS as u64, 16 * MOST));
        assert!(spiked.iter().all(|goal| *goal >= 8));
        // What is there already counts.
        let mut counts = vec![16; 1024];
        counts[0] = 500;
        let late = allotted(&[1.0; 1024], &counts, 64);
        assert!(spent(&late) == 64 * 1024 && late[0] == 500 && late[1..].iter().all(|goal| *goal >= 32));
        // In small pictures nobody gets more.
        assert_eq!(allotted(&[1.0], &[4], 23), [23]);
        assert_eq!(allotted(&[1.0, 9.0], &[8, 8], 17), [17, 17]);
    }

    /// In a patch of pixels that are 1 in a twentieth of their samples, in the midst of black, the mean is a twentieth: lucky
    /// pixels are outweighed by as many samples as others. It is not where pixels have a say in their own samples.
    #[test]
    fn luck_is_not_kept() {
        const SIDE: usize = 32;
        const PATCH: std::ops::Range<usize> = 14..17;
        const PICTURES: u32 = 2000;
        let is_noisy = |at: usize| PATCH.contains(&(at % SIDE)) && PATCH.contains(&(at / SIDE));
        let mut random = Pcg64Mcg::seed_from_u64(3);
        let mut hits = |count: u32| (0..count).filter(|_| random.random::<f64>() < 0.05).count() as f64;
        let mut means = Vec::new();
        for _ in 0..PICTURES {
            let first: Vec<f64> =
                (0..SIDE * SIDE).map(|at| if is_noisy(at) { hits(8) } else { 0.0 }).collect();
            let variances: Vec<f64> = first.iter().map(|sum| sum * (1.0 - sum / 8.0) / 7.0).collect();
            let goals = allotted(&needs(&variances, SIDE), &[8; SIDE * SIDE], 16);
            let patch = (0..SIDE * SIDE).filter(|at| is_noisy(*at));
            let values = patch.map(|at| (first[at] + hits(goals[at] - 8)) / f64::from(goals[at]));
            means.push(values.sum::<f64>() / PATCH.len().pow(2) as f64);
        }
        let mean = means.iter().sum::<f64>() / f64::from(PICTURES);
        let variance = means.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / f64::from(PICTURES - 1);
        let error = (variance / f64::from(PICTURES)).sqrt();
        assert!(error < 0.01 * 0.05 && (mean - 0.05).abs() < 4.0 * error, "{mean} {error}");
    }
}
