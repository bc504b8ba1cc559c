//! How the samples of a picture are shared out among its pixels.

use rayon::prelude::*;

/// A pixel gets at least the mean divided by this: neighbors do not know of a light in a single pixel.
pub(super) const LEAST: u32 = 2;
/// A pixel gets at most the mean times this, so that the noise around one bright sample does not take all.
const MOST: u32 = 64;
/// And at most the mean of as many pixels as the picture has over this: no few pixels take all.
const SHARE: usize = 256;
/// How far away a neighbor may be, in pixels across and down. Fewer neighbors know less: the counts that follow scatter, and
/// the errors become larger.
const REACH: usize = 2;
/// What pixels need whose neighbors have shown no noise, relative to the largest need.
const QUIET: f64 = 1e-6;
/// The errors of Sobol's samples, squared, fall about with the square of their number: then the sum over pixels of
/// `variance / count^2` is least where the counts are as the cubic roots of the variances.
const EXPONENT: f64 = 1.0 / 3.0;

/// Pixels of one class lie so many pixels apart, across and down: further than a neighbor may be.
const APART: usize = REACH + 2;

/// How many samples each pixel is to have, row by row: by the variance of the samples of its neighbors, by powers of two,
/// for which patterns are best; `mean` on average, but for a few percent. None has less than its count so far, or than half
/// of the mean.
///
/// What one pixel gets is taken from all others. So pixels are shared out by classes, each as if nothing were known of the
/// samples of its own: by them a pixel has no say in how many more it gets.
pub(super) fn allotted(variances: &[f64], width: usize, counts: &[u32], mean: u32) -> Vec<u32> {
    let around = (0..variances.len()).into_par_iter().map(|at| Around::new(variances, width, at)).collect();
    let shares = Shares { around, variances, width, counts, mean };
    let (first, guess) = shares.of_class(0, None);
    let others: Vec<Vec<u32>> =
        (1..APART * APART).into_par_iter().map(|class| shares.of_class(class, Some(guess)).0).collect();
    let mut goals: Vec<_> = std::iter::once(first).chain(others).map(Vec::into_iter).collect();
    (0..variances.len()).filter_map(|at| goals[class_of(at, width)].next()).collect()
}

fn class_of(at: usize, width: usize) -> usize {
    at % width % APART + at / width % APART * APART
}

/// The sum of what the neighbors of a pixel have shown, and how many they are.
#[derive(Clone, Copy)]
struct Around {
    sum: f64,
    count: u32,
}

impl Around {
    fn new(variances: &[f64], width: usize, at: usize) -> Around {
        let mut around = Around { sum: 0.0, count: 0 };
        let height = variances.len() / width;
        for row in reach(at / width, height) {
            for column in reach(at % width, width).filter(|column| row * width + column != at) {
                around.sum += variances[row * width + column];
                around.count += 1;
            }
        }
        around
    }

    /// Without those neighbors that are of a class.
    fn without(self, class: usize, variances: &[f64], width: usize, at: usize) -> Around {
        let mut around = self;
        let height = variances.len() / width;
        for row in reach(at / width, height).filter(|row| row % APART == class / APART) {
            let of_class = |column: &usize| column % APART == class % APART && row * width + column != at;
            for column in reach(at % width, width).filter(of_class) {
                around.sum -= variances[row * width + column];
                around.count -= 1;
            }
        }
        around
    }
}

/// The places so near to one of a row or column.
fn reach(place: usize, end: usize) -> std::ops::RangeInclusive<usize> {
    place.saturating_sub(REACH)..=(place + REACH).min(end - 1)
}

/// What classes are shared out by.
struct Shares<'a> {
    around: Vec<Around>,
    variances: &'a [f64],
    width: usize,
    counts: &'a [u32],
    mean: u32,
}

impl Shares<'_> {
    /// The goals of the pixels of a class, in order, and the scale that they have; `guess`: about that.
    fn of_class(&self, class: usize, guess: Option<i32>) -> (Vec<u32>, i32) {
        let levels = self.levels(class);
        let scale = self.scale(&levels, guess);
        let members = (0..levels.len()).filter(|at| class_of(*at, self.width) == class);
        (members.map(|at| self.goal(at, &levels, scale)).collect(), scale)
    }

    /// Logarithms to base 2 of what the pixels need, relative to the largest, as far as other classes tell.
    fn levels(&self, class: usize) -> Vec<f64> {
        let needs = self.around.iter().enumerate().map(|(at, around)| {
            let Around { sum, count } = around.without(class, self.variances, self.width, at);
            // Of sums that are equal rounding may leave something.
            if sum <= 1e-12 * around.sum { 0.0 } else { sum / f64::from(count) }
        });
        let mut levels: Vec<f64> = needs.collect();
        let largest = levels.iter().copied().fold(0.0, f64::max);
        for (at, level) in levels.iter_mut().enumerate() {
            let relative = if largest > 0.0 { *level / largest } else { 1.0 };
            let need = libm::pow(relative, EXPONENT).max(QUIET);
            // Pixels that need alike do not all double at once.
            *level = libm::log2(need * (0.98 + 0.04 * (at as f64 * GOLDEN).fract()));
        }
        levels
    }

    /// The number of samples of a pixel.
    fn goal(&self, at: usize, levels: &[f64], scale: i32) -> u32 {
        let (least, most) = (self.mean / LEAST, self.mean.saturating_mul(most_times(levels.len())));
        let wanted = 1_u32 << (f64::from(scale) / STEPS + levels[at]).round().clamp(0.0, 31.0) as u32;
        wanted.min(most).max(least).max(self.counts[at])
    }

    /// The largest scale at which all pixels together get no more than there is.
    fn scale(&self, levels: &[f64], guess: Option<i32>) -> i32 {
        let total = levels.len() as u64 * u64::from(self.mean);
        let fits = |scale: i32| {
            let goals = (0..levels.len()).map(|at| u64::from(self.goal(at, levels, scale)));
            goals.sum::<u64>() <= total
        };
        let step = STEPS as i32;
        let (mut low, mut high) = guess.map_or((LOWEST, HIGHEST), |guess| (guess - 1, guess + step / 4));
        while low > LOWEST && !fits(low) {
            (low, high) = ((low - step / 4).max(LOWEST), low);
        }
        while high < HIGHEST && fits(high) {
            (low, high) = (high, (high + step).min(HIGHEST));
        }
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if fits(middle) { low = middle } else { high = middle }
        }
        low
    }
}

/// Scales are multiples of one over this: then few pixels are left to share the rest.
const STEPS: f64 = 16384.0;
/// At this scale nobody gets more than the least,
const LOWEST: i32 = -2 * STEPS as i32;
/// and at this one all get the most.
const HIGHEST: i32 = 54 * STEPS as i32;

/// How many times the mean a pixel of so many may get; 1 where all are to have alike many.
fn most_times(pixels: usize) -> u32 {
    MOST.min((pixels / SHARE) as u32).max(1)
}

/// Its multiples are spread evenly, whatever the width of a picture.
const GOLDEN: f64 = 0.618_033_988_749_895;

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    /// As many of all pixels so far.
    fn shared(variances: &[f64], width: usize, so_far: u32, mean: u32) -> Vec<u32> {
        allotted(variances, width, &vec![so_far; variances.len()], mean)
    }

    /// Whatever a pixel has shown, it gets as many: of one noisy pixel only those around hear, and what they get is taken
    /// from others.
    #[test]
    fn a_pixel_has_no_say_in_its_own_samples() {
        const SIDE: usize = 64;
        let mut random = Pcg64Mcg::seed_from_u64(5);
        for is_dark in [true, false] {
            let mut variances = vec![0.0; SIDE * SIDE];
            if !is_dark {
                variances.fill_with(|| random.random::<f64>().powi(20));
            }
            for at in [0, 5, 17 * SIDE + 63, 30 * SIDE + 30, SIDE * SIDE - 1] {
                let before = shared(&variances, SIDE, 8, 16);
                let mut lucky = variances.clone();
                lucky[at] = 24.0;
                let after = shared(&lucky, SIDE, 8, 16);
                assert_eq!(before[at], after[at]);
                let next = at ^ 1;
                assert!(before[next] < after[next], "{} {}", before[next], after[next]);
                let less = (0..SIDE * SIDE).filter(|other| after[*other] < before[*other]).count();
                assert!(less > 20, "{less}");
            }
        }
    }

    #[test]
    fn goals_spend_what_there_is_by_need() {
        /// So many that a pixel may get the most.
        const SIDE: usize = 128;
        const PIXELS: usize = SIDE * SIDE;
        let spent = |goals: &[u32]| goals.iter().map(|goal| u64::from(*goal)).sum::<u64>() as f64;
        let is_spent = |goals: &[u32], mean: u32, within: f64| {
            (spent(goals) / (f64::from(mean) * goals.len() as f64) - 1.0).abs() < within
        };
        // Alike: as powers of two allow, and mixed well.
        let even = shared(&[1.0; PIXELS], SIDE, 8, 24);
        assert!(is_spent(&even, 24, 1e-3));
        assert!(even.iter().all(|goal| [16, 32].contains(goal)));
        assert!(even.chunks_exact(64).all(|some| is_spent(some, 24, 0.2)));
        // By need, as powers of two allow, in between bounds.
        let variances: Vec<f64> = (0..PIXELS).map(|at| ((at / SIDE + 1) as f64).powi(3)).collect();
        let by_need = shared(&variances, SIDE, 8, 32);
        assert!(is_spent(&by_need, 32, 1e-2));
        assert!(by_need[..PIXELS / 4].iter().all(|goal| *goal == 16));
        assert!(by_need[PIXELS - 99..].iter().all(|goal| *goal == 64));
        let mut spike = vec![0.0; PIXELS];
        spike[50 * SIDE + 50] = 1.0;
        let spiked = shared(&spike, SIDE, 8, 16);
        // The class of the one pixel takes nothing from its own.
        assert!(is_spent(&spiked, 16, 0.01) && spiked.iter().all(|goal| *goal >= 8));
        assert_eq!((spiked[50 * SIDE + 50], spiked[51 * SIDE + 49]), (16, 16 * MOST));
        // What is there already counts.
        let mut counts = vec![16; 1024];
        counts[0] = 500;
        let late = allotted(&[1.0; 1024], 32, &counts, 64);
        assert!(is_spent(&late, 64, 0.01) && late[0] == 500 && late[1..].iter().all(|goal| *goal >= 32));
        // In small pictures nobody gets more.
        assert_eq!(shared(&[1.0], 1, 4, 23), [23]);
        assert_eq!(shared(&[1.0, 9.0], 2, 8, 17), [17, 17]);
        assert_eq!(shared(&[1.0, 9.0], 1, 8, 17), [17, 17]);
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
            let goals = shared(&variances, SIDE, 8, 16);
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
