//! The state of paths between two surfaces: eight paths side by side, and the columns that store many.

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};
use glam::Vec3;

use crate::camera::{CameraSample, Viewer, Views};
use crate::number::{Colors, LANES, first_lanes, narrow, set_lanes, splat_f32};
use crate::trace::rays::{Hits, Rays};

/// The number of paths that start together.
pub(crate) const PATHS: usize = 64;

/// Room for the paths and for one packet that is stored at once.
const ROOM: usize = PATHS + LANES;

/// Up to eight paths of a batch: the rays that continue them, and what they carry.
#[derive(Clone, Copy)]
pub(crate) struct PathRecord<S: Simd> {
    /// The lanes with a path.
    pub active: mask64x8<S>,
    pub rays: Rays<S>,
    /// The nearest hits of the rays.
    pub hits: Hits<S>,
    /// The throughput: radiance along the rays is multiplied by it.
    pub throughput: Colors<S>,
    /// A number that the integrator keeps for each path, 1 at first. Path tracing: the factor by which refraction has scaled
    /// the throughput. Direct lighting: the share of the path in its sample.
    pub carried: f32x8<S>,
    /// The density by solid angle with which the last surface has sampled the direction. It is not stored: paths that are loaded at
    /// the next surface have 1.
    pub pdf: f64x8<S>,
    /// The rays whose directions no light sample gives: rays from the camera and from delta lobes. All emission that they
    /// see counts. It is not stored: it has been counted by the next surface.
    pub is_delta: mask64x8<S>,
    /// The rays that have passed surfaces without a material.
    pub has_passed: mask64x8<S>,
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
            throughput: Colors::splat(simd, Vec3::ONE),
            carried: splat_f32(simd, 1.0),
            pdf: 1.0.simd_into(simd),
            is_delta: all,
            has_passed: none,
            samples,
        }
    }

    /// The camera samples that have sent the rays, of all in the batch.
    pub fn views<'v>(&self, of: Viewer<'v>, camera_samples: &'v [CameraSample]) -> Views<'v> {
        Views { of, camera_samples, samples: self.samples, direct: (!self.has_passed).to_bitmask() }
    }
}

/// Values of eight paths, as a column stores them.
trait Column<S: Simd>: Copy {
    type Stored;

    /// Loads the first eight values.
    fn load(simd: S, from: &[Self::Stored]) -> Self;

    /// Stores the values of the active lanes, one after the other. It may write eight.
    fn store(self, active: mask64x8<S>, to: &mut [Self::Stored]);
}

impl<S: Simd> Column<S> for f64x8<S> {
    type Stored = f64;

    #[inline(always)]
    fn load(simd: S, from: &[f64]) -> Self {
        f64x8::from_slice(simd, from)
    }

    #[inline(always)]
    fn store(self, active: mask64x8<S>, to: &mut [f64]) {
        active.token().compress_f64x8(self, active).store_slice(to);
    }
}

impl<S: Simd> Column<S> for f32x8<S> {
    type Stored = f32;

    #[inline(always)]
    fn load(simd: S, from: &[f32]) -> Self {
        f32x8::from_slice(simd, from)
    }

    #[inline(always)]
    fn store(self, active: mask64x8<S>, to: &mut [f32]) {
        active.token().compress_f32x8(self, narrow(active)).store_slice(to);
    }
}

impl<S: Simd> Column<S> for mask64x8<S> {
    type Stored = bool;

    #[inline(always)]
    fn load(simd: S, from: &[bool]) -> Self {
        let bits = from.iter().enumerate().fold(0, |bits, (lane, own)| bits | u64::from(*own) << lane);
        mask64x8::from_bitmask(simd, bits)
    }

    #[inline(always)]
    fn store(self, active: mask64x8<S>, to: &mut [bool]) {
        let bits = self.to_bitmask();
        for (to, lane) in to.iter_mut().zip(set_lanes(active)) {
            *to = bits >> lane & 1 == 1;
        }
    }
}

impl<S: Simd> Column<S> for [u16; LANES] {
    type Stored = u16;

    #[inline(always)]
    fn load(_: S, from: &[u16]) -> Self {
        std::array::from_fn(|lane| from[lane])
    }

    #[inline(always)]
    fn store(self, active: mask64x8<S>, to: &mut [u16]) {
        for (to, lane) in to.iter_mut().zip(set_lanes(active)) {
            *to = self[lane];
        }
    }
}

/// The columns that store the paths of a batch: the only list of what outlasts a surface.
macro_rules! columns {
    ($($column:ident: [$stored:ty] = $($field:tt).+ $([$index:literal])?,)*) => {
        /// Paths at the same depth, at most one for each sample. So a sample adds up its light in an order that does not
        /// depend on the other samples of the batch.
        pub(super) struct Columns {
            $($column: [$stored; ROOM],)*
            pub count: usize,
        }

        impl Columns {
            pub fn new() -> Self {
                Columns { $($column: [Default::default(); ROOM],)* count: 0 }
            }

            /// Up to eight paths `from..to`, with their rays traced.
            #[inline(always)]
            pub fn load<S: Simd>(&self, simd: S, from: usize, to: usize) -> PathRecord<S> {
                let rays = Rays::new(Colors::splat(simd, Vec3::ZERO).widen(), Colors::splat(simd, Vec3::ZERO).widen());
                let mut record = PathRecord::new(simd, rays, [0; LANES], first_lanes(simd, to - from));
                $(record.$($field).+ $([$index])? = Column::load(simd, &self.$column[from..from + LANES]);)*
                // Other lanes hold paths of earlier batches.
                let first = record.samples[0];
                record.samples[to - from..].fill(first);
                record
            }

            /// Stores the active paths.
            #[inline(always)]
            pub fn push<S: Simd>(&mut self, record: &PathRecord<S>) {
                let (at, active) = (self.count, record.active);
                $(record.$($field).+ $([$index])?.store(active, &mut self.$column[at..at + LANES]);)*
                self.count += set_lanes(active).count();
            }
        }
    };
}

columns! {
    origin_x: [f64] = rays.o.x,
    origin_y: [f64] = rays.o.y,
    origin_z: [f64] = rays.o.z,
    direction_x: [f64] = rays.d.x,
    direction_y: [f64] = rays.d.y,
    direction_z: [f64] = rays.d.z,
    distance: [f64] = hits.t,
    element: [f64] = hits.element,
    instance: [f64] = hits.instance,
    side_0: [f64] = hits.sides[0],
    side_1: [f64] = hits.sides[1],
    side_2: [f64] = hits.sides[2],
    red: [f32] = throughput.x,
    green: [f32] = throughput.y,
    blue: [f32] = throughput.z,
    carried: [f32] = carried,
    has_passed: [bool] = has_passed,
    samples: [u16] = samples,
}
