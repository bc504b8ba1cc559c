//! Settings of a rendering that are not part of the scene, and when it stops.

use std::time::{Duration, Instant};

use lookat_scene::{Sampler, SamplerKind, View};

use super::layer_set::Layers;
use super::part::Part;
use super::stop_rule::TargetError;
use crate::film::{Keeps, REPLICATES};

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
    /// The part of the samples of each pixel to take, with [`Stop::Samples`]; others take no notice of it. Default: all
    /// samples. The [sums](crate::Rendered::sums) of all parts, added up, give the picture of one rendering.
    pub part: Option<Part>,
    /// True for a picture that samples may be added to later: the pattern of a pixel and the filtering of textures then
    /// do not depend on the number of samples, so that [`Prepared::resume`](crate::Prepared::resume) with more samples per pixel gives the
    /// bits of one rendering with as many. Not for stratified samples, whose grid has a fixed size. Where samples are
    /// taken in rounds, the number ends one: see [`Settings::first_round`]. Default false.
    pub is_extendable: bool,
    /// True to keep the sums of the film as [`Rendered::sums`](crate::Rendered::sums). Default false.
    pub keep_sums: bool,
}

/// The stopping rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stop {
    /// Each pixel has the samples per pixel of the scene. The default, without error layers.
    Samples {
        /// True to estimate the error of each pixel, and to write it as the layers of [`lookat_image::PixelError`]. The samples
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
    /// The samples of every pixel before noise decides, where the number of all samples is not known.
    pub(super) const FIRST_OF_ADAPTIVE: u32 = 16;
    /// The samples of every pixel in the first round with a target error: 4 in each replicate.
    pub(super) const FIRST_OF_TARGET: u32 = 4 * REPLICATES;
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
                Sampler { kind, samples_per_pixel: max_samples.max(Stop::FIRST_OF_TARGET) }
            }
        }
    }

    /// The pattern of layers: the picture's, with the samples per pixel of the scene.
    pub(super) fn layer_sampler(&self, view: &View) -> Sampler {
        Sampler { samples_per_pixel: view.sampler.samples_per_pixel, ..self.sampler(view) }
    }
}

impl Settings {
    /// The data that the film keeps beside sums.
    pub(super) fn keeps(&self) -> Keeps {
        match self.stop {
            // Samples that join others need sums that do.
            Stop::Samples { error_layers: true } if self.part.is_some() || self.is_extendable => {
                Keeps::Replicates
            }
            Stop::Samples { error_layers: true } | Stop::TargetError { .. } => Keeps::Spreads,
            Stop::Adaptive | Stop::Time { adaptive: true, .. } => Keeps::Passes,
            Stop::Samples { error_layers: false } | Stop::Time { adaptive: false, .. } => Keeps::Sums,
        }
    }

    /// The target error, if there is one.
    pub fn target_error(&self) -> Option<TargetError> {
        if let Stop::TargetError { target, .. } = self.stop { Some(target) } else { None }
    }

    /// The samples per pixel of the first round of an extendable picture, if it has rounds: it then has 1, 2, 4, 8 and so on times as many. `None`
    /// if it may have any number.
    pub fn first_round(&self) -> Option<u32> {
        match self.stop {
            Stop::Adaptive | Stop::Time { adaptive: true, .. } => Some(Stop::FIRST_OF_ADAPTIVE),
            Stop::TargetError { .. } => Some(Stop::FIRST_OF_TARGET),
            Stop::Samples { error_layers: true } => Some(REPLICATES),
            Stop::Samples { error_layers: false } | Stop::Time { adaptive: false, .. } => None,
        }
    }

    /// True if an extendable picture may end with so many samples per pixel, or at most so many.
    pub fn is_whole_round(&self, samples: u32) -> bool {
        self.first_round().is_none_or(|first| samples >= first && samples.is_power_of_two())
    }

    /// True if the film keeps what the policy knows, to go on with: sums and their numbers do not tell it. A limit of time ends in the middle
    /// of a round, and nothing goes on from there.
    pub(super) fn keeps_policy(&self) -> bool {
        let is_timed = self.stop.deadline().is_some();
        self.keep_sums && !is_timed && matches!(self.keeps(), Keeps::Passes | Keeps::Spreads)
    }

    /// The samples of a pixel that textures are filtered for.
    pub(super) fn nominal_samples(&self, view: &View) -> u32 {
        match self.stop {
            Stop::Samples { .. } | Stop::Adaptive if self.is_extendable => Stop::FIRST_OF_TARGET,
            Stop::Samples { .. } | Stop::Adaptive => view.sampler.samples_per_pixel,
            Stop::Time { .. } | Stop::TargetError { .. } => Stop::FIRST_OF_TARGET,
        }
    }
}
