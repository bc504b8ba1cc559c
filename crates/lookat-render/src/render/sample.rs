//! Samples of pixels.

use std::ops::Range;

use glam::{DVec2, DVec3, Vec3};
use lookat_scene::{Sampler, View};

use super::control::Control;
use crate::camera::CameraRays;
use crate::film::{Film, Frame, Scale};
use crate::integrator::SceneIntegrator;
use crate::prepare::Prepared;

/// What every sample needs.
pub(super) struct Context<'a> {
    pub(super) prepared: &'a Prepared,
    pub film: &'a Film<'a>,
    /// That of the film.
    pub(super) scale: Scale,
    pub control: &'a Control<'a>,
    pub(super) camera: CameraRays,
    /// The distance of samples on the film, in pixels.
    pub(super) spacing: f64,
    pub(super) integrator: SceneIntegrator<'a>,
}

impl<'a> Context<'a> {
    /// `nominal_samples`: those of a pixel that textures are filtered for. They have to be known in advance, so that all
    /// samples of a pixel have one mean.
    pub fn new(
        prepared: &'a Prepared,
        view: &View,
        nominal_samples: u32,
        (film, control): (&'a Film<'a>, &'a Control<'a>),
    ) -> Self {
        Context {
            prepared,
            film,
            scale: film.scale(),
            control,
            camera: prepared.camera(view),
            spacing: f64::from(nominal_samples).sqrt().recip(),
            integrator: SceneIntegrator::new(&view.integrator, &prepared.traceable, &prepared.lights),
        }
    }
}

/// Where the samples of a pixel lie.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pattern {
    pub sampler: Sampler,
    pub seed: u64,
    /// Whether the bounds, the sum and the squares of the samples are asked for.
    pub is_watched: bool,
}

/// Samples to take of a pixel.
#[derive(Debug, Clone)]
pub(super) struct Job {
    pub pattern: Pattern,
    pub place: [i32; 2],
    /// Which of the pattern.
    pub indices: Range<u32>,
    /// How much each counts.
    pub weight: f64,
    /// What has become of them.
    pub samples: Samples,
}

impl Job {
    pub fn new(pattern: Pattern, place: [i32; 2], indices: Range<u32>) -> Job {
        Job { pattern, place, indices, weight: 1.0, samples: Samples::default() }
    }

    /// Whether no samples are missing.
    pub fn is_whole(&self) -> bool {
        self.samples.count as usize == self.indices.len()
    }
}

/// What samples have shown.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Samples {
    pub count: u32,
    /// Only of patterns that are watched.
    pub seen: Seen,
    /// Their sum, and the sum of their squared lengths; likewise.
    pub sum: DVec3,
    pub squares: f64,
    /// How many were infinite or not a number.
    pub rejected: u64,
    /// How many were brighter than the film's sums hold.
    pub clamped: u64,
}

/// Bounds of samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Seen {
    pub least: Vec3,
    pub most: Vec3,
}

impl Default for Seen {
    fn default() -> Self {
        Seen::NOTHING
    }
}

impl Seen {
    pub const NOTHING: Seen = Seen { least: Vec3::INFINITY, most: Vec3::NEG_INFINITY };

    pub fn union(self, other: Seen) -> Seen {
        Seen { least: self.least.min(other.least), most: self.most.max(other.most) }
    }

    /// How far apart they are; 0 where there is nothing.
    pub fn range(self) -> Vec3 {
        (self.most - self.least).max(Vec3::ZERO)
    }
}

impl Context<'_> {
    /// Adds the radiance of a sample, which lies at `square` in the unit square of its pixel, to those of its job and to a frame.
    #[inline(always)]
    pub(super) fn add(
        &self,
        (square, mut radiance): (DVec2, Vec3),
        frame: Option<&mut Frame>,
        Job { pattern, place: source, weight, samples, .. }: &mut Job,
    ) {
        if !radiance.is_finite() {
            samples.rejected += 1;
            radiance = Vec3::ZERO;
        }
        let radiance = self.film.limited(radiance);
        samples.clamped += u64::from(self.scale.clamps(radiance));
        samples.count += 1;
        let sample = self.scale.clamped(radiance);
        if let Some(frame) = frame {
            frame.add(&self.film.filter, *source, square, sample.extend(1.0) * *weight);
        }
        if pattern.is_watched {
            samples.sum += sample;
            samples.squares += sample.length_squared();
            samples.seen = samples.seen.union(Seen { least: radiance, most: radiance });
        }
    }
}

/// The corner of a pixel on the film.
#[inline(always)]
pub(super) fn corner_of([x, y]: [i32; 2]) -> DVec2 {
    DVec2::new(x.into(), y.into())
}
