//! Where samples lie: for each pixel and sample a stream of numbers from 0 to 1, that depends on nothing else.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod halton;
pub(crate) mod lanes;
mod sequence;
mod sobol;

use glam::DVec2;
use lookat_scene::{Sampler, SamplerKind};
use rand::Rng;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use sequence::Sequence;

/// So many dimensions of a sequence, a set, are computed at once.
const SET: usize = 8;

/// Numbers for one camera sample. Each call takes the next dimensions of the pattern.
#[derive(Debug, Clone)]
pub(crate) struct SampleStream {
    pattern: Pattern,
    /// Different for each pixel.
    seed: u64,
    /// Which of the samples of the pixel this is, and of how many.
    index: u32,
    count: u32,
    dimension: u32,
}

#[derive(Debug, Clone)]
enum Pattern {
    Random(Pcg64Mcg),
    Stratified { cells: [u32; 2], jitter: bool },
    Sequence { sequence: Sequence, set: u32, numbers: [f64; SET] },
}

/// No set of dimensions.
const NO_SET: u32 = u32::MAX;

impl SampleStream {
    /// The stream of the first sample of a pixel.
    pub fn new(sampler: &Sampler, seed: u64, pixel: [u32; 2]) -> Self {
        let seed = of_pixel(seed, pixel);
        let pattern = match sampler.kind {
            SamplerKind::Random => Pattern::Random(random_of(seed, 0)),
            SamplerKind::Stratified { cells, jitter } => Pattern::Stratified { cells, jitter },
            SamplerKind::Halton { pixel_center } => Pattern::of(Sequence::halton(pixel_center, seed)),
            SamplerKind::Sobol => Pattern::of(Sequence::Sobol),
        };
        SampleStream { pattern, seed, index: 0, count: sampler.samples_per_pixel, dimension: 0 }
    }

    /// That of a point of Halton's sequence, of a pixel with that seed of its own.
    fn halton(seed: u64, index: u32, count: u32) -> Self {
        SampleStream { pattern: Pattern::of(Sequence::halton(false, seed)), seed, index, count, dimension: 0 }
    }

    /// Goes to the beginning of sample `index` of the same pixel.
    #[inline]
    pub fn restart(&mut self, index: u32) {
        (self.index, self.dimension) = (index, 0);
        match &mut self.pattern {
            Pattern::Random(random) => *random = random_of(self.seed, index),
            Pattern::Stratified { .. } => {}
            Pattern::Sequence { set, .. } => *set = NO_SET,
        }
    }

    /// The stream from here on for the `k`-th of `count` samples that are nested in this one: together they are as well
    /// distributed as `count` times as many samples of the pixel.
    fn nested(&self, count: u32, k: u32) -> Self {
        let mut nested = self.clone();
        let index = self.index.checked_mul(count).and_then(|index| index.checked_add(k));
        let all = match self.pattern {
            // Only these two have to know how many there are; and of cells there may be more than samples.
            Pattern::Stratified { cells: [across, down], .. } => across
                .checked_mul(down)
                .and_then(|cells| cells.checked_mul(count))
                .map(|_| self.count * count),
            Pattern::Sequence { sequence: Sequence::Halton { .. }, .. } => self.count.checked_mul(count),
            Pattern::Random(_) | Pattern::Sequence { .. } => Some(self.count.saturating_mul(count)),
        };
        let (Some(index), Some(all)) = (index, all) else {
            // More than can be numbered: independent ones.
            let seed = mix(hash(self.seed, self.dimension) ^ (u64::from(self.index) << 32 | u64::from(k)));
            nested.pattern = Pattern::Random(Pcg64Mcg::seed_from_u64(seed));
            return nested;
        };
        (nested.index, nested.count) = (index, all);
        match &mut nested.pattern {
            Pattern::Random(random) => {
                *random =
                    Pcg64Mcg::seed_from_u64(mix(hash(self.seed, self.dimension) ^ u64::from(nested.index)));
            }
            Pattern::Stratified { cells, .. } => cells[0] = cells[0].saturating_mul(count),
            Pattern::Sequence { set, .. } => *set = NO_SET,
        }
        nested
    }

    /// A point of the unit square for the `k`-th of `count` samples that are nested in this one. The last takes the dimensions.
    pub fn nested_2d(&mut self, count: u32, k: u32) -> DVec2 {
        if count == 1 {
            return self.next_2d();
        }
        let mut nested = self.nested(count, k);
        let point = match nested.pattern {
            // The others of the set would not be used.
            Pattern::Sequence { sequence: Sequence::Halton { .. }, .. } => {
                halton::pair(nested.dimension, nested.index, nested.count, nested.seed).map(DVec2::from)
            }
            _ => None,
        };
        let point = point.unwrap_or_else(|| nested.next_2d());
        if k + 1 == count {
            self.skip(2);
        }
        point
    }

    /// Leaves dimensions to be taken by others.
    pub fn skip(&mut self, dimensions: u32) {
        self.dimension += dimensions;
    }

    /// One number.
    #[inline]
    pub fn next_1d(&mut self) -> f64 {
        self.dimension += 1;
        self.number(self.dimension - 1)
    }

    /// A point of the unit square.
    #[inline]
    pub fn next_2d(&mut self) -> DVec2 {
        self.dimension += 2;
        let at = self.dimension - 2;
        match self.pattern {
            Pattern::Stratified { cells, jitter } => self.stratified(cells, jitter, at),
            Pattern::Sequence { sequence: Sequence::Halton { pixel_center: true, .. }, .. } if at == 0 => {
                DVec2::splat(0.5)
            }
            _ => DVec2::new(self.number(at), self.number(at + 1)),
        }
    }

    #[inline]
    fn number(&mut self, dimension: u32) -> f64 {
        match &self.pattern {
            Pattern::Sequence { set, numbers, .. } if *set == dimension / SET as u32 => {
                numbers[dimension as usize % SET]
            }
            _ => self.computed(dimension),
        }
    }

    /// Out of line: mostly a number of a sequence is there.
    #[inline(never)]
    fn computed(&mut self, dimension: u32) -> f64 {
        let (seed, index, count) = (self.seed, self.index, self.count);
        match &mut self.pattern {
            Pattern::Random(random) => unit(random.next_u64()),
            Pattern::Stratified { jitter, .. } => {
                let hash = hash(seed, dimension);
                let stratum = permute(index, count, hash as u32);
                let within = if *jitter { unit(mix(hash ^ u64::from(index) << 32)) } else { 0.5 };
                (f64::from(stratum) + within) / f64::from(count)
            }
            Pattern::Sequence { sequence, set, numbers } => {
                *set = dimension / SET as u32;
                *numbers = sequence.numbers(*set, index, count, seed);
                numbers[dimension as usize % SET]
            }
        }
    }

    #[inline(never)]
    fn stratified(&self, [across, down]: [u32; 2], jitter: bool, dimension: u32) -> DVec2 {
        let hash = hash(self.seed, dimension);
        let cell = permute(self.index % (across * down).max(1), across * down, hash as u32);
        let random = mix(hash ^ u64::from(self.index) << 32);
        let within = if jitter { DVec2::new(unit(random), unit(mix(random))) } else { DVec2::splat(0.5) };
        (DVec2::new(f64::from(cell % across), f64::from(cell / across)) + within)
            / DVec2::new(f64::from(across), f64::from(down))
    }
}

impl Pattern {
    fn of(sequence: Sequence) -> Self {
        Pattern::Sequence { sequence, set: NO_SET, numbers: [0.0; SET] }
    }
}

/// The seed of a pixel.
fn of_pixel(seed: u64, pixel: [u32; 2]) -> u64 {
    mix(mix(seed ^ 0x9e37_79b9_7f4a_7c15) ^ (u64::from(pixel[0]) | u64::from(pixel[1]) << 32))
}

/// The random numbers of sample `index` of a pixel.
fn random_of(seed: u64, index: u32) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(mix(seed ^ u64::from(index)))
}

/// The seed of the `i`-th of several patterns that have nothing in common.
pub(crate) fn replicate_seed(seed: u64, i: u32) -> u64 {
    mix(mix(seed).wrapping_add(u64::from(i)))
}

/// Chooses the scramble of one dimension of a pixel.
fn hash(seed: u64, dimension: u32) -> u64 {
    mix(seed ^ (u64::from(dimension) << 32 | 0x5bd1))
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

/// 53 bits as a number from 0 to below 1.
fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * (0.5 / (1_u64 << 52) as f64)
}

/// Spreads every bit over all bits (Stafford's variant 13 of the finaliser of MurmurHash3).
fn mix(mut x: u64) -> u64 {
    x ^= x >> 30;
    x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^= x >> 27;
    x = x.wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    const KINDS: [SamplerKind; 4] = [
        SamplerKind::Random,
        SamplerKind::Stratified { cells: [8, 8], jitter: true },
        SamplerKind::Halton { pixel_center: false },
        SamplerKind::Sobol,
    ];

    fn streams(kind: SamplerKind, count: u32, pixel: [u32; 2]) -> impl Iterator<Item = SampleStream> {
        let sampler = Sampler { kind, samples_per_pixel: count };
        (0..count).map(move |index| of_sample(&sampler, pixel, index))
    }

    fn of_sample(sampler: &Sampler, pixel: [u32; 2], index: u32) -> SampleStream {
        let mut stream = SampleStream::new(sampler, 7, pixel);
        stream.restart(index);
        stream
    }

    /// Nothing is left of the sample before.
    #[test]
    fn streams_begin_anew() {
        let more = [
            SamplerKind::Stratified { cells: [2, 8], jitter: false },
            SamplerKind::Halton { pixel_center: true },
        ];
        for kind in KINDS.into_iter().chain(more) {
            let sampler = Sampler { kind, samples_per_pixel: 16 };
            let mut used = SampleStream::new(&sampler, 7, [3, 5]);
            for index in [0, 9, 9, 2, 15, u32::MAX] {
                used.restart(index);
                let mut fresh = of_sample(&sampler, [3, 5], index);
                // Beyond one set of dimensions, and into the middle of another.
                for k in 0..7 {
                    assert_eq!(used.next_2d(), fresh.next_2d(), "{kind:?} {index}");
                    assert_eq!(used.nested_2d(5, k % 5), fresh.nested_2d(5, k % 5), "{kind:?} {index}");
                    assert_eq!(used.next_1d(), fresh.next_1d(), "{kind:?} {index}");
                }
            }
        }
    }

    #[test]
    fn numbers_lie_in_the_unit_interval_and_repeat() {
        for kind in KINDS {
            for mut stream in streams(kind, 64, [3, 4]) {
                let mut again = stream.clone();
                for _ in 0..300 {
                    let x = stream.next_1d();
                    assert!((0.0..1.0).contains(&x), "{kind:?}");
                    assert_eq!(x, again.next_1d());
                }
            }
        }
    }

    /// Every stratum of a well distributed pattern holds one sample.
    #[test]
    fn first_dimensions_are_stratified() {
        let occupied = |kind, base: u32, dimension| {
            let mut cells = vec![0; 64];
            for mut stream in streams(kind, 64, [1, 2]) {
                let numbers: Vec<f64> = (0..4).map(|_| stream.next_1d()).collect();
                cells[(numbers[dimension] * f64::from(base)) as usize] += 1;
            }
            cells[..base as usize].iter().filter(|count| **count > 0).count()
        };
        assert_eq!(occupied(KINDS[1], 64, 0), 64);
        assert_eq!(occupied(KINDS[2], 64, 0), 64);
        assert_eq!(occupied(KINDS[2], 27, 1), 27);
        assert_eq!(occupied(KINDS[3], 64, 0), 64);
        assert_eq!(occupied(KINDS[3], 64, 3), 64);
    }

    /// The errors of estimates in neighboring pixels, and of different dimensions in one pixel, have nothing in common.
    #[test]
    fn errors_of_neighbors_are_not_correlated() {
        let pixels = 2000;
        for kind in KINDS {
            // The share of 16 samples that fall below a threshold, less its mean.
            let error = |pixel: [u32; 2], dimension: usize| -> f64 {
                let number = |mut stream: SampleStream| (0..=dimension).map(|_| stream.next_1d()).last();
                let below = streams(kind, 16, pixel).filter_map(number).filter(|x| *x < 0.37).count();
                below as f64 / 16.0 - 0.37
            };
            let errors = |step: [u32; 2], dimension| -> Vec<f64> {
                (0..pixels).map(|x| error([x + step[0], step[1]], dimension)).collect()
            };
            let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
            let here = errors([0, 0], 0);
            for (step, dimension) in [([1, 0], 0), ([0, 1], 0), ([0, 0], 1), ([0, 0], 7)] {
                let there = errors(step, dimension);
                let r = product(&here, &there) / (product(&here, &here) * product(&there, &there)).sqrt();
                // Four standard deviations.
                assert!(r.abs() < 4.0 / f64::from(pixels).sqrt(), "{kind:?} {step:?} {dimension}: {r}");
            }
        }
    }

    /// Samples that are nested in those of a pixel are as well distributed as so many samples of it.
    #[test]
    fn nested_samples_differ_from_each_other() {
        for kind in KINDS {
            let nested = streams(kind, 16, [3, 8])
                .flat_map(|stream| (0..4).map(move |k| stream.nested(4, k).next_1d()));
            let mut numbers: Vec<f64> = nested.collect();
            numbers.sort_by(f64::total_cmp);
            numbers.dedup();
            assert_eq!(numbers.len(), 64, "{kind:?}");
            let mean = numbers.iter().sum::<f64>() / 64.0;
            // Four standard deviations of independent samples.
            assert!((mean - 0.5).abs() < 4.0 * (1.0 / 12.0_f64 / 64.0).sqrt(), "{kind:?}: {mean}");
        }
    }

    /// However many samples there may be, those that are nested belong to one pattern.
    #[test]
    fn nested_samples_of_sobol_need_no_count() {
        let few = Sampler { kind: SamplerKind::Sobol, samples_per_pixel: 16 };
        let many = Sampler { samples_per_pixel: 1 << 30, ..few };
        for index in 0..16 {
            let number = |sampler| of_sample(&sampler, [1, 2], index).nested(8, 3).next_1d();
            assert_eq!(number(few), number(many));
        }
    }

    #[test]
    fn permutations_are_permutations() {
        for n in [1, 2, 3, 10, 64, 100] {
            let mut image: Vec<u32> = (0..n).map(|i| permute(i, n, 12345)).collect();
            image.sort_unstable();
            assert_eq!(image, (0..n).collect::<Vec<_>>());
        }
    }
}
