//! Samples where the picture is noisy, so that its mean squared error is small: first some of all pixels alike, then of each
//! as many as the noise of its neighbours asks for.
//!
//! The samples of a pixel have no say in how many more it gets: a pixel that has missed a light by chance would else be
//! taken for done, and such pixels be too dark on average. That is why noise is asked for once: if it were asked for again,
//! a pixel would decide about itself by way of its neighbours, which see the more, the more samples it has brought them.

use glam::Vec3;
use lookat_scene::PixelBounds;
use rayon::prelude::*;

use super::Settings;
use super::control::Meter;
use super::sample::{Context, Pattern, Samples};
use crate::camera::CameraRay;
use crate::film::{Tile, indices, places, tiles};
use crate::integrator::Tracer;
use crate::sampler::SampleStream;

/// Samples of every pixel, at least, before their noise is asked for.
const FEWEST: u32 = 4;
/// Samples of every pixel before their noise is asked for, where it is not known how many there will be.
const FIRST: u32 = 16;
/// A pixel gets at least the mean divided by this: neighbours do not know of a light in a single pixel.
const LEAST: u32 = 2;
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

/// A tile, and what decides about its samples.
struct Part {
    tile: Tile,
    /// For each pixel the sum of the squared lengths of its samples.
    squares: Vec<f64>,
    /// For each pixel how many samples it is to have.
    goals: Vec<u32>,
}

/// Renders all pixels, with the scene's samples per pixel, or the most where there is a time, as their mean.
pub(super) fn render<F>(context: &Context<F>, settings: &Settings) -> Vec<Tile>
where
    F: Fn(&mut Tracer, &CameraRay, &mut SampleStream) -> Vec3 + Sync,
{
    let scene = context.prepared.scene;
    let crop = scene.film.crop;
    let sampler = super::passes::sampler(scene, settings);
    let pattern = Pattern { sampler, seed: settings.seed, is_watched: false };
    let mut parts: Vec<Part> = tiles(crop, false).into_iter().map(Part::new).collect();
    context.control.expect(crop.area() * u64::from(sampler.samples_per_pixel));
    let mut needs = None;
    for Pass { mean, is_alike } in passes(sampler.samples_per_pixel, settings.time.is_some()) {
        if is_alike {
            parts.iter_mut().for_each(|part| part.goals.fill(mean));
        } else {
            let needs = needs.get_or_insert_with(|| needs_of(&parts, crop));
            allot(&mut parts, crop, needs, mean);
        }
        parts.par_iter_mut().for_each(|part| part.sample(context, &pattern));
        if context.control.is_stopped() {
            break;
        }
    }
    parts.into_iter().map(|part| part.tile).collect()
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
    let ends = |from: u32, to: u32| {
        let doubled = std::iter::successors(Some(from), |mean| mean.checked_mul(2));
        doubled.take_while(move |mean| *mean < to).chain((from <= to).then_some(to))
    };
    let next = if is_open { samples.min(2 * alike) } else { samples };
    let by_need = ends(next, samples).filter(move |mean| *mean > alike);
    let first = ends(1, alike).map(|mean| Pass { mean, is_alike: true });
    first.chain(by_need.map(|mean| Pass { mean, is_alike: false }))
}

/// How many samples each pixel should have, relative to others, by those that there are. Row by row.
fn needs_of(parts: &[Part], picture: PixelBounds) -> Vec<f64> {
    let mut variances = vec![0.0; picture.area() as usize];
    for part in parts {
        let pixels = part.tile.pixels.iter().zip(&part.squares);
        for (at, (pixel, squares)) in indices(part.tile.bounds, picture).zip(pixels) {
            variances[at] = pixel.variance(*squares);
        }
    }
    needs(&variances, picture.width() as usize)
}

/// Decides how many samples each pixel is to have.
fn allot(parts: &mut [Part], picture: PixelBounds, needs: &[f64], mean: u32) {
    let mut counts = vec![0; needs.len()];
    for part in &*parts {
        for (at, pixel) in indices(part.tile.bounds, picture).zip(&part.tile.pixels) {
            counts[at] = pixel.count();
        }
    }
    let goals = goals(needs, &counts, mean);
    for part in parts {
        part.goals = indices(part.tile.bounds, picture).map(|at| goals[at]).collect();
    }
}

/// The same, from the variance of the samples of each pixel.
fn needs(variances: &[f64], width: usize) -> Vec<f64> {
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
fn goals(needs: &[f64], counts: &[u32], mean: u32) -> Vec<u32> {
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

impl Part {
    fn new(tile: Tile) -> Part {
        let area = tile.pixels.len();
        Part { tile, squares: vec![0.0; area], goals: vec![0; area] }
    }

    /// Brings all pixels to their goals.
    fn sample<F>(&mut self, context: &Context<F>, pattern: &Pattern)
    where
        F: Fn(&mut Tracer, &CameraRay, &mut SampleStream) -> Vec3,
    {
        let (mut tracer, mut meter) = (context.tracer(), Meter::new(context.control));
        let mut rejected = 0;
        let pixels = self.tile.pixels.iter_mut().zip(&mut self.squares).zip(&self.goals);
        for (((pixel, squares), goal), place) in pixels.zip(places(self.tile.bounds)) {
            if context.control.is_stopped() {
                break;
            }
            let before = Samples::after(*pixel);
            let samples =
                context.sample_all(&mut tracer, &mut meter, pattern, place, pixel.count()..*goal, before);
            *pixel = samples.sum;
            *squares += samples.squares;
            rejected += samples.rejected;
        }
        context.control.add(tracer.rays, rejected);
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;
    use std::path::Path;

    use lookat_scene::{Overrides, Scene, load};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;
    use crate::render::{Rendered, render};

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
        let even = goals(&[1.0; PIXELS], &[8; PIXELS], 24);
        assert_eq!(spent(&even), 24 * PIXELS as u64);
        assert!(even.iter().filter(|goal| [16, 32].contains(*goal)).count() >= PIXELS - 1);
        assert!(even.chunks_exact(64).all(|some| (20 * 64..28 * 64).contains(&spent(some))));
        // By need, as powers of two allow, in between bounds.
        let needs: Vec<f64> = (0..PIXELS).map(|at| (at + 1) as f64).collect();
        let by_need = goals(&needs, &[8; PIXELS], 32);
        assert_eq!(spent(&by_need), 32 * PIXELS as u64);
        assert!(by_need[..PIXELS / 4].iter().all(|goal| *goal == 16));
        assert!(by_need[PIXELS - 99..].iter().all(|goal| *goal == 64));
        let mut spike = vec![1e-6; PIXELS];
        spike[500] = 1.0;
        let spiked = goals(&spike, &[8; PIXELS], 16);
        assert_eq!((spent(&spiked), spiked[500]), (16 * PIXELS as u64, 16 * MOST));
        assert!(spiked.iter().all(|goal| *goal >= 8));
        // What is there already counts.
        let mut counts = vec![16; 1024];
        counts[0] = 500;
        let late = goals(&[1.0; 1024], &counts, 64);
        assert!(spent(&late) == 64 * 1024 && late[0] == 500 && late[1..].iter().all(|goal| *goal >= 32));
        // In small pictures nobody gets more.
        assert_eq!(goals(&[1.0], &[4], 23), [23]);
        assert_eq!(goals(&[1.0, 9.0], &[8, 8], 17), [17, 17]);
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
            let goals = goals(&needs(&variances, SIDE), &[8; SIDE * SIDE], 16);
            let patch = (0..SIDE * SIDE).filter(|at| is_noisy(*at));
            let values = patch.map(|at| (first[at] + hits(goals[at] - 8)) / f64::from(goals[at]));
            means.push(values.sum::<f64>() / PATCH.len().pow(2) as f64);
        }
        let mean = means.iter().sum::<f64>() / f64::from(PICTURES);
        let variance = means.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / f64::from(PICTURES - 1);
        let error = (variance / f64::from(PICTURES)).sqrt();
        assert!(error < 0.01 * 0.05 && (mean - 0.05).abs() < 4.0 * error, "{mean} {error}");
    }

    /// A lamp that is seen, and what it lights.
    fn lamp() -> Scene {
        let text = "LookAt 0 2 -6 0 1 0 0 1 0 Camera \"perspective\" \"float fov\" 40
            Film \"image\" \"integer xresolution\" 48 \"integer yresolution\" 40
            Sampler \"sobol\" \"integer pixelsamples\" 16 Integrator \"directlighting\" WorldBegin
            AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [20 20 20] Translate 0.3 1.7 0
            Shape \"sphere\" \"float radius\" 0.4 AttributeEnd
            Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [-9 0 -9 -9 0 9 9 0 9 9 0 -9]
            WorldEnd";
        load(Path::new("x"), &|_| Ok(text.into()), &Overrides::default()).scene.unwrap()
    }

    fn picture(seed: u64, adaptive: bool, samples: u32) -> Rendered {
        let mut scene = lamp();
        scene.sampler = scene.sampler.with_samples(samples);
        render(&scene, &Settings { seed, adaptive, ..Settings::default() }, &|_| ControlFlow::Continue(()))
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
                assert_eq!(found.statistics.samples, 48 * 40 * 16);
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
}
