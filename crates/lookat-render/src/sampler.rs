//! Samplers: the sample numbers of a pixel, between 0 and 1, one for each dimension. They depend on the pixel, the sample and the seed
//! alone. Hashes and permutations randomize them.
//!
//! A number has 52 bits, so that it may choose one of many and go on with what is left of it: after a choice of one of a million, 32 bits.

mod sobol;
#[cfg(test)]
mod tests;

use std::array::from_fn;

use fearless_simd::{Simd, f64x8, prelude::*, u32x8, u64x8};
use glam::DVec2;
use lookat_scene::{Sampler, SamplerKind};

use crate::number::{LANES, vectorized};
use sobol::Shuffled;

/// The number of sample dimensions of a camera ray: film position and lens position, with or without a lens.
pub(crate) const CAMERA_NUMBERS: u32 = 4;

/// The dimension of the instants of camera rays: apart from all others, which are the same in worlds without motion.
const TIME: u32 = u32::MAX;

/// A variant of the sampler in which neighboring pixels have independent samples. Adaptive sampling needs it: the errors of
/// correlated neighbors cancel, and would bias the decision about each other's samples.
pub(crate) fn of_single_pixels(sampler: Sampler) -> Sampler {
    match sampler.kind {
        SamplerKind::Sobol { .. } => Sampler { samples_per_pixel: sobol::ALONE, ..sampler },
        SamplerKind::Random | SamplerKind::Stratified { .. } => sampler,
    }
}

/// One of the samples of a pixel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    pub seed: u64,
    pub pixel: [i32; 2],
    /// The index among the samples of the pixel.
    pub index: u32,
}

impl Sample {
    /// A number that no other sample of a picture, or of another seed, is likely to have.
    pub fn hash(&self) -> u64 {
        let [x, y] = self.pixel.map(|at| u64::from(at as u32));
        mix(mix(mix(self.seed) ^ (x << 32 | y)) ^ u64::from(self.index))
    }
}

/// Numbers for camera samples of any pixels, eight of which are had at a time. Each call takes the next dimensions.
#[derive(Debug, Clone)]
pub(crate) struct Streams {
    samples: Vec<Sample>,
    /// For each sample, the seed of its pattern and its index in the pattern.
    sequences: Vec<(u64, u32)>,
    /// The current points, and the samples that they belong to.
    points: Points,
    chosen: [u16; LANES],
    dimension: u32,
}

/// Samples of one pattern in each of as many pixels, or in blocks of pixels.
#[derive(Debug, Clone, Copy)]
struct Points {
    kind: SamplerKind,
    /// The number of samples in each pixel.
    count: u32,
    /// Of Sobol' points: see [`sobol::pixel_bits`].
    pixel_bits: u32,
    seeds: [u64; LANES],
    indices: [u32; LANES],
    /// The state of Sobol' points.
    shuffled: Shuffled,
}

impl Streams {
    /// Streams without samples.
    pub fn new() -> Self {
        let points = Points {
            kind: SamplerKind::Random,
            count: 0,
            pixel_bits: 0,
            seeds: [0; LANES],
            indices: [0; LANES],
            shuffled: Shuffled::default(),
        };
        Streams { samples: Vec::new(), sequences: Vec::new(), points, chosen: [0; LANES], dimension: 0 }
    }

    /// Starts other samples at their first dimension.
    pub fn restart(&mut self, sampler: &Sampler, samples: &[Sample]) {
        (self.points.kind, self.points.count) = (sampler.kind, sampler.samples_per_pixel);
        self.points.pixel_bits = sobol::pixel_bits(sampler.samples_per_pixel);
        self.samples.clear();
        self.samples.extend(samples);
        self.sequences.clear();
        let mut before = None;
        self.sequences.extend(samples.iter().map(|sample| {
            let own = match before {
                // Mostly it is of the same pixel. Then only the index differs.
                Some((other, (seed, number))) if sobol::is_beside(*sample, other, self.points.pixel_bits) => {
                    (seed, number ^ other.index ^ sample.index)
                }
                _ => self.points.sequence(*sample),
            };
            before = Some((*sample, own));
            own
        }));
    }

    /// Selects some of the samples, at dimension `dimension`.
    #[inline(always)]
    pub fn choose<S: Simd>(&mut self, simd: S, samples: &[u16], dimension: u32) {
        for lane in 0..LANES {
            let sample = *samples.get(lane).unwrap_or(&samples[0]);
            self.chosen[lane] = sample;
            (self.points.seeds[lane], self.points.indices[lane]) = self.sequences[usize::from(sample)];
        }
        self.points.shuffle(simd);
        self.dimension = dimension;
    }

    /// Numbers.
    #[inline(always)]
    pub fn next_1d<S: Simd>(&mut self, simd: S) -> f64x8<S> {
        self.dimension = self.dimension.wrapping_add(1);
        self.points.number(simd, self.dimension.wrapping_sub(1))
    }

    /// Numbers for the instants of camera rays. They take no dimension of others.
    #[inline(always)]
    pub fn time<S: Simd>(&self, simd: S) -> f64x8<S> {
        self.points.number(simd, TIME)
    }

    /// Two numbers for the way of each path to its surface of a number, through media. They take no dimension of others.
    #[inline(always)]
    pub fn on_the_way<S: Simd>(&self, simd: S, depth: u32) -> [f64x8<S>; 2] {
        [1, 2].map(
            #[inline(always)]
            |number| self.points.number(simd, TIME.wrapping_sub(depth.wrapping_mul(2).wrapping_add(number))),
        )
    }

    /// Points of the unit square.
    #[inline(always)]
    pub fn next_2d<S: Simd>(&mut self, simd: S) -> [f64x8<S>; 2] {
        self.dimension = self.dimension.wrapping_add(2);
        self.points.pair(simd, self.dimension.wrapping_sub(2))
    }

    /// Points for the `k`-th of `count` samples that are nested in each: together they are as well distributed as `count` times as many
    /// samples of the pixel. The last takes the dimensions.
    #[inline(always)]
    pub fn nested_2d<S: Simd>(&mut self, simd: S, (count, k): (u32, u32)) -> [f64x8<S>; 2] {
        let points = match count {
            1 => self.points.pair(simd, self.dimension),
            _ => self.nested_pair(simd, self.dimension, (count, k)),
        };
        self.skip(if k + 1 == count { 2 } else { 0 });
        points
    }

    /// A number and a point of the unit square for the `k`-th of `count` nested samples, as [`Streams::nested_2d`]. If `count` is a power of
    /// two, the numbers of a sample lie in as many equal steps.
    #[inline(always)]
    pub fn nested_3d<S: Simd>(&mut self, simd: S, (count, k): (u32, u32)) -> (f64x8<S>, [f64x8<S>; 2]) {
        let [number, _] = self.nested_pair(simd, self.dimension, (count, k));
        let pair = self.nested_pair(simd, self.dimension.wrapping_add(1), (count, k));
        self.skip(if k + 1 == count { 3 } else { 0 });
        (number, pair)
    }

    #[inline(always)]
    fn nested_pair<S: Simd>(&self, simd: S, dimension: u32, of: (u32, u32)) -> [f64x8<S>; 2] {
        let samples = self.chosen.map(|sample| self.samples[usize::from(sample)]);
        self.points.nested_pair(simd, dimension, samples, of)
    }

    /// Leaves dimensions to be taken by others.
    #[inline(always)]
    pub fn skip(&mut self, dimensions: u32) {
        self.dimension = self.dimension.wrapping_add(dimensions);
    }
}

impl Points {
    /// The seed of a sample's pattern, and its number in that.
    fn sequence(&self, sample: Sample) -> (u64, u32) {
        match self.kind {
            SamplerKind::Sobol { .. } => sobol::sequence(sample, self.pixel_bits),
            SamplerKind::Random | SamplerKind::Stratified { .. } => {
                let Sample { seed, pixel, index } = sample;
                let [x, y] = pixel.map(|at| u64::from(at.cast_unsigned()));
                (of_position(seed, x | y << 32), index)
            }
        }
    }

    /// Updates the state that depends on the indices.
    #[inline(always)]
    fn shuffle<S: Simd>(&mut self, simd: S) {
        if let SamplerKind::Sobol { .. } = self.kind {
            let mask = (1 << self.pixel_bits) - 1;
            self.shuffled = Shuffled::new(simd, 0, (self.seeds, self.indices), mask);
        }
    }

    /// The numbers of a dimension.
    #[inline(never)]
    fn number<S: Simd>(&self, simd: S, dimension: u32) -> f64x8<S> {
        vectorized!(simd, self.number_of(simd, dimension))
    }

    #[inline(always)]
    fn number_of<S: Simd>(&self, simd: S, dimension: u32) -> f64x8<S> {
        match self.kind {
            SamplerKind::Random => self.random(simd, dimension),
            SamplerKind::Stratified { jitter, .. } => self.each(simd, |seed, index| {
                let hash = of_dimension(seed, dimension);
                let stratum = permute(index, self.count, hash as u32);
                let within = if jitter { unit(mix(hash ^ u64::from(index) << 32)) } else { 0.5 };
                ((f64::from(stratum) + within) / f64::from(self.count)).min(BELOW_ONE)
            }),
            SamplerKind::Sobol { .. } => {
                sobol::numbers(simd, dimension, (self.seeds, self.indices), &self.shuffled)
            }
        }
    }

    /// The numbers of a dimension and the next, as points of the unit square.
    #[inline(never)]
    fn pair<S: Simd>(&self, simd: S, dimension: u32) -> [f64x8<S>; 2] {
        vectorized!(simd, {
            match self.kind {
                SamplerKind::Stratified { cells, jitter } => {
                    self.stratified(simd, dimension, (cells, jitter))
                }
                SamplerKind::Sobol { pixel_center: true } if dimension == 0 => [0.5.simd_into(simd); 2],
                SamplerKind::Sobol { .. } => {
                    sobol::pairs(simd, dimension, (self.seeds, self.indices), &self.shuffled)
                }
                SamplerKind::Random => {
                    [self.number_of(simd, dimension), self.number_of(simd, dimension.wrapping_add(1))]
                }
            }
        })
    }

    /// The points of nested sample `k` out of `count`.
    #[inline(never)]
    fn nested_pair<S: Simd>(
        &self,
        simd: S,
        dimension: u32,
        samples: [Sample; LANES],
        (count, k): (u32, u32),
    ) -> [f64x8<S>; 2] {
        vectorized!(simd, {
            let mut nested = *self;
            nested.count = self.count.saturating_mul(count);
            let mut is_numbered = [true; LANES];
            for (lane, Sample { seed, pixel, index }) in samples.into_iter().enumerate() {
                let index = u64::from(index) * u64::from(count) + u64::from(k);
                is_numbered[lane] = index <= u64::from(u32::MAX);
                (nested.seeds[lane], nested.indices[lane]) =
                    nested.sequence(Sample { seed, pixel, index: index as u32 });
            }
            // Of cells there may be more than samples.
            let needed = match self.kind {
                SamplerKind::Stratified { cells: [across, down], .. } => {
                    u64::from(across) * u64::from(down) * u64::from(count)
                }
                SamplerKind::Random | SamplerKind::Sobol { .. } => 0,
            };
            if needed > u64::from(u32::MAX) {
                is_numbered = [false; LANES];
            }
            nested.shuffle(simd);
            if let SamplerKind::Stratified { cells, .. } = &mut nested.kind {
                cells[0] = cells[0].saturating_mul(count);
            }
            let [mut x, mut y] = if needed > u64::from(u32::MAX) {
                [0.0.simd_into(simd); 2]
            } else {
                nested.pair(simd, dimension)
            };
            for lane in (0..LANES).filter(|lane| !is_numbered[*lane]) {
                // More than can be numbered: independent ones.
                let (seed, index) = Points { kind: SamplerKind::Random, ..*self }.sequence(samples[lane]);
                let own = u64::from(index) << 32 | u64::from(k);
                let seed = mix(of_dimension(seed, dimension) ^ own);
                (x[lane], y[lane]) = (unit(mix(seed)), unit(mix(!seed)));
            }
            [x, y]
        })
    }

    #[inline(always)]
    fn stratified<S: Simd>(
        &self,
        simd: S,
        dimension: u32,
        ([across, down], jitter): ([u32; 2], bool),
    ) -> [f64x8<S>; 2] {
        let points: [DVec2; LANES] = from_fn(|lane| {
            let (seed, index) = (self.seeds[lane], self.indices[lane]);
            let hash = of_dimension(seed, dimension);
            let cell = permute(index % (across * down).max(1), across * down, hash as u32);
            let random = mix(hash ^ u64::from(index) << 32);
            let within = if jitter { DVec2::new(unit(random), unit(mix(random))) } else { DVec2::splat(0.5) };
            let corner = DVec2::new(f64::from(cell % across), f64::from(cell / across));
            ((corner + within) / DVec2::new(f64::from(across), f64::from(down))).min(DVec2::splat(BELOW_ONE))
        });
        [f64x8::from_fn(simd, |lane| points[lane].x), f64x8::from_fn(simd, |lane| points[lane].y)]
    }

    #[inline(always)]
    fn random<S: Simd>(&self, simd: S, dimension: u32) -> f64x8<S> {
        self.each(simd, |seed, index| random(seed, dimension, index))
    }

    /// Applies a function to each seed and index.
    #[inline(always)]
    fn each<S: Simd>(&self, simd: S, number: impl Fn(u64, u32) -> f64) -> f64x8<S> {
        f64x8::from_fn(simd, |lane| number(self.seeds[lane], self.indices[lane]))
    }
}

/// The seed of the `i`-th of several patterns that have nothing in common.
pub(crate) fn replicate_seed(seed: u64, i: u32) -> u64 {
    mix(mix(seed).wrapping_add(u64::from(i)))
}

/// The image of `i` under a permutation of `0..n` that `seed` chooses (Kensler, "Correlated Multi-Jittered Sampling",
/// 2013).
fn permute(mut i: u32, n: u32, seed: u32) -> u32 {
    if n <= 1 {
        return 0;
    }
    let mask = n.next_power_of_two().wrapping_sub(1);
    loop {
        i ^= seed;
        i = i.wrapping_mul(0xe170_893d);
        i ^= seed >> 16;
        i ^= (i & mask) >> 4;
        i ^= seed >> 8;
        i = i.wrapping_mul(0x0929_eb3f);
        i ^= seed >> 23;
        i ^= (i & mask) >> 1;
        i = i.wrapping_mul(1 | seed >> 27);
        i = i.wrapping_mul(0x6935_fa69);
        i ^= (i & mask) >> 11;
        i = i.wrapping_mul(0x74dc_b303);
        i ^= (i & mask) >> 2;
        i = i.wrapping_mul(0x9e50_1cc3);
        i ^= (i & mask) >> 2;
        i = i.wrapping_mul(0xc860_a3df);
        i &= mask;
        i ^= i >> 5;
        if i < n {
            return ((u64::from(i) + u64::from(seed)) % u64::from(n)) as u32;
        }
    }
}

/// The seed of a pixel or of another position.
fn of_position(seed: u64, position: u64) -> u64 {
    mix(mix(seed ^ 0x9e37_79b9_7f4a_7c15) ^ position)
}

/// Chooses the scramble of one dimension of a pixel.
fn of_dimension(seed: u64, dimension: u32) -> u64 {
    mix(seed ^ (u64::from(dimension) << 32 | 0x5bd1))
}

/// A random number of sample `index`.
fn random(seed: u64, dimension: u32, index: u32) -> f64 {
    unit(mix(of_dimension(seed, dimension) ^ u64::from(index) << 32))
}

/// The largest number below one.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// 52 bits as a number: the middle of one of 2^52 equal steps from 0 to 1. It is never 0, which would choose what has next to no
/// probability.
pub(crate) fn unit(bits: u64) -> f64 {
    f64::from_bits(bits >> 12 | 1.0_f64.to_bits()) - BELOW_ONE
}

/// Numbers in 0..1 from 32 bits in each lane. A hash of the bits and of the scramble adds 20 bits: enough to choose one of a
/// million, and to use the remainder of the number.
#[inline(always)]
fn units<S: Simd>(bits: u32x8<S>, scramble: u32x8<S>) -> f64x8<S> {
    let all = widened(bits) << 20 | widened(lowbias(bits ^ scramble)) >> 12 | 1.0_f64.to_bits();
    let above_one: f64x8<S> = all.bitcast();
    above_one - BELOW_ONE
}

/// Spreads every bit over all bits (Stafford's variant 13 of the finaliser of MurmurHash3).
pub(crate) fn mix(mut x: u64) -> u64 {
    x ^= x >> 30;
    x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^= x >> 27;
    x = x.wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// A hash of 32 bits in each lane (Wellons's "lowbias32").
#[inline(always)]
fn lowbias<S: Simd>(mut x: u32x8<S>) -> u32x8<S> {
    x ^= x >> 16;
    x *= 0x7feb_352d;
    x ^= x >> 15;
    x *= 0x846c_a68b;
    x ^ x >> 16
}

/// Owen's scramble of numbers whose bits are in reverse; that of `sobol_burley` (Burley, "Practical Hash-based Owen Scrambling", JCGT
/// 9(4), 2020).
#[inline(always)]
fn owen_scramble_rev<S: Simd>(mut x: u32x8<S>, scramble: u32x8<S>) -> u32x8<S> {
    x ^= x * 0x3d20_adea;
    x += scramble;
    x *= scramble >> 16 | 1;
    x ^= x * 0x0552_6c56;
    x ^ (x * 0x53a2_2864)
}

/// The bits in reverse.
#[inline(always)]
fn reversed<S: Simd>(mut x: u32x8<S>) -> u32x8<S> {
    x = (x >> 1 & 0x5555_5555) | ((x & 0x5555_5555) << 1);
    x = (x >> 2 & 0x3333_3333) | ((x & 0x3333_3333) << 2);
    x = (x >> 4 & 0x0f0f_0f0f) | ((x & 0x0f0f_0f0f) << 4);
    x = (x >> 8 & 0x00ff_00ff) | ((x & 0x00ff_00ff) << 8);
    x >> 16 | x << 16
}

#[inline(always)]
fn widened<S: Simd>(x: u32x8<S>) -> u64x8<S> {
    let (low, high) = x.widen();
    x.token().combine_u64x4(low, high)
}
