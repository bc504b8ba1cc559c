//! Errors of whole pictures: V8, V9 and V10.

use std::ops::ControlFlow;

use glam::DVec2;
use lookat_scene::{SamplerKind, Scene};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::lens;
use crate::stability::case::{Effort, Found, LOOKAT, Row};
use crate::stability::random::between;

/// The samplers of the renderer. The first is judged by its slope, all by the correlation of their errors.
const SAMPLERS: [(&str, SamplerKind); 4] = [
    ("lookat sobol", SamplerKind::Sobol),
    ("lookat halton", SamplerKind::Halton { pixel_center: false }),
    ("lookat stratified", SamplerKind::Stratified { cells: [1, 1], jitter: true }),
    ("lookat random", SamplerKind::Random),
];

/// Scrambles of each picture of the sampler that is judged, so that the slope is exact to about 0.006, and of others.
const SEEDS: [u64; 2] = [8, 2];

fn row(method: &'static str, tried: u64, worst: f64) -> Row {
    Row { method, at: None, tried, failed: u64::from(worst.is_nan()), worst: Some(worst) }
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

/// The error of the mixed pixels of the edge, over all scrambles.
fn edge_error(edge: &Scene, mixed: &[([u32; 2], f64)], kind: SamplerKind, samples: u32, seeds: u64) -> f64 {
    let scene = lens::sampled(edge, kind, samples);
    rms((0..seeds).flat_map(|seed| {
        let pixels = picture(&scene, seed);
        let error = move |([x, y], share): &([u32; 2], f64)| pixels[(y * lens::SIDE + x) as usize] - share;
        mixed.iter().map(error).collect::<Vec<f64>>()
    }))
}

const COUNTS: [u32; 9] = [16, 32, 64, 128, 256, 512, 1024, 2048, 4096];

pub(super) fn slopes(_: &Effort) -> Found {
    let (edge, mixed) = (lens::edge(), lens::mixed());
    let mut found = Found::default();
    for (at, (name, kind)) in SAMPLERS.into_iter().enumerate() {
        let seeds = SEEDS[at.min(1)];
        let errors = COUNTS.map(|samples| edge_error(&edge, &mixed, kind, samples, seeds));
        let slope = slope(&errors);
        let tried = mixed.len() as u64 * seeds * COUNTS.len() as u64;
        if at == 0 {
            found.rows.push(row(LOOKAT, tried, slope));
        }
        found.rows.push(row(name, tried, slope));
        found
            .remarks
            .push(format!("{name}: RMSE {:.2e} at 16 samples, {:.2e} at 4096", errors[0], errors[8]));
    }
    let errors =
        COUNTS.map(|samples| rms(mixed.iter().map(|(pixel, share)| reused(*pixel, samples) - share)));
    found.rows.push(row("one pair for pixel and lens", mixed.len() as u64, slope(&errors)));
    found
}

/// Of the line through the logarithms, by least squares.
fn slope(errors: &[f64; 9]) -> f64 {
    let x = COUNTS.map(|count| f64::from(count).ln());
    let y = errors.map(f64::ln);
    let mean = |v: &[f64; 9]| v.iter().sum::<f64>() / 9.0;
    let (x_mean, y_mean) = (mean(&x), mean(&y));
    let product: f64 = x.iter().zip(&y).map(|(x, y)| (x - x_mean) * (y - y_mean)).sum();
    product / x.iter().map(|x| (x - x_mean).powi(2)).sum::<f64>()
}

/// A point of the unit disk (Shirley and Chiu, "A Low Distortion Map Between Disk and Square", 1997).
fn disk(u: DVec2) -> DVec2 {
    let p = u * 2.0 - 1.0;
    if p == DVec2::ZERO {
        return p;
    }
    let quarter = std::f64::consts::FRAC_PI_4;
    let (r, angle) = if p.x.abs() > p.y.abs() {
        (p.x, quarter * p.y / p.x)
    } else {
        (p.y, 2.0 * quarter - quarter * p.x / p.y)
    };
    DVec2::from_angle(angle) * r
}

/// A common mistake: the same two numbers choose the place in the pixel and on the lens.
fn reused(pixel: [u32; 2], samples: u32) -> f64 {
    let mut random = Pcg64Mcg::seed_from_u64(u64::from(pixel[0]) << 20 | u64::from(pixel[1]) << 8 | 7);
    let mut number = || between(&mut random, 0.0, 1.0);
    let bright = (0..samples).filter(|_| {
        let u = DVec2::new(number(), number());
        lens::is_bright(pixel, u, disk(u))
    });
    bright.count() as f64 / f64::from(samples)
}

pub(super) fn thousand(_: &Effort) -> Found {
    let (edge, mixed) = (lens::edge(), lens::mixed());
    let mut found = Found::default();
    for (at, (name, kind)) in SAMPLERS.into_iter().enumerate() {
        let edges = [1000, 1024].map(|samples| edge_error(&edge, &mixed, kind, samples, SEEDS[1]));
        let smooth = [1000, 1024].map(|samples| {
            let pixels = picture(&lens::sampled(&sky(), kind, samples), 0);
            rms(pixels.into_iter().map(|x| x - 0.25))
        });
        let ratios = [edges[0] / edges[1], smooth[0] / smooth[1]];
        let tried = mixed.len() as u64 * SEEDS[1] + u64::from(WIDE * WIDE);
        if at == 0 {
            found.rows.push(row(LOOKAT, tried, ratios[0].max(ratios[1])));
        }
        found.rows.push(row(name, tried, ratios[0].max(ratios[1])));
        found
            .remarks
            .push(format!("{name}: {:.2} at an edge, {:.2} under a smooth light", ratios[0], ratios[1]));
    }
    found
}

/// Pixels on a side of the pictures that show one point.
const WIDE: u32 = 24;

/// A point of a floor under a large sphere light, near it: half of the cosine-weighed sky, of radiance one, at half
/// reflectance. All pixels show it.
fn sky() -> Scene {
    // The sine of half the angle that the sphere covers, squared, is the form factor.
    crate::text_scene::scene(&format!(
        "LookAt 2 0.5 0  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 1e-6
         Film \"image\" \"integer xresolution\" {WIDE} \"integer yresolution\" {WIDE}
         Sampler \"sobol\" Integrator \"directlighting\" WorldBegin
         AttributeBegin Translate 0 4 0 AreaLightSource \"diffuse\" Shape \"sphere\" \"float radius\" {} AttributeEnd
         Material \"matte\" \"rgb Kd\" [0.5 0.5 0.5]
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [-9 0 -9 9 0 -9 9 0 9 -9 0 9] WorldEnd",
        4.0 * 0.5_f64.sqrt()
    ))
}

/// Samples of the pictures whose errors are compared.
const FEW: u32 = 16;

/// Pictures whose errors are compared: chance alone gives correlations of about 0.007.
const PICTURES: u64 = 32;

pub(super) fn neighbors(_: &Effort) -> Found {
    let mut found = Found::default();
    let mut largest: f64 = 0.0;
    let mut rows = Vec::new();
    let tried = u64::from(WIDE * WIDE) * 2 * PICTURES;
    for (name, kind) in SAMPLERS {
        let scene = lens::sampled(&sky(), kind, FEW);
        let pictures: Vec<Vec<f64>> = (0..PICTURES).map(|seed| picture(&scene, seed)).collect();
        let worst = correlation(&pictures, 1).max(correlation(&pictures, WIDE as usize));
        largest = largest.max(worst);
        rows.push(row(name, tried, worst));
    }
    found.rows.push(row(LOOKAT, tried, largest));
    found.rows.extend(rows);
    found.rows.push(row("the same points in each pixel", tried, shared_points()));
    found
}

/// Of the errors of pixels and those `step` further on, without sign.
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
    (products / squares).abs()
}

/// A common mistake: errors of pixels next to each other along an edge, if all have the same random points.
fn shared_points() -> f64 {
    let mixed = lens::mixed();
    let (mut products, mut squares) = (0.0, 0.0);
    for seed in 0..100 {
        let mut random = Pcg64Mcg::seed_from_u64(3000 + seed);
        let mut number = || between(&mut random, 0.0, 1.0);
        let points: Vec<[DVec2; 2]> = (0..FEW)
            .map(|_| [DVec2::new(number(), number()), disk(DVec2::new(number(), number()))])
            .collect();
        let error = |pixel: [u32; 2], share: f64| {
            let bright = points.iter().filter(|[film, lens]| lens::is_bright(pixel, *film, *lens));
            bright.count() as f64 / f64::from(FEW) - share
        };
        for ([x, y], share) in &mixed {
            let Some((_, other)) = mixed.iter().find(|(pixel, _)| *pixel == [x + 1, *y]) else { continue };
            let (here, there) = (error([*x, *y], *share), error([x + 1, *y], *other));
            products += here * there;
            squares += 0.5 * (here * here + there * there);
        }
    }
    (products / squares).abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::random::chance;

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
        assert!([1, side].into_iter().all(|step| correlation(std::slice::from_ref(&noise), step) < 0.08));
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
        let mixed = lens::mixed();
        assert!(mixed.len() > 50);
        assert!(edge_error(&lens::edge(), &mixed, SamplerKind::Sobol, 256, 1) < 0.02);
        let pixels = picture(&lens::sampled(&sky(), SamplerKind::Sobol, 64), 0);
        let mean = pixels.iter().sum::<f64>() / pixels.len() as f64;
        assert!((mean - 0.25).abs() < 1e-3, "{mean}");
    }
}
