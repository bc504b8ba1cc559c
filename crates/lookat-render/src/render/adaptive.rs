//! Samples where the picture is noisy, so that its mean squared error is small: first some of all pixels alike, then of each
//! as many as the noise of its neighbors asks for.
//!
//! The samples of a pixel have no say in how many more it gets: a pixel that has missed a light by chance would else be
//! taken for done, and such pixels be too dark on average. That is why noise is asked for once: if it were asked for again,
//! a pixel would decide about itself by way of its neighbors, which see the more, the more samples it has brought them.

mod allotment;

use glam::DVec3;
use lookat_scene::Sampler;
use rayon::prelude::*;

use super::control::Control;
use super::fixed::doubled;
use super::rounds::Policy;
use super::sample::{Job, Pattern};
use crate::film::{Area, Film, Sum, Tile, lock};
use crate::sampler::of_single_pixels;
use allotment::{LEAST, allotted};

/// Samples of every pixel, at least, before their noise is asked for.
const FEWEST: u32 = 4;
/// Samples of every pixel before their noise is asked for, where it is not known how many there will be.
const FIRST: u32 = 16;

/// The scene's samples per pixel, or the most where there is a time, as their mean.
pub(super) struct Adaptive {
    /// Where samples are taken.
    sources: Area,
    pattern: Pattern,
    samples_per_pixel: u32,
    passes: std::vec::IntoIter<Pass>,
    /// Whether samples of this pass are shared out by need.
    is_by_need: bool,
    /// The variance of the samples of each source, row by row. `None` before the first pass that needs it.
    variances: Option<Vec<f64>>,
    /// How many samples each source has, and how many after this pass, row by row; none before the first pass.
    counts: Vec<u32>,
    goals: Vec<u32>,
    /// The filter's weights for the unit squares around a pixel, across and down.
    squares: [Vec<f64>; 2],
}

/// What the samples of a source have shown.
#[derive(Default, Clone, Copy)]
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
        let passes: Vec<Pass> = passes(sampler.samples_per_pixel, is_open).collect();
        Adaptive {
            sources: film.sources(),
            pattern: Pattern { sampler: of_single_pixels(sampler), seed, is_watched: true },
            samples_per_pixel: sampler.samples_per_pixel,
            passes: passes.into_iter(),
            is_by_need: false,
            variances: None,
            counts: Vec::new(),
            goals: Vec::new(),
            squares: film.filter.of_squares(),
        }
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

    /// How much the estimate of a pixel by the samples of this pass counts beside earlier ones, in samples per pixel: their harmonic mean
    /// over the sources that its filter reaches. It is known before the samples are taken, so that none decides how much it counts. 0
    /// where a source has no samples.
    fn count_of(&self, place: [i32; 2], counts: &[u32]) -> f64 {
        let (mut all, mut inverse) = (0.0, 0.0);
        for (at, weight) in self.around(place) {
            if counts[at] < self.goals[at] || self.goals[at] == self.counts[at] {
                return 0.0;
            }
            all += weight * weight;
            inverse += weight * weight / f64::from(self.goals[at] - self.counts[at]);
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

    fn begin(&self, tile: &Tile) -> Vec<Moments> {
        vec![Moments::default(); tile.sources.size()]
    }

    fn next(&mut self, film: &Film, states: &mut [Vec<Moments>], control: &Control) -> bool {
        let size = self.sources.size();
        if self.goals.is_empty() {
            control.expect(size as u64 * u64::from(self.samples_per_pixel));
            self.goals = vec![0; size];
        }
        let Some(Pass { mean, is_alike }) = self.passes.next().filter(|_| !control.is_stopped()) else {
            return false;
        };
        self.counts.clone_from(&self.goals);
        self.is_by_need = !is_alike;
        if is_alike {
            self.goals.fill(mean);
        } else {
            let sources = self.sources;
            let variances = self.variances.get_or_insert_with(|| variances(film, sources, states));
            self.goals = allotted(variances, sources.width(), &self.counts, mean);
            if self.squares.iter().any(|weights| weights.len() > 1) {
                // Where one source has no sample, no pixel around has an estimate.
                self.goals
                    .iter_mut()
                    .zip(&self.counts)
                    .for_each(|(goal, count)| *goal = (*goal).max(count + 1));
            }
        }
        true
    }

    fn jobs(&self, tile: &Tile, _moments: &Vec<Moments>) -> Vec<Job> {
        let job = |place| {
            let at = self.sources.index(place);
            let indices = self.counts[at]..self.goals[at];
            // All sources count alike, however many samples they have: else the filter would be another one where noise is uneven.
            let weight = if self.is_by_need { f64::from(indices.len().max(1) as u32).recip() } else { 1.0 };
            Job { weight, ..Job::new(self.pattern, place, indices) }
        };
        tile.sources.places().map(job).collect()
    }

    fn note(&self, jobs: &[Job], _tile: &Tile, moments: &mut Vec<Moments>) {
        for (Job { samples, .. }, moments) in jobs.iter().zip(moments) {
            moments.sum += samples.sum;
            moments.squares += samples.squares;
        }
    }

    fn end(&mut self, film: &Film, _states: &mut [Vec<Moments>], _is_whole: bool) {
        let counts = counts(film, self.sources);
        film.tiles.par_iter().for_each(|tile| {
            let Tile { bounds, sums, pass, .. } = &mut *lock(tile);
            for ((place, sum), pass) in bounds.places().zip(sums).zip(pass) {
                let pass = std::mem::take(pass);
                *sum += match self.is_by_need {
                    false => pass,
                    true => {
                        Sum::new(pass.weighted(film.scale()) * self.count_of(place, &counts), film.scale())
                    }
                };
            }
        });
    }
}

/// The samples of each source, row by row.
fn counts(film: &Film, sources: Area) -> Vec<u32> {
    let mut counts = vec![0; sources.size()];
    for tile in &film.tiles {
        let tile = lock(tile);
        tile.sources
            .places()
            .zip(&tile.counts)
            .for_each(|(place, count)| counts[sources.index(place)] = *count);
    }
    counts
}

/// The variance of the samples of each source, row by row.
fn variances(film: &Film, sources: Area, states: &[Vec<Moments>]) -> Vec<f64> {
    let mut variances = vec![0.0; sources.size()];
    for (tile, moments) in film.tiles.iter().zip(states) {
        let tile = lock(tile);
        for ((place, count), moments) in tile.sources.places().zip(&tile.counts).zip(moments) {
            variances[sources.index(place)] = moments.variance(*count);
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
