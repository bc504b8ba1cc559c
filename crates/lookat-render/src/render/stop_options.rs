//! The stopping rule by the options that users set.

use std::ops::RangeInclusive;
use std::time::Duration;

use super::settings::Stop;
use super::stop_rule::TargetError;

/// What users ask for. By default each pixel has the samples per pixel of the scene.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StopOptions {
    /// Samples per pixel; the most with a target error or a time limit.
    pub spp: Option<u32>,
    /// See [`TargetError::relative`]. In [`StopOptions::TARGET_ERROR`].
    pub target_error: Option<f64>,
    /// See [`TargetError::confidence`]. In [`StopOptions::CONFIDENCE`], default 0.95.
    pub confidence: Option<f64>,
    /// The time limit, with [`StopOptions::SECONDS`].
    pub time: Option<Duration>,
    /// See [`Stop::Adaptive`].
    pub adaptive: bool,
    /// See [`Stop::Samples`].
    pub error_layers: bool,
}

/// Why options do not go together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum StopOptionsError {
    /// Both decide about the samples of pixels.
    #[error("adaptive sampling and a target error exclude each other")]
    TwoRules,
    /// The error is estimated from that many.
    #[error(
        "a target error needs at least {} samples per pixel to estimate the error",
        Stop::FIRST_OF_TARGET
    )]
    FewSamples,
    /// Adaptive sampling, and the clock, leave no replicates.
    #[error("error layers go with a number of samples or with a target error")]
    NoReplicates,
}

impl StopOptions {
    /// Target errors.
    pub const TARGET_ERROR: RangeInclusive<f64> = 1e-6..=1.0;
    /// Confidences of target errors.
    pub const CONFIDENCE: RangeInclusive<f64> = 0.5..=0.999_999;
    /// Time limits, in seconds.
    pub const SECONDS: RangeInclusive<f64> = 0.001..=1e8;

    /// The stopping rule.
    pub fn stop(&self) -> Result<Stop, StopOptionsError> {
        let StopOptions { spp, target_error, confidence, time, adaptive, error_layers } = *self;
        match (target_error, time) {
            (Some(_), _) if adaptive => Err(StopOptionsError::TwoRules),
            (Some(_), _) if spp.is_some_and(|most| most < Stop::FIRST_OF_TARGET) => {
                Err(StopOptionsError::FewSamples)
            }
            (None, _) if error_layers && (adaptive || time.is_some()) => Err(StopOptionsError::NoReplicates),
            (Some(relative), limit) => Ok(Stop::TargetError {
                target: TargetError { relative, confidence: confidence.unwrap_or(0.95) },
                max_samples: spp.unwrap_or(Stop::DEFAULT_MAX_SAMPLES_OF_TARGET),
                limit,
                error_layers,
            }),
            (None, Some(limit)) => {
                let max_samples = spp.unwrap_or(Stop::DEFAULT_MAX_SAMPLES_OF_TIME);
                Ok(Stop::Time { limit, max_samples, adaptive })
            }
            (None, None) if adaptive => Ok(Stop::Adaptive),
            (None, None) => Ok(Stop::Samples { error_layers }),
        }
    }
}
