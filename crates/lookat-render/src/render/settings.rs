//! Settings of a rendering that are not part of the scene, and when it stops.

use std::time::{Duration, Instant};

use glam::{DVec3, Vec3};
use lookat_scene::{Sampler, SamplerKind, View};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::sample::SampleBounds;
use super::{DARK, adaptive, target};
use crate::film::{FilmSums, Keeps, REPLICATES, pixel_bytes};
use crate::number::luminance;
use crate::render::layers::Layers;
use crate::threads::threads;

/// Settings of a rendering that are not part of the scene.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Settings {
    /// Chooses the random numbers. The same scene, seed and version give the same picture. Default 0.
    pub seed: u64,
    /// The number of separate threads for this rendering; fewer if the system refuses some. 0, the default, uses the threads of the
    /// process: see [`crate::start_threads`]. The number does not change the picture.
    pub threads: usize,
    /// The stopping rule, which decides which samples are taken and when there are enough.
    pub stop: Stop,
    /// The layers of the picture beside its colors. They take a pass over first hits after the picture, with the samples per
    /// pixel of the scene. An interrupted picture has no layers. Default: none.
    pub layers: Layers,
    /// True to keep the sums of the film as [`Rendered::sums`](crate::Rendered::sums). Default false.
    pub keep_sums: bool,
}

/// The stopping rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stop {
    /// Each pixel has the samples per pixel of the scene. The default, without error layers.
    Samples {
        /// True if to estimate the error of each pixel, and to give it as the layers of [`lookat_image::PixelError`]. The samples
        /// of a pixel are then split into independent replicates, each a pattern of its own, because samples of one
        /// pattern do not tell how large its error is. Smaller patterns are noisier, so the picture is another one, and
        /// up to a few times noisier in smooth scenes.
        error_layers: bool,
    },
    /// Pixels have the samples per pixel of the scene in the mean: more of them among noisy neighbors, and fewer elsewhere but
    /// at least half as many, so that the mean squared error of the picture is small. By Sobol's sequence, unless the
    /// scene's samples are random.
    Adaptive,
    /// The time is up, counted from the call of [`render`](crate::render()). By Sobol's sequence, unless the scene's samples are
    /// random: other patterns need a number of samples. Such a picture is another one each time.
    Time {
        /// The time limit.
        limit: Duration,
        /// The most samples per pixel: at least 1.
        max_samples: u32,
        /// True if noisy pixels get more samples, as with [`Stop::Adaptive`].
        adaptive: bool,
    },
    /// The error of each pixel is small enough. By Sobol's sequence. Pixels depend on their neighbors, and on the mean of the
    /// picture.
    TargetError {
        /// The target error.
        target: TargetError,
        /// The most samples of a pixel: at least 64.
        max_samples: u32,
        /// Ends after so long in any case, counted from the call of [`render`](crate::render()).
        limit: Option<Duration>,
        /// Adds error layers, as in [`Stop::Samples`]. The picture is the same either way.
        error_layers: bool,
    },
}

impl Default for Stop {
    fn default() -> Self {
        Stop::Samples { error_layers: false }
    }
}

impl Stop {
    /// The customary most samples per pixel with a time alone: none that matters.
    pub const DEFAULT_MAX_SAMPLES_OF_TIME: u32 = 1 << 30;
    /// The customary most samples of a pixel with a target error.
    pub const DEFAULT_MAX_SAMPLES_OF_TARGET: u32 = 1 << 16;

    /// When the rendering ends, if it begins now. `None` without a limit, and for one beyond the range of the clock.
    pub(super) fn deadline(&self) -> Option<Instant> {
        match *self {
            Stop::Time { limit, .. } | Stop::TargetError { limit: Some(limit), .. } => {
                Instant::now().checked_add(limit)
            }
            Stop::Samples { .. } | Stop::Adaptive | Stop::TargetError { limit: None, .. } => None,
        }
    }

    /// The data that the film keeps beside sums.
    pub(super) fn keeps(&self) -> Keeps {
        match self {
            Stop::Samples { error_layers: true } | Stop::TargetError { .. } => Keeps::Spreads,
            Stop::Adaptive | Stop::Time { adaptive: true, .. } => Keeps::Passes,
            Stop::Samples { error_layers: false } | Stop::Time { adaptive: false, .. } => Keeps::Sums,
        }
    }

    /// True if the picture has layers of its error.
    pub fn has_error_layers(&self) -> bool {
        matches!(self, Stop::Samples { error_layers: true } | Stop::TargetError { error_layers: true, .. })
    }

    /// The pattern of a picture, with as many samples as there may be.
    pub(super) fn sampler(&self, view: &View) -> Sampler {
        let sampler = view.sampler;
        let kind = match sampler.kind {
            SamplerKind::Stratified { .. } => SamplerKind::SOBOL,
            other => other,
        };
        match *self {
            Stop::Samples { .. } => sampler,
            Stop::Adaptive => Sampler { kind, ..sampler },
            Stop::Time { max_samples, .. } => {
                Sampler { kind, samples_per_pixel: max_samples.clamp(1, Stop::DEFAULT_MAX_SAMPLES_OF_TIME) }
            }
            Stop::TargetError { max_samples, .. } => {
                let kind = if kind == SamplerKind::Random { SamplerKind::SOBOL } else { kind };
                Sampler { kind, samples_per_pixel: max_samples.max(target::FIRST) }
            }
        }
    }

    /// The pattern of layers: the picture's, with the samples per pixel of the scene.
    pub(super) fn layer_sampler(&self, view: &View) -> Sampler {
        Sampler { samples_per_pixel: view.sampler.samples_per_pixel, ..self.sampler(view) }
    }

    /// The samples of a pixel that textures are filtered for.
    pub(super) fn nominal_samples(&self, view: &View) -> u32 {
        match self {
            Stop::Samples { .. } | Stop::Adaptive => view.sampler.samples_per_pixel,
            Stop::Time { .. } | Stop::TargetError { .. } => target::FIRST,
        }
    }
}

/// Bytes of a film while it is rendered, about: the sums of each pixel, and the picture that they become. Writing the picture
/// as EXR copies it, but the sums are gone then, which take more.
pub fn film_bytes(view: &View, settings: &Settings) -> u64 {
    let threads = settings.threads.max(threads());
    let policy = match settings.stop {
        Stop::Samples { .. } | Stop::Time { adaptive: false, .. } => 0,
        Stop::Adaptive | Stop::Time { adaptive: true, .. } => adaptive::pixel_bytes(threads),
        Stop::TargetError { .. } => target::PIXEL_BYTES,
    };
    let pixel = pixel_bytes(settings.stop.keeps(), view.filter.shares_samples())
        + policy
        + settings.layers.pixel_bytes()
        + if settings.keep_sums { FilmSums::PIXEL_BYTES } else { 0 };
    view.film.crop.area() * pixel as u64
}

/// The error that each pixel must reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetError {
    /// The error of each of red, green and blue over the luminance of the pixel, more than 0. Pixels darker than
    /// [`DARK`] of the picture count as if they were that bright: nothing is exact relative to black.
    pub relative: f64,
    /// The probability with which a pixel is as exact as that, between 0 and 1.
    pub confidence: f64,
}

/// The stopping rule for a pixel: its confidence interval (Student's t over the replicates) is narrow enough, even if
/// the replicates agree only by chance.
///
/// Replicates of n samples that contain a step between two values can all agree while their mean is wrong by a fraction
/// of the step over n. The standard deviation of the replicates therefore counts as at least `FLOOR` times the step
/// over n. The height of the step is the range of all samples of the pixel and its neighbors. Light that no sample
/// found, such as a rare bright light, is not covered.
#[derive(Debug, Clone, Copy)]
pub(super) struct StopRule {
    relative: f64,
    /// Half the width of the confidence interval over the standard error.
    quantile: f64,
    /// The least luminance that errors are relative to. A darker pixel uses this value instead of its own.
    dark: f64,
}

/// The least standard deviation of the replicates, as a fraction of the step over the samples per replicate.
const FLOOR: f64 = 0.25;

/// The value of a pixel, and what determines its error.
#[derive(Debug, Clone, Copy)]
pub(super) struct Estimate {
    pub value: DVec3,
    pub standard_error: Vec3,
    /// Samples in each replicate.
    pub count: u32,
    /// The bounds of the samples of the pixel and its neighbors.
    pub around: SampleBounds,
}

impl StopRule {
    /// The rule for a picture of unknown brightness.
    pub fn new(target: &TargetError) -> StopRule {
        let tail = (0.5 * (1.0 - target.confidence.clamp(0.0, 1.0))).max(0.0);
        let quantile = StudentsT::new(0.0, 1.0, f64::from(REPLICATES - 1))
            .map_or(f64::INFINITY, |t| -t.inverse_cdf(tail));
        // Rounded, since its last bits depend on the C library.
        const STEPS: f64 = (1_u64 << 40) as f64;
        let quantile = (quantile * STEPS).round() / STEPS;
        StopRule { relative: target.relative.max(f64::MIN_POSITIVE), quantile, dark: 0.0 }
    }

    /// The rule for a picture of this [`Brightness`].
    pub fn with_brightness(self, brightness: f64) -> StopRule {
        StopRule { dark: DARK * brightness, ..self }
    }

    /// Half the width of the confidence interval over the allowed error. At most 1 for a finished pixel.
    pub fn excess(&self, estimate: &Estimate) -> f64 {
        let allowed = self.relative * luminance(estimate.value.as_vec3()).max(self.dark);
        let least = estimate.around.range().as_dvec3() * FLOOR
            / (f64::from(estimate.count) * f64::from(REPLICATES).sqrt());
        let half_width = self.quantile * estimate.standard_error.as_dvec3().max(least).max_element();
        // An all-black picture allows no error, and its pixels have none.
        if half_width == 0.0 { 0.0 } else { half_width / allowed }
    }
}

/// The brightness of a picture: the square of the mean of the square roots of its luminances. A few very bright pixels,
/// such as a lamp, change it little.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Brightness {
    roots: f64,
    pixels: u64,
}

impl Brightness {
    pub fn add(&mut self, value: DVec3) {
        self.roots += luminance(value.as_vec3()).max(0.0).sqrt();
        self.pixels += 1;
    }

    pub fn get(self) -> f64 {
        (self.roots / self.pixels.max(1) as f64).powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: SampleBounds = SampleBounds { least: Vec3::ZERO, most: Vec3::ONE };

    fn rule() -> StopRule {
        StopRule::new(&TargetError { relative: 0.1, confidence: 0.95 }).with_brightness(0.5)
    }

    fn estimate(value: f64, error: f32, around: SampleBounds) -> Estimate {
        Estimate { value: DVec3::splat(value), standard_error: Vec3::splat(error), count: 64, around }
    }

    #[test]
    fn the_interval_matches_students_t() {
        // SciPy: t.ppf(0.975, 15).
        assert!((rule().quantile - 2.131449545559323).abs() < 1e-9);
        let flat = SampleBounds { least: Vec3::ONE, most: Vec3::ONE };
        let excess = rule().excess(&estimate(1.0, 0.02, flat));
        assert!((excess - 2.131449545559323 * 0.02 / 0.1).abs() < 1e-6, "{excess}");
    }

    #[test]
    fn each_channel_counts() {
        let mut estimate = estimate(1.0, 0.0, SampleBounds::EMPTY);
        assert!(rule().excess(&estimate) < 1.0);
        estimate.standard_error.z = 0.1;
        assert!(rule().excess(&estimate) > 1.0);
        estimate.standard_error.z = f32::INFINITY;
        assert!(rule().excess(&estimate) > 1.0);
    }

    /// Next to a step, replicates that agree finish a pixel only if there are many samples.
    #[test]
    fn agreement_counts_only_with_many_samples() {
        let few = Estimate { count: 4, ..estimate(0.1, 0.0, STEP) };
        assert!(rule().excess(&few) > 1.0);
        assert!(rule().excess(&Estimate { count: 64, ..few }) < 1.0);
        assert!(
            rule().excess(&Estimate { around: SampleBounds { most: Vec3::splat(1e-3), ..STEP }, ..few })
                < 1.0
        );
    }

    #[test]
    fn dark_pixels_are_judged_by_the_picture() {
        let by_picture = rule().excess(&estimate(0.0, 1e-3, SampleBounds::EMPTY));
        assert!((by_picture - rule().excess(&estimate(0.5 * DARK, 1e-3, SampleBounds::EMPTY))).abs() < 1e-6);
        assert!(by_picture > rule().excess(&estimate(DARK, 1e-3, SampleBounds::EMPTY)));
        let black = StopRule::new(&TargetError { relative: 0.1, confidence: 0.95 });
        assert!(black.excess(&estimate(0.0, 0.0, SampleBounds::EMPTY)) < 1.0);
    }

    #[test]
    fn a_lamp_changes_the_brightness_little() {
        let mut brightness = Brightness::default();
        (0..99).for_each(|_| brightness.add(DVec3::splat(0.25)));
        assert!((brightness.get() - 0.25).abs() < 1e-6);
        brightness.add(DVec3::splat(100.0));
        assert!(brightness.get() < 0.4);
    }
}
