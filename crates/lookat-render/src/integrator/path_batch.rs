//! Batches of paths that advance together from surface to surface, one branch after the other, and the rays that look for their light.

use fearless_simd::{Simd, mask64x8, prelude::*, u32x8};
use glam::Vec3;

use super::bodies::BodyBatch;
use super::path_record::{PATHS, PathColumns, PathRecord};
use super::profiler::Stage;
use super::receiver_columns::ReceiverColumns;
use super::world::{Sees, World};
use crate::camera::{CameraSample, Viewer};
use crate::columns::{Stored, columns};
use crate::integrator::world::Tracer;
use crate::light::Receivers;
use crate::number::{LANES, Vec3fx8, first_bits, set_lanes, vectorized};
use crate::sampler::Streams;
use crate::trace::rays::{RayColumns, Rays};

/// The radiance of each sample.
pub(in crate::integrator) type Radiance = [Vec3; PATHS];

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
    pub(in crate::integrator) shadow_rays: Box<ShadowQueue>,
    /// Rays of BSDF samples that only look for emission.
    pub(in crate::integrator) emission_rays: Box<ScatteredPaths>,
    /// The emission that they have seen at this surface: apart from other light, so that a sample adds up its light in an order that does
    /// not depend on the other samples of the batch.
    pub(in crate::integrator) emission: Radiance,
    /// For paths in media. `None` without media.
    pub(in crate::integrator) in_media: Option<Box<MediaBatch>>,
    /// For paths in bodies. `None` until one enters any.
    pub(in crate::integrator) in_bodies: Option<Box<BodyBatch>>,
}

/// Paths at the same depth, at most one for each sample. So a sample adds up its light in an order that does not depend on the other samples of
/// the batch.
struct Block {
    scattered: ScatteredPaths,
    /// The number of surfaces before the next one.
    depth: u32,
}

impl Block {
    fn new() -> Box<Self> {
        Box::new(Block { scattered: ScatteredPaths::new(), depth: 0 })
    }
}

/// Paths, and the surfaces that have scattered them, which weigh the emission that they see.
#[derive(Clone)]
pub(in crate::integrator) struct ScatteredPaths {
    pub paths: PathColumns,
    /// Set by integrators that weigh emission.
    pub receivers: ReceiverColumns,
}

impl ScatteredPaths {
    pub fn new() -> Self {
        ScatteredPaths { paths: PathColumns::new(), receivers: ReceiverColumns::new() }
    }

    /// Adds the active paths, whose rays are not traced yet.
    #[inline(always)]
    pub fn push<S: Simd>(&mut self, paths: &PathRecord<S>, receivers: &Receivers<S>) {
        let stored = &Stored::new(paths.active);
        self.receivers.store(self.paths.count, stored, receivers);
        self.paths.store(stored, paths);
    }

    /// Adds the active paths and their hits.
    #[inline(always)]
    pub fn push_with_hits<S: Simd>(&mut self, paths: &PathRecord<S>, receivers: &Receivers<S>) {
        let stored = &Stored::new(paths.active);
        self.receivers.store(self.paths.count, stored, receivers);
        self.paths.push_with_hits(paths);
    }
}

/// Shadow rays that wait to be traced, and the light that they let through.
pub(in crate::integrator) struct ShadowQueue {
    rays: RayColumns,
    light: LightColumns,
    count: usize,
}

/// Eight shadow rays.
pub(in crate::integrator) struct ShadowRays<S: Simd> {
    pub rays: Rays<S>,
    /// The light that reaches the film if nothing is in the way.
    pub light: Vec3fx8<S>,
    pub samples: [u16; LANES],
    /// The numbers of the media that the rays start in.
    pub medium: u32x8<S>,
}

columns! {
    pub(in crate::integrator) struct LightColumns of ShadowRays {
        red: f32 = light.x,
        green: f32 = light.y,
        blue: f32 = light.z,
        samples: u32 = samples,
        medium: u32 = medium,
    }
}

impl LightColumns {
    /// The samples of eight shadow rays, from one on.
    #[inline(always)]
    pub fn samples_from(&self, first: usize) -> [u16; LANES] {
        std::array::from_fn(|lane| self.samples[first + lane] as u16)
    }
}

/// The paths of a batch that scatter in media, and room for paths on their way.
pub(in crate::integrator) struct MediaBatch {
    /// Paths that have scattered in media.
    pub events: PathColumns,
    pub room: MediaRoom,
}

/// Room for paths on their way through media.
pub(in crate::integrator) struct MediaRoom {
    /// Paths that have scattered, or got to the ends of their rays.
    pub ahead: ScatteredPaths,
    /// Paths that have got to a surface with a material.
    pub arrived: ScatteredPaths,
}

impl MediaBatch {
    pub fn new() -> Box<Self> {
        let room = MediaRoom { ahead: ScatteredPaths::new(), arrived: ScatteredPaths::new() };
        Box::new(MediaBatch { events: PathColumns::new(), room })
    }
}

impl PathBatch {
    pub fn new() -> Self {
        let shadow_rays = ShadowQueue { rays: RayColumns::new(), light: LightColumns::new(), count: 0 };
        PathBatch {
            radiance: [Vec3::ZERO; PATHS],
            camera_samples: [CameraSample::default(); PATHS],
            block: Block::new(),
            pending: Vec::new(),
            before: 0,
            spare: Vec::new(),
            shadow_rays: Box::new(shadow_rays),
            emission_rays: Box::new(ScatteredPaths::new()),
            emission: [Vec3::ZERO; PATHS],
            in_media: None,
            in_bodies: None,
        }
    }

    /// Removes all paths.
    pub fn clear(&mut self) {
        (self.radiance, self.emission) = ([Vec3::ZERO; PATHS], [Vec3::ZERO; PATHS]);
        (self.block.scattered.paths.count, self.block.depth, self.before) = (0, 0, 0);
        (self.shadow_rays.count, self.emission_rays.paths.count) = (0, 0);
        if let Some(own) = &mut self.in_media {
            own.events.count = 0;
        }
        if let Some(own) = &mut self.in_bodies {
            own.clear();
        }
        self.spare.append(&mut self.pending);
    }

    /// Advances to the next surface. Returns the number of surfaces before it, and the number of paths at it. Takes up the
    /// last pending branch once all other paths have ended. `None` at the end.
    pub(in crate::integrator) fn begin_surface(&mut self) -> Option<(u32, usize)> {
        let in_media = self.in_media.as_ref().map_or(0, |own| own.events.count);
        if self.block.scattered.paths.count == 0 && in_media == 0 {
            let branch = self.pending.pop()?;
            self.spare.push(std::mem::replace(&mut self.block, branch));
        }
        self.before = self.pending.len();
        let count = std::mem::take(&mut self.block.scattered.paths.count);
        self.block.depth += 1;
        Some((self.block.depth - 1, count))
    }

    /// The paths of a branch from this surface, and the radiance of each sample. The first branch replaces the paths at this surface, from
    /// the first on.
    #[inline(always)]
    pub(in crate::integrator) fn branch(&mut self, branch: usize) -> (&mut ScatteredPaths, &mut Radiance) {
        let Some(other) = branch.checked_sub(1) else {
            return (&mut self.block.scattered, &mut self.radiance);
        };
        while self.pending.len() <= self.before + other {
            let mut block = self.spare.pop().unwrap_or_else(Block::new);
            (block.scattered.paths.count, block.depth) = (0, self.block.depth);
            self.pending.push(block);
        }
        (&mut self.pending[self.before + other].scattered, &mut self.radiance)
    }

    /// The number of branches from this surface.
    pub(in crate::integrator) fn branches(&self) -> usize {
        1 + self.pending.len() - self.before
    }

    /// The paths that start at the camera.
    pub fn camera_paths(&mut self) -> &mut PathColumns {
        &mut self.block.scattered.paths
    }

    /// True if no packet fits among the rays that wait to look for emission.
    pub(in crate::integrator) fn is_full(&self) -> bool {
        self.emission_rays.paths.count + LANES > PATHS
    }

    /// Adds light that reaches the film to samples, unless something is in the way of shadow rays. These are traced later.
    #[inline(always)]
    pub(in crate::integrator) fn push_shadow_rays<S: Simd>(
        &mut self,
        simd: S,
        (world, tracer): (&World, &mut Tracer),
        rays: &ShadowRays<S>,
        active: mask64x8<S>,
    ) {
        if self.shadow_rays.count + LANES > PATHS {
            self.trace_shadow_rays(simd, world, tracer);
        }
        let queue = &mut *self.shadow_rays;
        let stored = &Stored::new(active);
        queue.rays.store(queue.count, stored, &rays.rays);
        queue.light.store(queue.count, stored, rays);
        queue.count += active.to_bitmask().count_ones() as usize;
    }

    /// Traces the shadow rays that wait, and adds the light of those that are not occluded.
    #[inline(never)]
    pub(in crate::integrator) fn trace_shadow_rays<S: Simd>(
        &mut self,
        simd: S,
        world: &World,
        tracer: &mut Tracer,
    ) {
        let ShadowQueue { rays, light, count } = &mut *self.shadow_rays;
        let all = first_bits(std::mem::take(count));
        if all == 0 {
            return;
        }
        let mut free = match &world.media {
            Some(media) => world.transmit(simd, tracer, media, rays, light, all),
            None => all & !world.occluded(simd, tracer, rays, all, true),
        };
        while free != 0 {
            let at = free.trailing_zeros() as usize;
            free &= free - 1;
            self.radiance[light.samples[at] as usize] +=
                Vec3::new(light.red[at], light.green[at], light.blue[at]);
        }
    }
}

/// Adds light that paths have found to their samples.
#[inline(always)]
pub(in crate::integrator) fn add_light<S: Simd>(
    radiance: &mut Radiance,
    paths: &PathRecord<S>,
    light: Vec3fx8<S>,
    active: mask64x8<S>,
) {
    let light = paths.throughput * light;
    for lane in set_lanes(active) {
        radiance[usize::from(paths.samples[lane])] += light.lane(lane);
    }
}

/// The surfaces that the paths of a batch have reached.
#[derive(Clone, Copy)]
pub(in crate::integrator) struct BatchSurface<'v> {
    /// The number of surfaces before.
    pub depth: u32,
    /// The number of paths.
    pub count: usize,
    /// The first sample dimension at this surface.
    pub dimension: u32,
    /// What has sent the rays, if these are camera rays.
    pub camera: Option<Viewer<'v>>,
}

impl BatchSurface<'_> {
    /// Calls `does` with each packet of paths, and with streams that are at the dimensions of this surface. Stops once the tracer [is
    /// stopped](Tracer::is_stopped).
    #[inline(always)]
    pub fn for_each_packet<S: Simd>(
        &self,
        simd: S,
        mut state: (&mut Tracer, &mut Streams, &mut PathBatch),
        mut does: impl FnMut(&mut (&mut Tracer, &mut Streams, &mut PathBatch), &PathRecord<S>),
    ) {
        let paths = &mut PathRecord::none(simd);
        for first in (0..self.count).step_by(LANES) {
            let (tracer, streams, batch) = &mut state;
            if !tracer.should_continue() {
                return;
            }
            tracer.profile(|profiler| {
                profiler.enter(Stage::Shading);
                profiler.count(LANES.min(self.count - first) as u64);
            });
            batch.branch(0).0.paths.load(simd, first, self.count, paths);
            streams.choose(simd, &paths.samples, self.dimension);
            does(&mut state, paths);
        }
    }
}

impl World<'_> {
    /// Adds the emission that traced rays see directly.
    #[inline(never)]
    pub fn add_emitted<S: Simd>(
        &self,
        simd: S,
        tracer: &Tracer,
        paths: &PathColumns,
        sees: Sees,
        radiance: &mut Radiance,
    ) {
        if sees == Sees::Nothing {
            return;
        }
        vectorized!(simd, {
            let own = &mut PathRecord::none(simd);
            for first in (0..paths.count).step_by(LANES) {
                paths.load(simd, first, paths.count, own);
                let PathRecord { rays, hits, throughput, .. } = &*own;
                for lane in set_lanes(own.active & hits.emits) {
                    if let (ray, Some(hit)) = self.one(rays, hits, lane) {
                        let light = tracer.emitted(&ray, &hit, sees == Sees::All);
                        radiance[usize::from(own.samples[lane])] += throughput.lane(lane) * light;
                    }
                }
                let escaped = own.active & !hits.is_hit();
                if tracer.lights.has_skies() && escaped.any_true() {
                    add_light(radiance, own, tracer.lights.background(simd, rays.d), escaped);
                }
            }
        })
    }

    /// Follows traced rays through surfaces without a material, and adds the emission that delta rays see behind the first hit. Keeps the
    /// paths that hit a surface with a material.
    #[inline(never)]
    pub fn continue_paths<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        paths: &mut PathColumns,
        sees: Sees,
        radiance: &mut Radiance,
    ) {
        vectorized!(simd, {
            let (count, own) = (std::mem::take(&mut paths.count), &mut PathRecord::none(simd));
            for first in (0..count).step_by(LANES) {
                paths.load(simd, first, count, own);
                if self.materials.has_passed {
                    let (samples, throughput) = (own.samples, own.throughput);
                    let add = |lane: usize, light| {
                        radiance[usize::from(samples[lane])] += throughput.lane(lane) * light;
                    };
                    self.pass(simd, tracer, own, sees, add);
                }
                let is_whole = own.hits.is_hit().all_true() && paths.count == first && first + LANES <= count;
                if is_whole && !self.materials.has_passed {
                    // They stay where they are.
                    paths.count += LANES;
                    continue;
                }
                own.active &= own.hits.is_hit();
                paths.push_with_hits(own);
            }
        })
    }
}
