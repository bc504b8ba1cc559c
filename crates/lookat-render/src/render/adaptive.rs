//! Samples where the picture is noisy, so that its mean squared error is small: first some of all pixels alike, then of each
//! as many as the noise of its neighbors asks for.
//!
//! The samples of a pixel have no say in how many more it gets: a pixel that has missed a light by chance would else be
//! taken for done, and such pixels be too dark on average. That is why noise is asked for once: if it were asked for again,
//! a pixel would decide about itself by way of its neighbors, which see the more, the more samples it has brought them.

mod allotment;

use lookat_scene::{PixelBounds, Sampler};

use super::control::Control;
use super::fixed::doubled;
use super::rounds::Policy;
use super::sample::{Job, Pattern};
use crate::film::{Film, Tile, indices, lock, places};
use allotment::{LEAST, allotted};

/// Samples of every pixel, at least, before their noise is asked for.
const FEWEST: u32 = 4;
/// Samples of every pixel before their noise is asked for, where it is not known how many there will be.
const FIRST: u32 = 16;

/// The scene's samples per pixel, or the most where there is a time, as their mean.
pub(super) struct Adaptive {
    crop: PixelBounds,
    pattern: Pattern,
    passes: std::vec::IntoIter<Pass>,
    /// The variance of the samples of each pixel, row by row. `None` before the first pass that needs it.
    variances: Option<Vec<f64>>,
    /// How many samples each pixel is to have, row by row; none before the first pass.
    goals: Vec<u32>,
}

impl Adaptive {
    pub fn new(crop: PixelBounds, sampler: Sampler, seed: u64, is_open: bool) -> Adaptive {
        let passes: Vec<Pass> = passes(sampler.samples_per_pixel, is_open).collect();
        Adaptive {
            crop,
            pattern: Pattern { sampler, seed, is_watched: true },
            passes: passes.into_iter(),
            variances: None,
            goals: Vec::new(),
        }
    }
}

/// Bytes of a pixel beside the film: squares, variances, sums of neighbors, and sample counts; and for each of up to 16 threads
/// the levels of a class.
pub(super) fn pixel_bytes(threads: usize) -> usize {
    44 + 8 * threads.min(16)
}

impl Policy for Adaptive {
    /// For each pixel the sum of the squared lengths of its samples.
    type State = Vec<f64>;

    fn begin(&self, tile: &Tile) -> Vec<f64> {
        vec![0.0; tile.bounds.area() as usize]
    }

    fn next(&mut self, film: &Film, states: &mut [Vec<f64>], control: &Control) -> bool {
        let crop = self.crop;
        if self.goals.is_empty() {
            control.expect(crop.area() * u64::from(self.pattern.sampler.samples_per_pixel));
            self.goals = vec![0; crop.area() as usize];
        }
        let Some(Pass { mean, is_alike }) = self.passes.next().filter(|_| !control.is_stopped()) else {
            return false;
        };
        if is_alike {
            self.goals.fill(mean);
        } else {
            let variances = self.variances.get_or_insert_with(|| variances(film, states));
            self.goals = allotted(variances, crop.width() as usize, &self.goals, mean);
        }
        true
    }

    fn jobs(&self, tile: &Tile, _squares: &mut Vec<f64>) -> Vec<Job> {
        let goals = indices(tile.bounds, self.crop).map(|at| self.goals[at]);
        let job = |(at, (place, goal))| Job::new(self.pattern, place, tile.count(at)..goal);
        places(tile.bounds).zip(goals).enumerate().map(job).collect()
    }

    fn add(&self, jobs: &[Job], _film: &Film, tile: &mut Tile, squares: &mut Vec<f64>) {
        for (at, (Job { samples, .. }, squares)) in jobs.iter().zip(squares).enumerate() {
            tile.add(at, &samples.pixel);
            *squares += samples.squares;
        }
    }
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

/// The variance of the samples of each pixel, row by row.
fn variances(film: &Film, states: &[Vec<f64>]) -> Vec<f64> {
    let mut variances = vec![0.0; film.of.crop.area() as usize];
    for (tile, squares) in film.tiles.iter().zip(states) {
        let tile = lock(tile);
        for ((at, pixel), squares) in indices(tile.bounds, film.of.crop).zip(tile.pixels()).zip(squares) {
            variances[at] = pixel.variance(*squares, film.scale());
        }
    }
    variances
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use lookat_scene::Scene;

    use super::*;
    use crate::render::{Rendered, Settings, Stop, render};
    use crate::testing::scene;

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
}
