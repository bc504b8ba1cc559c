//! Batches of paths that advance together from surface to surface, one branch after the other.

use arrayvec::ArrayVec;
use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};
use glam::{DVec2, Vec3};

use super::world::{Sees, World};
use crate::integrator::world::Tracer;
use crate::number::{Colors, LANES, Vec3x8, first_lanes, narrow, set_lanes, splat_f32, vectorized};
use crate::trace::{
    MOST_PACKETS,
    rays::{Hits, Rays},
};

/// The number of paths that start together.
pub(crate) const PATHS: usize = 64;

/// Room for the paths and for one packet that is stored at once.
const ROOM: usize = PATHS + LANES;

/// A batch of paths that advance together from surface to surface.
pub(crate) struct PathBatch {
    /// The radiance of each sample so far.
    pub radiance: [Vec3; PATHS],
    /// The film position of each sample, and the random numbers for the lens.
    pub places: [(DVec2, DVec2); PATHS],
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
    /// One column each for the coordinates of ray origin and direction, and the distance, element, instance and three
    /// weights of the hit.
    numbers: [[f64; ROOM]; 12],
    /// The three channels of the throughput, and [`PathPacket::carried`].
    throughput: [[f32; ROOM]; 4],
    samples: [u16; ROOM],
    /// True if the ray has passed a surface without a material.
    passed: [bool; ROOM],
    count: usize,
    /// The number of surfaces before the next one.
    depth: u32,
}

/// Up to eight paths of a batch.
pub(in crate::integrator) struct PathPacket<S: Simd> {
    pub rays: Rays<S>,
    pub hits: Hits<S>,
    /// The throughput: radiance along the rays is multiplied by it.
    pub throughput: Colors<S>,
    /// A number that the integrator keeps for each path, 1 at first. Path tracing: the factor by which refraction has scaled
    /// the throughput. Direct lighting: the share of the path in its sample.
    pub carried: f32x8<S>,
    /// Bits of the paths that have passed nothing since their last surface.
    pub direct: u64,
    /// The sample of each path.
    pub samples: ArrayVec<u16, LANES>,
}

impl PathBatch {
    pub fn new() -> Self {
        PathBatch {
            radiance: [Vec3::ZERO; PATHS],
            places: [Default::default(); PATHS],
            block: Box::new(Block::new()),
            pending: Vec::new(),
            before: 0,
            spare: Vec::new(),
        }
    }

    /// Removes all paths.
    pub fn clear(&mut self) {
        self.radiance = [Vec3::ZERO; PATHS];
        (self.block.count, self.block.depth, self.before) = (0, 0, 0);
        self.spare.append(&mut self.pending);
    }

    /// Advances to the next surface. Returns the number of surfaces before it, and the number of paths at it. Takes up the
    /// last pending branch once all other paths have ended. `None` at the end.
    pub(in crate::integrator) fn begin_surface(&mut self) -> Option<(u32, usize)> {
        if self.block.count == 0 {
            let branch = self.pending.pop()?;
            self.spare.push(std::mem::replace(&mut self.block, branch));
        }
        self.before = self.pending.len();
        let count = std::mem::take(&mut self.block.count);
        self.block.depth += 1;
        Some((self.block.depth - 1, count))
    }

    /// The paths `from..to` at this surface, at most eight.
    #[inline(always)]
    pub(in crate::integrator) fn packet<S: Simd>(&self, simd: S, from: usize, to: usize) -> PathPacket<S> {
        let Block { numbers, throughput, .. } = &*self.block;
        let [ox, oy, oz, dx, dy, dz, t, element, instance, a, b, c] = numbers;
        let (mut samples, mut direct) = (ArrayVec::new(), 0);
        for (lane, at) in (from..to).enumerate() {
            samples.push(self.block.samples[at]);
            direct |= u64::from(!self.block.passed[at]) << lane;
        }
        PathPacket {
            rays: Rays::new(load_vectors(simd, [ox, oy, oz], from), load_vectors(simd, [dx, dy, dz], from)),
            hits: Hits {
                t: load(simd, t, from),
                element: load(simd, element, from),
                instance: load(simd, instance, from),
                sides: [load(simd, a, from), load(simd, b, from), load(simd, c, from)],
                // That has been asked for.
                emits: mask64x8::splat(simd, false),
            },
            throughput: Colors {
                x: f32x8::from_slice(simd, &throughput[0][from..from + LANES]),
                y: f32x8::from_slice(simd, &throughput[1][from..from + LANES]),
                z: f32x8::from_slice(simd, &throughput[2][from..from + LANES]),
            },
            carried: f32x8::from_slice(simd, &throughput[3][from..from + LANES]),
            direct,
            samples,
        }
    }

    /// Adds the paths in `goes_on` to the next surface. `passed`: bits of the rays that have passed surfaces without a
    /// material.
    #[inline(always)]
    pub(in crate::integrator) fn push<S: Simd>(
        &mut self,
        simd: S,
        TracedRays { rays, hits, throughput, carried, branch }: &TracedRays<S>,
        samples: &[u16],
        goes_on: mask64x8<S>,
        passed: u64,
    ) {
        let block = self.block(*branch);
        let (Rays { o, d, .. }, Hits { t, element, instance, sides: [a, b, c], .. }) = (rays, hits);
        let at = block.count;
        let mut columns = block.numbers.iter_mut();
        let mut put = |values: f64x8<S>| {
            if let Some(column) = columns.next() {
                simd.compress_f64x8(values, goes_on).store_slice(&mut column[at..at + LANES]);
            }
        };
        // One by one, as an array of them would be copied.
        put(o.x);
        put(o.y);
        put(o.z);
        put(d.x);
        put(d.y);
        put(d.z);
        put(*t);
        put(*element);
        put(*instance);
        put(*a);
        put(*b);
        put(*c);
        let narrow = narrow(goes_on);
        for (own, values) in
            block.throughput.iter_mut().zip([throughput.x, throughput.y, throughput.z, *carried])
        {
            simd.compress_f32x8(values, narrow).store_slice(&mut own[at..at + LANES]);
        }
        for lane in set_lanes(goes_on) {
            block.samples[block.count] = samples[lane];
            block.passed[block.count] = passed >> lane & 1 == 1;
            block.count += 1;
        }
    }

    /// The block for the paths of a branch from this surface.
    #[inline(always)]
    fn block(&mut self, branch: usize) -> &mut Block {
        let Some(other) = branch.checked_sub(1) else { return &mut self.block };
        while self.pending.len() <= self.before + other {
            let mut block = self.spare.pop().unwrap_or_else(|| Box::new(Block::new()));
            (block.count, block.depth) = (0, self.block.depth);
            self.pending.push(block);
        }
        &mut self.pending[self.before + other]
    }

    /// Adds light to the samples of paths.
    #[inline(always)]
    pub(in crate::integrator) fn add<S: Simd>(
        &mut self,
        samples: &[u16],
        light: Colors<S>,
        active: mask64x8<S>,
    ) {
        for lane in set_lanes(active) {
            self.radiance[usize::from(samples[lane])] += light.lane(lane);
        }
    }
}

impl Block {
    fn new() -> Self {
        Block {
            numbers: [[0.0; ROOM]; 12],
            throughput: [[0.0; ROOM]; 4],
            samples: [0; ROOM],
            passed: [false; ROOM],
            count: 0,
            depth: 0,
        }
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, numbers: &[f64; ROOM], from: usize) -> f64x8<S> {
    f64x8::from_slice(simd, &numbers[from..from + LANES])
}

#[inline(always)]
fn load_vectors<S: Simd>(simd: S, [x, y, z]: [&[f64; ROOM]; 3], from: usize) -> Vec3x8<S> {
    Vec3x8 { x: load(simd, x, from), y: load(simd, y, from), z: load(simd, z, from) }
}

/// Rays that continue paths, and their nearest hits.
pub(crate) struct TracedRays<S: Simd> {
    pub rays: Rays<S>,
    pub hits: Hits<S>,
    /// The throughput of the paths: radiance along the rays is multiplied by it.
    pub throughput: Colors<S>,
    /// The state that the integrator keeps for each path: see [`PathPacket::carried`].
    pub carried: f32x8<S>,
    /// The index of the rays among the directions that leave their surfaces.
    pub branch: usize,
}

impl World<'_> {
    /// Traces packets of camera rays for the given samples. Adds the emission that they see. If paths continue, adds them to
    /// the batch.
    #[inline(always)]
    pub fn start_paths<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        (packets, samples): (&[Rays<S>], &[ArrayVec<u16, LANES>]),
        (goes_on, sees): (bool, Sees),
        batch: &mut PathBatch,
    ) {
        let mut active: ArrayVec<mask64x8<S>, MOST_PACKETS> = ArrayVec::new();
        for samples in samples {
            active.push(first_lanes(simd, samples.len()));
        }
        let hits = self.nearest_of(simd, tracer, packets, &active);
        for (at, active) in active.iter().enumerate() {
            let (throughput, carried) = (Colors::splat(simd, Vec3::ONE), splat_f32(simd, 1.0));
            let found = &mut TracedRays { rays: packets[at], hits: hits[at], throughput, carried, branch: 0 };
            self.add_emitted(simd, tracer, found, &samples[at], (*active, sees), batch);
            if goes_on {
                self.continue_paths(simd, tracer, found, &samples[at], (*active, *active, sees), batch);
            }
        }
    }

    /// Adds the emission that rays see directly.
    #[inline(always)]
    pub fn add_emitted<S: Simd>(
        &self,
        simd: S,
        tracer: &Tracer,
        TracedRays { rays, hits, throughput, .. }: &TracedRays<S>,
        samples: &[u16],
        (active, sees): (mask64x8<S>, Sees),
        batch: &mut PathBatch,
    ) {
        if sees == Sees::Nothing {
            return;
        }
        for lane in set_lanes(active & hits.emits) {
            if let (ray, Some(hit)) = self.one(rays, hits, lane) {
                let light = tracer.emitted(&ray, &hit, sees == Sees::All);
                batch.radiance[usize::from(samples[lane])] += throughput.lane(lane) * light;
            }
        }
        let escaped = active & !hits.is_hit();
        if tracer.lights.has_skies() && escaped.any_true() {
            batch.add(samples, *throughput * tracer.lights.background(simd, rays.d), escaped);
        }
    }

    /// Follows rays through surfaces without a material. Adds those that hit a surface with a material to the batch. Where
    /// `is_full`, adds the emission that rays see behind the first hit.
    #[inline(never)]
    pub fn continue_paths<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        traced: &mut TracedRays<S>,
        samples: &[u16],
        (active, is_full, sees): (mask64x8<S>, mask64x8<S>, Sees),
        batch: &mut PathBatch,
    ) {
        vectorized!(simd, {
            let mut passed = 0;
            let TracedRays { rays, hits, throughput, .. } = traced;
            if self.materials.has_passed {
                let add =
                    |lane, light| batch.radiance[usize::from(samples[lane])] += throughput.lane(lane) * light;
                passed = self.pass(simd, tracer, rays, hits, (active, is_full, sees), add);
            }
            let goes_on = active & hits.is_hit();
            batch.push(simd, traced, samples, goes_on, passed);
        })
    }
}
