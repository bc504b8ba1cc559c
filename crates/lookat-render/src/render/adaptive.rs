//! Samples where the picture is noisy, so that its mean squared error is small: first some of all pixels alike, then of each
//! as many as the noise of its neighbours asks for.
//!
//! The samples of a pixel have no say in how many more it gets: a pixel that has missed a light by chance would else be
//! taken for done, and such pixels be too dark on average.

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
const FIRST: u32 = 4;
/// A pixel gets at least the mean divided by this.
const LEAST: u32 = 4;
/// A pixel gets at most the mean times this, so that the noise around one bright sample does not take all.
const MOST: u32 = 64;
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
    for Pass { mean, is_alike } in passes(sampler.samples_per_pixel, settings.time.is_some()) {
        match is_alike {
            true => parts.iter_mut().for_each(|part| part.goals.fill(mean)),
            false => allot(&mut parts, crop, mean),
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

/// Samples double from pass to pass, so that a picture that is broken off is whole. Where the end is known, noise is asked
/// for once, after a quarter: then what decides about a pixel is independent of its samples. Else from pass to pass, so that
/// they may depend on each other by way of the neighbours, a little.
fn passes(samples: u32, is_open: bool) -> impl Iterator<Item = Pass> {
    let alike = if is_open { FIRST } else { (samples / LEAST).max(FIRST) };
    let ends = std::iter::successors(Some(1_u32), |mean| mean.checked_mul(2));
    ends.take_while(move |mean| *mean < samples && (is_open || *mean <= alike))
        .chain([samples])
        .map(move |mean| Pass { mean, is_alike: mean <= alike || mean < 2 * FIRST })
}

/// Decides how many samples each pixel is to have.
fn allot(parts: &mut [Part], picture: PixelBounds, mean: u32) {
    let mut variances = vec![0.0; picture.area() as usize];
    let mut counts = vec![0; variances.len()];
    for part in &*parts {
        let pixels = part.tile.pixels.iter().zip(&part.squares);
        for (at, (pixel, squares)) in indices(part.tile.bounds, picture).zip(pixels) {
            (variances[at], counts[at]) = (pixel.variance(*squares), pixel.count());
        }
    }
    let goals = goals(&needs(&variances, picture.width() as usize), &counts, mean);
    for part in parts {
        part.goals = indices(part.tile.bounds, picture).map(|at| goals[at]).collect();
    }
}

/// How many samples each pixel should have, relative to others: by the variance of the samples of its neighbours. Row by
/// row.
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

/// How many samples each pixel is to have, in proportion to its need but with powers of two, for which patterns are best;
/// `mean` on average. None has less than its count so far, or than a quarter of the mean.
fn goals(needs: &[f64], counts: &[u32], mean: u32) -> Vec<u32> {
    // Pixels that need alike do not all double at once.
    let jitter = |at: usize| 0.98 + 0.04 * (at as f64 * GOLDEN).fract();
    let levels: Vec<f64> = needs.iter().enumerate().map(|(at, need)| (need * jitter(at)).log2()).collect();
    let least = (mean / LEAST + 1).next_power_of_two() / 2;
    let goal = |at: usize, scale: f64| {
        let wanted = (scale + levels[at]).round().clamp(0.0, 31.0).exp2() as u32;
        wanted.min(mean.saturating_mul(MOST)).max(least).max(counts[at])
    };
    let total = needs.len() as u64 * u64::from(mean);
    let sum = |scale: f64| (0..needs.len()).map(|at| u64::from(goal(at, scale))).sum::<u64>();
    // At the first scale nobody gets more than the least, at the other all get the most.
    let (lowest, highest) = levels
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), level| (a.min(*level), b.max(*level)));
    let (mut low, mut high) = (-highest - 1.0, 33.0 - lowest);
    for _ in 0..64 {
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

    use super::*;
    use crate::render::{Rendered, render};

    #[test]
    fn noise_is_asked_for_after_a_quarter() {
        let list = |samples, is_open| -> Vec<(u32, bool)> {
            passes(samples, is_open).map(|pass| (pass.mean, pass.is_alike)).collect()
        };
        assert_eq!(list(1, false), [(1, true)]);
        assert_eq!(list(7, false), [(1, true), (2, true), (4, true), (7, true)]);
        assert_eq!(list(16, false), [(1, true), (2, true), (4, true), (16, false)]);
        assert_eq!(list(100, false).last_chunk(), Some(&[(8, true), (16, true), (100, false)]));
        assert_eq!(list(20, true).last_chunk(), Some(&[(4, true), (8, false), (16, false), (20, false)]));
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
        let spent = |goals: &[u32]| goals.iter().map(|goal| u64::from(*goal)).sum::<u64>();
        // Alike: as powers of two allow, and mixed well.
        let even = goals(&[1.0; 1000], &[4; 1000], 24);
        assert_eq!(spent(&even), 24_000);
        assert!(even.iter().filter(|goal| [16, 32].contains(*goal)).count() >= 999);
        assert!(even.chunks(50).all(|some| (20 * 50..28 * 50).contains(&spent(some))));
        // By need, as powers of two allow, in between bounds.
        let needs: Vec<f64> = (0..1000).map(|at| f64::from(at + 1)).collect();
        let by_need = goals(&needs, &[8; 1000], 32);
        assert_eq!(spent(&by_need), 32_000);
        assert!(by_need[..100].iter().all(|goal| *goal == 8));
        assert!(by_need[990..].iter().all(|goal| *goal == 64));
        let mut spike = vec![1e-6; 1000];
        spike[500] = 1.0;
        let spiked = goals(&spike, &[4; 1000], 16);
        assert_eq!((spent(&spiked), spiked[500]), (16_000, 16 * MOST));
        assert!(spiked.iter().all(|goal| *goal >= 4));
        // What is there already counts.
        let late = goals(&[1.0; 4], &[100, 8, 8, 8], 32);
        assert_eq!(spent(&late), 128);
        assert!(late[0] == 100 && late[1..].iter().all(|goal| *goal >= 8));
        assert_eq!(goals(&[1.0], &[4], 23), [23]);
    }

    /// A lamp that is seen, and what it lights.
    fn lamp() -> Scene {
        let text = "LookAt 0 2 -6 0 1 0 0 1 0 Camera \"perspective\" \"float fov\" 40
            Film \"image\" \"integer xresolution\" 24 \"integer yresolution\" 20
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

    /// Over 100 pictures: with as many samples the errors are smaller, and nothing is darker or brighter.
    #[test]
    fn errors_are_smaller_and_means_are_kept() {
        const PICTURES: u64 = 100;
        let pixels = |rendered: &Rendered| rendered.image.rgb().unwrap();
        let truth = pixels(&picture(1000, false, 1 << 14));
        // Squared errors, and signed ones in the mean over each picture.
        let errors = |adaptive| -> (f64, Vec<f64>) {
            let mut squared = 0.0;
            let mut signed = Vec::new();
            for seed in 0..PICTURES {
                let found = picture(seed, adaptive, 16);
                assert_eq!(found.statistics.samples, 24 * 20 * 16);
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
