//! Adaptive sampling: first the same number of samples for all pixels, then more where the picture is noisy, so that its mean squared
//! error is small.
//!
//! A pixel's own samples do not decide how many more it gets: a pixel that missed a light by chance would be taken for done, and such
//! pixels would be too dark on average. Noise is measured once: if it were measured again, a pixel would decide about itself by way of
//! its neighbors, which see the more, the more samples it has brought them.

use std::sync::Mutex;

use glam::DVec3;
use lookat_scene::Sampler;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::control::Control;
use super::rounds::{Policy, doubled};
use super::sample::{Job, Pattern};
use super::settings::Stop;
use crate::film::{Area, Film, Sum, Tile, lock};
use crate::sampler::of_single_pixels;

/// The least samples of every pixel before their noise is estimated.
const FEWEST: u32 = 4;
/// The same, if the total number is unknown.
const FIRST: u32 = Stop::FIRST_OF_ADAPTIVE;

/// The scene's samples per pixel, or the most where there is a time, as their mean.
pub(super) struct Adaptive {
    /// The pixels in which samples are taken.
    sources: Area,
    pattern: Pattern,
    samples_per_pixel: u32,
    passes: Vec<Pass>,
    plan: Plan,
    /// The filter's weights for the unit squares around a pixel, across and down.
    squares: [Vec<f64>; 2],
}

/// Where the samples of a pass go.
#[derive(Serialize, Deserialize)]
pub(super) struct Plan {
    /// The number of passes that have begun.
    begun: u32,
    /// The variance of the samples of each source, row by row. `None` before the first pass that needs it.
    variances: Option<Vec<f64>>,
    /// The number of samples of each source before and after this pass, row by row.
    counts: Vec<u32>,
    goals: Vec<u32>,
}

/// The moments of the samples of a source.
#[derive(Debug, Default, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Moments {
    sum: DVec3,
    /// The sum of squared lengths.
    squares: f64,
}

impl Moments {
    /// The variance of so many samples, added up over the channels. 0 for less than two.
    fn variance(&self, count: u32) -> f64 {
        if count < 2 {
            return 0.0;
        }
        let count = f64::from(count);
        // Rounding may leave less than nothing.
        ((self.squares - self.sum.length_squared() / count) / (count - 1.0)).max(0.0)
    }
}

impl Adaptive {
    pub fn new(film: &Film, sampler: Sampler, seed: u64, is_open: bool) -> Adaptive {
        let none = vec![0; film.sources().size()];
        Adaptive {
            sources: film.sources(),
            pattern: Pattern { sampler: of_single_pixels(sampler), seed, is_watched: true },
            samples_per_pixel: sampler.samples_per_pixel,
            passes: passes(sampler.samples_per_pixel, is_open).collect(),
            plan: Plan { begun: 0, variances: None, counts: none.clone(), goals: none },
            squares: film.filter.of_squares(),
        }
    }

    /// True if samples of the pass that has begun are shared out by need.
    fn is_by_need(&self) -> bool {
        self.plan.begun.checked_sub(1).is_some_and(|at| !self.passes[at as usize].is_alike)
    }

    /// The sources that the filter of a pixel reaches, and its weights for their unit squares.
    fn around(&self, [x, y]: [i32; 2]) -> impl Iterator<Item = (usize, f64)> {
        let [across, down] = &self.squares;
        let [reach_x, reach_y] = self.squares.each_ref().map(|weights| (weights.len() / 2) as i32);
        (-reach_y..).zip(down).flat_map(move |(dy, down)| {
            (-reach_x..)
                .zip(across)
                .map(move |(dx, across)| (self.sources.index([x + dx, y + dy]), down * across))
        })
    }

    /// The weight of the estimate of a pixel by the samples of this pass, in samples per pixel: the harmonic mean over the
    /// sources that its filter reaches. It is known before the samples are taken, so that no sample decides its own weight.
    /// 0 if a source has no samples.
    fn count_of(&self, pixel: [i32; 2], so_far: &[u32]) -> f64 {
        let Plan { counts, goals, .. } = &self.plan;
        let (mut all, mut inverse) = (0.0, 0.0);
        for (at, weight) in self.around(pixel) {
            if so_far[at] < goals[at] || goals[at] == counts[at] {
                return 0.0;
            }
            all += weight * weight;
            inverse += weight * weight / f64::from(goals[at] - counts[at]);
        }
        all / inverse
    }
}

/// Bytes of a pixel beside the film: moments, variances, sums of neighbors, and sample counts; and for each of up to 16 threads
/// the levels of a class.
pub(super) fn pixel_bytes(threads: usize) -> usize {
    72 + 8 * threads.min(16)
}

impl Policy for Adaptive {
    /// For each source of the tile.
    type State = Vec<Moments>;
    type Plan = Plan;

    fn begin(&self, tile: &Tile) -> Vec<Moments> {
        vec![Moments::default(); tile.sources.size()]
    }

    fn next(&mut self, film: &Film, states: &[Mutex<Vec<Moments>>]) -> bool {
        let Some(Pass { mean, is_alike }) = self.passes.get(self.plan.begun as usize) else { return false };
        let Plan { begun, variances, counts, goals } = &mut self.plan;
        *begun += 1;
        counts.clone_from(goals);
        if *is_alike {
            goals.fill(*mean);
        } else {
            let sources = self.sources;
            let variances = variances.get_or_insert_with(|| self::variances(film, sources, states));
            *goals = allotted(variances, sources.width(), counts, *mean);
            if self.squares.iter().any(|weights| weights.len() > 1) {
                // Where one source has no sample, no pixel around has an estimate.
                for (goal, count) in goals.iter_mut().zip(counts) {
                    *goal = (*goal).max(*count + 1);
                }
            }
        }
        true
    }

    fn expect(&self, _film: &Film, _states: &[Mutex<Vec<Moments>>], control: &Control) {
        control.expect(self.sources.size() as u64 * u64::from(self.samples_per_pixel));
    }

    fn jobs(&self, tile: &Tile, _moments: &Vec<Moments>) -> Vec<Job> {
        let is_by_need = self.is_by_need();
        let job = |(pixel, count): ([i32; 2], &u32)| {
            let at = self.sources.index(pixel);
            let (before, goal) = (self.plan.counts[at], self.plan.goals[at]);
            // All sources count alike, however many samples they have: else the filter would be another one where noise is uneven.
            let weight = if is_by_need { f64::from((goal - before).max(1)).recip() } else { 1.0 };
            Job { weight, ..Job::new(self.pattern, pixel, *count..goal) }
        };
        tile.sources.pixels().zip(&tile.counts).map(job).collect()
    }

    fn note(&self, jobs: &[Job], moments: &mut Vec<Moments>) {
        for (Job { samples, .. }, moments) in jobs.iter().zip(moments) {
            moments.sum += samples.sum;
            moments.squares += samples.squares;
        }
    }

    fn end(&mut self, film: &Film, _states: &[Mutex<Vec<Moments>>], _is_whole: bool) {
        let (counts, is_by_need) = (counts(film, self.sources), self.is_by_need());
        film.tiles.par_iter().for_each(|tile| {
            let Tile { bounds, sums, pass, .. } = &mut *lock(tile);
            for ((pixel, sum), pass) in bounds.pixels().zip(sums).zip(&mut pass.filtered) {
                let pass = std::mem::take(pass);
                *sum += if is_by_need {
                    let scale = film.scale();
                    Sum::new(scale.units(pass.weighted(scale) * self.count_of(pixel, &counts)))
                } else {
                    pass
                };
            }
        });
    }

    fn plan(&self) -> &Plan {
        &self.plan
    }

    fn resume(&mut self, plan: Plan, film: &Film, states: &[Mutex<Vec<Moments>>], is_begun: bool) -> bool {
        self.plan = plan;
        let Plan { begun, variances, counts, goals } = &self.plan;
        let size = self.sources.size();
        let is_counted = counts.iter().zip(goals).zip(self::counts(film, self.sources));
        [counts.len(), goals.len(), variances.as_ref().map_or(size, Vec::len)] == [size; 3]
            && is_counted.into_iter().all(|((count, goal), so_far)| (*count..=*goal).contains(&so_far))
            && goals.iter().all(|goal| *goal <= most(self.samples_per_pixel))
            && *begun as usize <= self.passes.len()
            && (*begun > 0 || !is_begun)
            && states
                .iter()
                .zip(&film.tiles)
                .all(|(state, tile)| lock(state).len() == lock(tile).sources.size())
    }
}

/// The samples of each source, row by row.
fn counts(film: &Film, sources: Area) -> Vec<u32> {
    let mut counts = vec![0; sources.size()];
    for tile in &film.tiles {
        let tile = lock(tile);
        for (pixel, count) in tile.sources.pixels().zip(&tile.counts) {
            counts[sources.index(pixel)] = *count;
        }
    }
    counts
}

/// The variance of the samples of each source, row by row.
fn variances(film: &Film, sources: Area, states: &[Mutex<Vec<Moments>>]) -> Vec<f64> {
    let mut variances = vec![0.0; sources.size()];
    for (tile, moments) in film.tiles.iter().zip(states) {
        let (tile, moments) = (lock(tile), lock(moments));
        for ((pixel, count), moments) in tile.sources.pixels().zip(&tile.counts).zip(&*moments) {
            variances[sources.index(pixel)] = moments.variance(*count);
        }
    }
    variances
}

/// The samples per pixel on average after a pass over the picture, and whether all pixels have as many.
struct Pass {
    mean: u32,
    is_alike: bool,
}

/// Samples double from pass to pass, so that a picture that is broken off is whole. Where the end is known, all pixels have
/// alike many up to a half of it.
fn passes(samples: u32, is_open: bool) -> impl Iterator<Item = Pass> {
    let alike = match (is_open, samples / LEAST) {
        (true, _) => FIRST.min(samples),
        (false, half) if half < FEWEST => samples,
        (false, half) => half,
    };
    let next = if is_open { samples.min(2 * alike) } else { samples };
    let by_need = doubled(next, samples).filter(move |mean| *mean > alike);
    let first = doubled(1, alike).map(|mean| Pass { mean, is_alike: true });
    first.chain(by_need.map(|mean| Pass { mean, is_alike: false }))
}

/// A pixel gets at least the mean divided by this: neighbors do not know of a light in a single pixel.
const LEAST: u32 = 2;
/// A pixel gets at most the mean times this, so that the noise around one bright sample does not take all.
const MOST: u32 = 64;
/// The most that one pixel takes is the mean of the pixels of the picture over this number, so that no few pixels take all.
const SHARE: usize = 256;
/// The largest distance of a neighbor, in pixels across and down. With fewer neighbors, counts are noisier and errors are
/// larger.
const REACH: usize = 2;
/// The need of pixels whose neighbors show no noise, relative to the largest need.
const QUIET: f64 = 1e-6;
/// The errors of Sobol's samples, squared, fall about with the square of their number: then the sum over pixels of
/// `variance / count^2` is least where the counts are as the cubic roots of the variances.
const EXPONENT: f64 = 1.0 / 3.0;

/// The most samples that a pixel of a picture can have with so many on average: where a filter needs them, one more in each pass.
pub(super) fn most(samples_per_pixel: u32) -> u32 {
    samples_per_pixel.saturating_mul(MOST).saturating_add(u32::BITS)
}

/// Pixels of one class lie so many pixels apart, across and down: further than a neighbor may be.
const APART: usize = REACH + 2;

/// Allots a number of samples to each pixel, row by row, by the variance of its neighbors' samples. Numbers are powers of
/// two, for which patterns are best, and `mean` on average within a few percent. No pixel gets less than its count so far,
/// or less than half of the mean.
///
/// Samples for one pixel are taken from all others. So each class of pixels gets its numbers without using its own samples:
/// the samples of a pixel have no influence on its number.
fn allotted(variances: &[f64], width: usize, counts: &[u32], mean: u32) -> Vec<u32> {
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

/// The pixels so near to one of a row or column.
fn reach(at: usize, end: usize) -> std::ops::RangeInclusive<usize> {
    at.saturating_sub(REACH)..=(at + REACH).min(end - 1)
}

/// The data for sharing samples out by classes.
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

/// The most samples of a pixel over the mean, in a picture of `pixels` pixels. 1 if all pixels get the same number.
fn most_times(pixels: usize) -> u32 {
    MOST.min((pixels / SHARE) as u32).max(1)
}

/// The golden ratio minus 1. Its multiples spread evenly for any width of a picture.
const GOLDEN: f64 = 0.618_033_988_749_895;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Rendered;
    use crate::render::Settings;
    use crate::render::Stop;
    use crate::render::render;
    use crate::testing::scene;
    use lookat_scene::Scene;
    use rand::RngExt;
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;
    use std::ops::ControlFlow;

    #[test]
    fn noise_is_asked_for_after_a_half() {
        let list = |samples, is_open| -> Vec<(u32, bool)> {
            passes(samples, is_open).map(|pass| (pass.mean, pass.is_alike)).collect()
        };
        assert_eq!(list(1, false), [(1, true)]);
        assert_eq!(list(7, false), [(1, true), (2, true), (4, true), (7, true)]);
        assert_eq!(list(8, false), [(1, true), (2, true), (4, true), (8, false)]);
        assert_eq!(list(101, false).last_chunk(), Some(&[(32, true), (50, true), (101, false)]));
        assert_eq!(list(16, true).last_chunk(), Some(&[(8, true), (16, true)]));
        assert_eq!(list(80, true).last_chunk(), Some(&[(16, true), (32, false), (64, false), (80, false)]));
        assert_eq!(list(20, true).last_chunk(), Some(&[(16, true), (20, false)]));
        assert_eq!(passes(1 << 30, true).count(), 31);
    }

    /// A lamp that is seen, and what it lights.
    fn lamp() -> Scene {
        scene(
            "LookAt 0 2 -6 0 1 0 0 1 0 Camera \"perspective\" \"float fov\" 40
            Film \"image\" \"integer xresolution\" 48 \"integer yresolution\" 40
            Sampler \"sobol\" \"integer pixelsamples\" 16 Integrator \"directlighting\" WorldBegin
            AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [20 20 20] Translate 0.3 1.7 0
            Shape \"sphere\" \"float radius\" 0.4 AttributeEnd
            Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [-9 0 -9 -9 0 9 9 0 9 9 0 -9]
            WorldEnd",
        )
    }

    fn picture(seed: u64, adaptive: bool, samples: u32) -> Rendered {
        let mut scene = lamp();
        scene.view.sampler = scene.view.sampler.with_samples(samples);
        let stop = if adaptive { Stop::Adaptive } else { Stop::default() };
        render(&scene, &Settings { seed, stop, ..Settings::default() }, &|_| ControlFlow::Continue(()))
    }

    /// Over 50 pictures: with as many samples the errors are smaller, and nothing is darker or brighter.
    #[test]
    fn errors_are_smaller_and_means_are_kept() {
        const PICTURES: u64 = 50;
        let pixels = |rendered: &Rendered| rendered.image.rgb().unwrap();
        let truth = pixels(&picture(1000, false, 1 << 12));
        // Squared errors, and signed ones in the mean over each picture.
        let errors = |adaptive| -> (f64, Vec<f64>) {
            let mut squared = 0.0;
            let mut signed = Vec::new();
            for seed in 0..PICTURES {
                let found = picture(seed, adaptive, 16);
                let mean = found.statistics.samples as f64 / (48.0 * 40.0);
                assert!((mean - 16.0).abs() < 0.04 * 16.0, "{mean}");
                let off: Vec<f64> =
                    pixels(&found).iter().zip(&truth).map(|(a, b)| f64::from(a[0] - b[0])).collect();
                squared += off.iter().map(|off| off * off).sum::<f64>();
                signed.push(off.iter().sum::<f64>());
            }
            (squared, signed)
        };
        let ((alike, _), (adaptive, signed)) = (errors(false), errors(true));
        assert!(adaptive < 0.4 * alike, "{adaptive} {alike}");
        let mean = signed.iter().sum::<f64>() / PICTURES as f64;
        let variance = signed.iter().map(|off| (off - mean).powi(2)).sum::<f64>() / (PICTURES - 1) as f64;
        assert!(mean.abs() < 4.0 * (variance / PICTURES as f64).sqrt(), "{mean} {variance}");
    }

    /// Allots samples if all pixels have `so_far` samples.
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
