//! Errors of whole pictures: V8, V9 and V10.

use std::ops::ControlFlow;

use lookat_scene::{Sampler, SamplerKind};

use crate::coverage::{Known, lens, plain};
use crate::stability::prelude::*;

/// The samplers of the renderer, and the scrambles of each picture, by which the slope of the first is exact to about 0.006. The
/// first is judged by its slope, all by the correlation of their errors.
const SAMPLERS: [(&str, SamplerKind, u64); 3] = [
    ("lookat sobol", SamplerKind::SOBOL, 8),
    ("lookat stratified", SamplerKind::Stratified { cells: [1, 1], jitter: true }, FEW_SEEDS),
    ("lookat random", SamplerKind::Random, FEW_SEEDS),
];

const FEW_SEEDS: u64 = 2;

/// A row for each sampler, of pixels, an error and a remark. `judged` makes of the errors what lookat is judged by.
fn by_sampler(
    judged: impl Fn([f64; 3]) -> f64,
    error: impl Fn(SamplerKind, u64) -> (u64, f64, Option<String>),
) -> Found {
    let measured = SAMPLERS.map(|(_, kind, seeds)| error(kind, seeds));
    let tally = |tried, error: f64| Tally { tried, failed: u64::from(error.is_nan()), worst: Some(error) };
    let mut found = Found::own(None, tally(measured[0].0, judged(measured.each_ref().map(|row| row.1))));
    for ((name, ..), (tried, error, remark)) in SAMPLERS.iter().zip(measured) {
        found.add(name, None, tally(tried, error));
        found.remarks.extend(remark.map(|remark| format!("{name}: {remark}")));
    }
    found
}

/// Green, pixel by pixel.
fn picture(scene: &Scene, seed: u64) -> Vec<f64> {
    let settings = lookat_render::Settings { seed, ..Default::default() };
    let image = lookat_render::render(scene, &settings, &|_| ControlFlow::Continue(())).image;
    image.rgb().unwrap_or_default().iter().map(|pixel| f64::from(pixel[1])).collect()
}

/// The root of the mean square of the errors.
fn rms(errors: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = errors.fold((0.0, 0.0), |(sum, count), error| (sum + error * error, count + 1.0));
    (sum / count).sqrt()
}

/// The scene with another sampler.
fn sampled(scene: &Scene, kind: SamplerKind, samples: u32) -> Scene {
    let mut scene = scene.clone();
    scene.view.sampler = Sampler { kind, samples_per_pixel: 1 }.with_samples(samples);
    scene
}

/// Pixels on a side of the edge out of focus.
const SIDE: u32 = 16;

/// The pixels of a picture that are neither wholly bright nor wholly dark, with their values.
fn mixed(known: &Known) -> Vec<(usize, f64)> {
    let pixels = known.values.iter().map(|value| value[1]).enumerate();
    pixels.filter(|(_, share)| (0.02..0.98).contains(share)).collect()
}

/// The error of the mixed pixels of the edge, over all scrambles.
fn edge_error(edge: &Known, kind: SamplerKind, samples: u32, seeds: u64) -> f64 {
    let scene = sampled(&edge.scene, kind, samples);
    rms((0..seeds).flat_map(|seed| {
        let pixels = picture(&scene, seed);
        mixed(edge).into_iter().map(move |(at, share)| pixels[at] - share)
    }))
}

const COUNTS: [u32; 9] = [16, 32, 64, 128, 256, 512, 1024, 2048, 4096];

pub(super) fn slopes(_: &Effort) -> Found {
    let edge = lens(SIDE);
    by_sampler(
        |slopes| slopes[0],
        |kind, seeds| {
            let errors = COUNTS.map(|samples| edge_error(&edge, kind, samples, seeds));
            let remark = format!("RMSE {:.2e} at 16 samples, {:.2e} at 4096", errors[0], errors[8]);
            (mixed(&edge).len() as u64 * seeds * COUNTS.len() as u64, slope(&errors), Some(remark))
        },
    )
}

/// Of the line through the logarithms, by least squares. Those of the counts are evenly spaced.
fn slope(errors: &[f64; 9]) -> f64 {
    let from_middle = [-4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0];
    let product: f64 = from_middle.iter().zip(errors).map(|(x, error)| x * error.log2()).sum();
    product / from_middle.iter().map(|x| x * x).sum::<f64>()
}

pub(super) fn thousand(_: &Effort) -> Found {
    let edge = lens(SIDE);
    by_sampler(
        |ratios| ratios[0],
        |kind, _| {
            let edges = [1000, 1024].map(|samples| edge_error(&edge, kind, samples, FEW_SEEDS));
            let smooth = [1000, 1024].map(|samples| {
                let pixels = picture(&sampled(&plain(WIDE).scene, kind, samples), 0);
                rms(pixels.into_iter().map(|x| x - 0.25))
            });
            let ratios = [edges[0] / edges[1], smooth[0] / smooth[1]];
            let remark = format!("{:.2} at an edge, {:.2} under a smooth light", ratios[0], ratios[1]);
            let tried = mixed(&edge).len() as u64 * FEW_SEEDS + u64::from(WIDE * WIDE);
            (tried, ratios[0].max(ratios[1]), Some(remark))
        },
    )
}

/// Pixels on a side of the pictures that show one point.
const WIDE: u32 = 24;

/// Samples of the pictures whose errors are compared.
const FEW: u32 = 16;

/// Pictures whose errors are compared: chance alone gives correlations of about 0.007.
const PICTURES: u64 = 32;

pub(super) fn neighbors(_: &Effort) -> Found {
    by_sampler(
        |correlations| correlations.into_iter().fold(f64::NEG_INFINITY, f64::max),
        |kind, _| {
            let scene = sampled(&plain(WIDE).scene, kind, FEW);
            let pictures: Vec<Vec<f64>> = (0..PICTURES).map(|seed| picture(&scene, seed)).collect();
            let error = correlation(&pictures, 1).max(correlation(&pictures, WIDE as usize));
            (u64::from(WIDE * WIDE) * 2 * PICTURES, error, None)
        },
    )
}

/// Of the errors of pixels and those `step` further on. Errors that cancel have one below 0.
fn correlation(pictures: &[Vec<f64>], step: usize) -> f64 {
    let (mut products, mut squares) = (0.0, 0.0);
    for pixels in pictures {
        let mean = pixels.iter().sum::<f64>() / pixels.len() as f64;
        let error = |at: usize| pixels[at] - mean;
        for at in (0..pixels.len() - step).filter(|at| step > 1 || (at + 1) % WIDE as usize != 0) {
            products += error(at) * error(at + step);
            squares += 0.5 * (error(at).powi(2) + error(at + step).powi(2));
        }
    }
    products / squares
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;

    use super::*;
    use crate::stability::random::{between, chance};

    #[test]
    fn slope_of_a_power_is_its_exponent() {
        let errors = COUNTS.map(|count| 3.0 * f64::from(count).powf(-0.75));
        assert!((slope(&errors) + 0.75).abs() < 1e-12);
    }

    #[test]
    fn correlation_tells_copies_from_noise() {
        let mut random = Pcg64Mcg::seed_from_u64(8);
        let side = WIDE as usize;
        let noise: Vec<f64> = (0..side * side).map(|_| between(&mut random, -1.0, 1.0)).collect();
        assert!(
            [1, side].into_iter().all(|step| correlation(std::slice::from_ref(&noise), step).abs() < 0.08)
        );
        let mut last = 0.0;
        let pairs: Vec<f64> = (0..side * side)
            .map(|_| {
                last = if chance(&mut random, 0.5) { between(&mut random, -1.0, 1.0) } else { last };
                last
            })
            .collect();
        assert!((correlation(&[pairs], 1) - 0.5).abs() < 0.08);
    }

    /// The picture of many samples is the closed form.
    #[test]
    fn pictures_are_those_of_the_closed_forms() {
        let edge = lens(SIDE);
        assert!(mixed(&edge).len() > 50);
        assert!(edge_error(&edge, SamplerKind::SOBOL, 256, 1) < 0.02);
    }
}
