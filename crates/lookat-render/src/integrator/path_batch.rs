//! Batches of paths that advance together from surface to surface, one branch after the other.

use arrayvec::ArrayVec;
use fearless_simd::{Simd, mask64x8, prelude::*};
use glam::Vec3;

use super::path_record::{Columns, PATHS, PathRecord};
use super::world::{Sees, World};
use crate::camera::CameraSample;
use crate::integrator::world::Tracer;
use crate::number::{Colors, LANES, set_lanes, vectorized};
use crate::trace::MOST_PACKETS;
use crate::trace::rays::{Hits, Rays};

/// A batch of paths that advance together from surface to surface.
pub(crate) struct PathBatch {
    /// The radiance of each sample so far.
    pub radiance: [Vec3; PATHS],
    pub camera_samples: [CameraSample; PATHS],
    block: Box<Block>,
    /// Branches that are continued later, the last one first.
    pending: Vec<Box<Block>>,
    /// The number of pending branches from earlier surfaces.
    before: usize,
    spare: Vec<Box<Block>>,
}

/// Paths at the same depth, at most one for each sample. So a sample adds up its light in an order that does not depend on
/// the other samples of the batch.
struct Block {
    paths: Columns,
    /// The number of surfaces before the next one.
    depth: u32,
}

impl Block {
    fn new() -> Box<Self> {
        Box::new(Block { paths: Columns::new(), depth: 0 })
    }
}

impl PathBatch {
    pub fn new() -> Self {
        PathBatch {
            radiance: [Vec3::ZERO; PATHS],
            camera_samples: [CameraSample::default(); PATHS],
            block: Block::new(),
            pending: Vec::new(),
            before: 0,
            spare: Vec::new(),
        }
    }

    /// Removes all paths.
    pub fn clear(&mut self) {
        self.radiance = [Vec3::ZERO; PATHS];
        (self.block.paths.count, self.block.depth, self.before) = (0, 0, 0);
        self.spare.append(&mut self.pending);
    }

    /// Advances to the next surface. Returns the number of surfaces before it, and the number of paths at it. Takes up the
    /// last pending branch once all other paths have ended. `None` at the end.
    pub(in crate::integrator) fn begin_surface(&mut self) -> Option<(u32, usize)> {
        if self.block.paths.count == 0 {
            let branch = self.pending.pop()?;
            self.spare.push(std::mem::replace(&mut self.block, branch));
        }
        self.before = self.pending.len();
        let count = std::mem::take(&mut self.block.paths.count);
        self.block.depth += 1;
        Some((self.block.depth - 1, count))
    }

    /// The paths `from..to` at this surface, at most eight.
    #[inline(always)]
    pub(in crate::integrator) fn packet<S: Simd>(&self, simd: S, from: usize, to: usize) -> PathRecord<S> {
        self.block.paths.load(simd, from, to)
    }

    /// The block for the paths of a branch from this surface.
    #[inline(always)]
    fn block(&mut self, branch: usize) -> &mut Block {
        let Some(other) = branch.checked_sub(1) else { return &mut self.block };
        while self.pending.len() <= self.before + other {
            let mut block = self.spare.pop().unwrap_or_else(Block::new);
            (block.paths.count, block.depth) = (0, self.block.depth);
            self.pending.push(block);
        }
        &mut self.pending[self.before + other]
    }

    /// Adds light that paths have found to their samples.
    #[inline(always)]
    pub(in crate::integrator) fn add<S: Simd>(&mut self, paths: &PathRecord<S>, light: Colors<S>) {
        self.add_where(paths, light, paths.active);
    }

    /// Adds light that some of the paths have found to their samples.
    #[inline(always)]
    pub(in crate::integrator) fn add_where<S: Simd>(
        &mut self,
        paths: &PathRecord<S>,
        light: Colors<S>,
        active: mask64x8<S>,
    ) {
        let light = paths.throughput * light;
        for lane in set_lanes(active) {
            self.radiance[usize::from(paths.samples[lane])] += light.lane(lane);
        }
    }
}

/// Packets of camera rays.
pub(crate) struct CameraPackets<S: Simd> {
    pub rays: ArrayVec<Rays<S>, MOST_PACKETS>,
    pub active: ArrayVec<mask64x8<S>, MOST_PACKETS>,
    /// The sample of each ray.
    pub samples: ArrayVec<[u16; LANES], MOST_PACKETS>,
}

impl<S: Simd> CameraPackets<S> {
    pub fn new() -> Self {
        CameraPackets { rays: ArrayVec::new(), active: ArrayVec::new(), samples: ArrayVec::new() }
    }

    /// The paths that start with the rays of a packet.
    #[inline(always)]
    pub fn paths(&self, simd: S, packet: usize, hits: Hits<S>) -> PathRecord<S> {
        let (samples, active) = (self.samples[packet], self.active[packet]);
        PathRecord { hits, ..PathRecord::new(simd, self.rays[packet], samples, active) }
    }
}

impl World<'_> {
    /// Adds the emission that rays see directly.
    #[inline(always)]
    pub fn add_emitted<S: Simd>(
        &self,
        simd: S,
        tracer: &Tracer,
        paths: &PathRecord<S>,
        sees: Sees,
        batch: &mut PathBatch,
    ) {
        if sees == Sees::Nothing {
            return;
        }
        let PathRecord { rays, hits, throughput, .. } = paths;
        for lane in set_lanes(paths.active & hits.emits) {
            if let (ray, Some(hit)) = self.one(rays, hits, lane) {
                let light = tracer.emitted(&ray, &hit, sees == Sees::All);
                batch.radiance[usize::from(paths.samples[lane])] += throughput.lane(lane) * light;
            }
        }
        let escaped = paths.active & !hits.is_hit();
        if tracer.lights.has_skies() && escaped.any_true() {
            batch.add_where(paths, tracer.lights.background(simd, rays.d), escaped);
        }
    }

    /// Follows traced rays through surfaces without a material, and adds the emission that delta rays see behind the first
    /// hit. Adds the paths that hit a surface with a material to a branch of the batch.
    #[inline(never)]
    pub fn continue_paths<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        paths: &mut PathRecord<S>,
        (branch, sees): (usize, Sees),
        batch: &mut PathBatch,
    ) {
        vectorized!(simd, {
            let (samples, throughput) = (paths.samples, paths.throughput);
            let add = |lane: usize, light| {
                batch.radiance[usize::from(samples[lane])] += throughput.lane(lane) * light;
            };
            self.pass(simd, tracer, paths, sees, add);
            paths.active &= paths.hits.is_hit();
            batch.block(branch).paths.push(paths);
        })
    }
}
