//! Whether pixels are as exact as a target error says: pictures that are known in closed form, rendered until the renderer
//! takes each pixel for exact, and held against what they should be.

mod known;

use std::ops::ControlFlow;

use glam::DVec3;
use lookat_render::{DARK, Reached, Settings, Stop, TargetError};
use lookat_scene::LUMINANCE;

use crate::estimate::interval_at;
pub use known::{Known, edges, fireflies, lens, plain};

/// The most samples of a pixel.
pub const MAX_SAMPLES: u32 = 1 << 14;

/// What has become of a pixel.
#[derive(Debug, Clone, Copy)]
pub struct Judged {
    /// The true value, of green.
    pub value: f64,
    /// Whether no channel is off by more than it may be.
    pub is_within: bool,
    /// Camera samples.
    pub samples: u32,
}

/// Renders a picture to a target error, and holds each pixel against the truth.
pub fn judge(known: &Known, target: TargetError, seed: u64) -> (Vec<Judged>, Reached) {
    let stop = Stop::TargetError { target, max_samples: MAX_SAMPLES, limit: None, error_layers: true };
    let settings = Settings { seed, stop, ..Settings::default() };
    let rendered = lookat_render::render(&known.scene, &settings, &|_| ControlFlow::Continue(()));
    let errors_of = rendered.image.errors().unwrap_or_default();
    let rgb = rendered.image.rgb().unwrap_or_default();
    let dark = DARK * brightness(&known.values);
    let judge = |at: usize| {
        let (value, found) = (&known.values[at], rgb[at]);
        let allowed = target.relative * luminance(value).max(dark);
        let is_within = [0, 1, 2].iter().all(|c| (f64::from(found[*c]) - value[*c]).abs() <= allowed);
        Judged { value: value[1], is_within, samples: errors_of[at].samples }
    };
    ((0..rgb.len()).map(judge).collect(), rendered.statistics.target.unwrap_or_default())
}

fn luminance(rgb: &[f64; 3]) -> f64 {
    LUMINANCE.dot(DVec3::from(*rgb))
}

/// As the renderer has it: the square of the mean of the roots of luminances.
fn brightness(values: &[[f64; 3]]) -> f64 {
    (values.iter().map(|value| luminance(value).sqrt()).sum::<f64>() / values.len() as f64).powi(2)
}

/// Pixels of like value.
#[derive(Debug, Clone, Copy, Default)]
pub struct Stratum {
    /// How many there are.
    pub pixels: u64,
    /// Those at the most samples, for which nothing is promised.
    pub at_cap: u64,
    /// Those of the others that are as exact as promised.
    pub within: u64,
}

/// Bounds of strata, by the value of pixels: that of a pixel that an edge cuts is between 0 and 1.
pub const STRATA: [[f64; 2]; 4] = [[0.0, 0.02], [0.02, 0.1], [0.1, 0.5], [0.5, 1.0]];

impl Stratum {
    /// Counts those pixels of which `belongs` holds.
    pub fn count(pixels: &[Judged], belongs: impl Fn(&Judged) -> bool) -> Stratum {
        let pixels: Vec<&Judged> = pixels.iter().filter(|pixel| belongs(pixel)).collect();
        let is_promised = |pixel: &&&Judged| pixel.samples < MAX_SAMPLES;
        let promised = || pixels.iter().filter(is_promised);
        Stratum {
            pixels: pixels.len() as u64,
            at_cap: (pixels.len() - promised().count()) as u64,
            within: promised().filter(|pixel| pixel.is_within).count() as u64,
        }
    }

    /// The share of promised pixels that are as exact as promised, and the bound that it is above with 99 %.
    pub fn coverage(&self) -> [f64; 2] {
        let promised = self.promised();
        [self.within as f64 / promised.max(1) as f64, interval_at(0.01, self.within, promised)[0]]
    }

    /// Pixels for which something is promised.
    pub fn promised(&self) -> u64 {
        self.pixels - self.at_cap
    }
}
