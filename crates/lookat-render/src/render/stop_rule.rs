//! The target error, and the rule that decides whether a pixel has reached it.

use glam::{DVec3, Vec3};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::DARK;
use super::sample::SampleBounds;
use crate::film::REPLICATES;
use crate::number::luminance;

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
