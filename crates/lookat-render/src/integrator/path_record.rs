//! The state of paths between two surfaces: eight paths side by side, and the columns that store many.

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*, u32x8};
use glam::{DVec3, Vec3};

use crate::camera::{CameraSample, Viewer, Views};
use crate::columns::{self, Stored, columns};
use crate::medium::{EMPTY, MediumNumber};
use crate::number::{LANES, Vec3fx8, Vec3x8, first_bits, first_lanes, splat_f32};
use crate::trace::rays::{HitColumns, Hits, RayColumns, Rays};

/// The number of paths that start together.
pub(crate) const PATHS: usize = columns::MOST;

/// Up to eight paths of a batch: the rays that continue them, and what they carry.
#[derive(Clone, Copy)]
pub(crate) struct PathRecord<S: Simd> {
    /// The lanes with a path.
    pub active: mask64x8<S>,
    pub rays: Rays<S>,
    /// The nearest hits of the rays.
    pub hits: Hits<S>,
    /// The throughput: radiance along the rays is multiplied by it.
    pub throughput: Vec3fx8<S>,
    /// Path tracing: the factor by which refraction has scaled the throughput. 1 at first.
    pub eta_scale: f32x8<S>,
    /// Direct lighting: the share of the path in its sample. 1 at first.
    pub share: f32x8<S>,
    /// The density by solid angle with which the last surface has sampled the direction.
    pub pdf: f32x8<S>,
    /// The rays whose directions no light sample gives: rays from the camera and from delta lobes. All emission that they see counts.
    pub is_delta: mask64x8<S>,
    /// The rays that have passed surfaces without a material.
    pub has_passed: mask64x8<S>,
    /// The numbers of the media that the rays are in: see [`Media`](crate::medium::Media).
    pub medium: u32x8<S>,
    /// The rays that scatter in their media, at [`Hits::t`], before they get to a surface.
    pub scatters: mask64x8<S>,
    /// The sample of each path.
    pub samples: [u16; LANES],
}

impl<S: Simd> PathRecord<S> {
    /// Paths that start with these rays, which are not traced yet.
    #[inline(always)]
    pub fn new(simd: S, rays: Rays<S>, samples: [u16; LANES], active: mask64x8<S>) -> Self {
        let (all, none) = (mask64x8::splat(simd, true), mask64x8::splat(simd, false));
        PathRecord {
            active,
            rays,
            hits: Hits::none(simd),
            throughput: Vec3fx8::splat(simd, Vec3::ONE),
            eta_scale: splat_f32(simd, 1.0),
            share: splat_f32(simd, 1.0),
            pdf: splat_f32(simd, 1.0),
            is_delta: all,
            has_passed: none,
            medium: EMPTY.simd_into(simd),
            scatters: none,
            samples,
        }
    }

    /// Room for paths.
    #[inline(always)]
    pub fn none(simd: S) -> Self {
        let zero = Vec3x8::splat(simd, DVec3::ZERO);
        PathRecord::new(simd, Rays::new(zero, zero), [0; LANES], mask64x8::splat(simd, false))
    }

    /// The distances at which the rays end; infinite without a hit.
    #[inline(always)]
    pub fn ends(&self) -> f64x8<S> {
        self.hits.is_hit().select(self.hits.t, f64::INFINITY.simd_into(self.hits.t.token()))
    }

    /// The camera samples that have sent the rays, of all in the batch.
    pub fn views<'v>(&self, of: Viewer<'v>, camera_samples: &'v [CameraSample]) -> Views<'v> {
        Views { of, camera_samples, samples: self.samples, direct: (!self.has_passed).to_bitmask() }
    }
}

columns! {
    /// What paths carry beside their rays and hits.
    struct StateColumns of PathRecord {
        red: f32 = throughput.x,
        green: f32 = throughput.y,
        blue: f32 = throughput.z,
        eta_scale: f32 = eta_scale,
        share: f32 = share,
        pdf: f32 = pdf,
        is_delta: f32 = is_delta,
        has_passed: f32 = has_passed,
        medium: u32 = medium,
        scatters: f32 = scatters,
        samples: u32 = samples,
    }
}

/// Paths, their rays and hits, and what they carry, as a structure of arrays.
#[derive(Clone)]
pub(crate) struct PathColumns {
    pub rays: RayColumns,
    pub hits: HitColumns,
    state: StateColumns,
    pub count: usize,
}

impl PathColumns {
    pub fn new() -> Self {
        PathColumns { rays: RayColumns::new(), hits: HitColumns::new(), state: StateColumns::new(), count: 0 }
    }

    /// Sets the medium of all paths.
    pub fn set_medium(&mut self, medium: MediumNumber) {
        self.state.medium.fill(medium);
    }

    /// All paths; each bit is one.
    pub fn all(&self) -> u64 {
        first_bits(self.count)
    }

    /// Loads up to eight of the first `count` paths, from one on. In place: a record is too large to be returned.
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S, from: usize, count: usize, record: &mut PathRecord<S>) {
        record.active = first_lanes(simd, LANES.min(count - from));
        self.rays.load(simd, from, &mut record.rays);
        self.hits.load(simd, from, &mut record.hits);
        self.state.load(simd, from, record);
        if count - from < LANES {
            // Other lanes hold paths of earlier batches.
            let first = record.samples[0];
            record.samples[count - from..].fill(first);
        }
    }

    /// Adds the active paths, whose rays are not traced yet.
    #[inline(always)]
    pub fn push<S: Simd>(&mut self, paths: &PathRecord<S>) {
        self.store(&Stored::new(paths.active), paths);
    }

    /// Adds the active paths and their hits.
    #[inline(always)]
    pub fn push_with_hits<S: Simd>(&mut self, paths: &PathRecord<S>) {
        let stored = &Stored::new(paths.active);
        self.hits.store(self.count, stored, &paths.hits);
        self.store(stored, paths);
    }

    #[inline(always)]
    pub fn store<S: Simd>(&mut self, stored: &Stored<S>, paths: &PathRecord<S>) {
        self.rays.store(self.count, stored, &paths.rays);
        self.state.store(self.count, stored, paths);
        self.count += paths.active.to_bitmask().count_ones() as usize;
    }
}
