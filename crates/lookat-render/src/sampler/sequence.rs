//! Low-discrepancy sequences: the numbers of several dimensions at once.

use std::array::from_fn;

use super::{SET, halton, hash, mix, sobol, unit};
use crate::arithmetic::{Simd, SimdKind};
use crate::lanes::LANES;

/// Which sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sequence {
    /// With the seeds of the first set of a pixel, which all its samples take.
    Halton {
        pixel_center: bool,
        first: [u32; SET],
    },
    Sobol,
}

impl Sequence {
    /// That of a pixel.
    pub fn halton(pixel_center: bool, seed: u64) -> Self {
        Sequence::Halton { pixel_center, first: halton::seeds(0, seed) }
    }

    /// The numbers of a set of dimensions.
    pub fn numbers(&self, set: u32, index: u32, count: u32, seed: u64) -> [f64; SET] {
        match Simd::best().kind() {
            SimdKind::Portable => self.numbers_portable(set, index, count, seed),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `Simd` says what the processor has.
            #[allow(unsafe_code)]
            SimdKind::Avx2 | SimdKind::Avx512 => unsafe { self.numbers_avx2(set, index, count, seed) },
        }
    }

    /// The same numbers, in fewer instructions.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn numbers_avx2(&self, set: u32, index: u32, count: u32, seed: u64) -> [f64; SET] {
        match self {
            Sequence::Sobol => sobol::avx2::numbers(set, index, seed),
            Sequence::Halton { first, .. } => {
                let seeds = halton::seeds_of_set(set, first, seed);
                halton::avx2::numbers(set, index, count, &seeds)
                    .unwrap_or_else(|| beyond_halton(set, index, seed))
            }
        }
    }

    fn numbers_portable(&self, set: u32, index: u32, count: u32, seed: u64) -> [f64; SET] {
        match self {
            Sequence::Sobol => sobol::numbers(set, index, seed),
            Sequence::Halton { first, .. } => {
                let seeds = halton::seeds_of_set(set, first, seed);
                halton::numbers(set, index, count, &seeds).unwrap_or_else(|| beyond_halton(set, index, seed))
            }
        }
    }
}

/// One dimension of eight points of Halton's sequence, in as many pixels; `None` where there is no faster way to them than
/// [`Sequence::numbers`].
pub(super) fn halton_points(
    dimension: u32,
    indices: &[u32; LANES],
    count: u32,
    seeds: &halton::Seeds,
) -> Option<[f64; LANES]> {
    match Simd::best().kind() {
        SimdKind::Portable => {
            let _ = (dimension, indices, count, seeds);
            None
        }
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        #[allow(unsafe_code)]
        SimdKind::Avx2 | SimdKind::Avx512 => unsafe {
            halton::avx2::points(dimension, indices, count, seeds)
        },
    }
}

/// Beyond the sequence its numbers are random.
#[cold]
fn beyond_halton(set: u32, index: u32, seed: u64) -> [f64; SET] {
    from_fn(|lane| {
        let hash = hash(seed, set * SET as u32 + lane as u32);
        unit(mix(hash ^ u64::from(index) << 32))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// To the bit, also beyond the points and dimensions that there are. Where the processor has no more, it says nothing.
    #[test]
    fn numbers_are_the_same_with_any_instructions() {
        const MOST: u32 = (1 << 31) - 1;
        let chosen =
            [(0, 1), (77, 100), (65_535, 1 << 16), (1 << 16, 1 << 30), (9, 4), (MOST, u32::MAX), (MOST, 1)];
        let beyond = [(MOST + 1, u32::MAX), (u32::MAX, u32::MAX), (u32::MAX, 1)];
        let random = (0..200).map(|k| {
            let bits = mix(k);
            // Of all sizes.
            ((bits as u32) >> (k % 32), ((bits >> 32) as u32) >> (k / 5 % 32))
        });
        let places: Vec<(u32, u32)> = chosen.into_iter().chain(beyond).chain(random).collect();
        for is_halton in [false, true] {
            for set in (0..20).chain([31, 32, 1000]) {
                for (k, &(index, count)) in (0..).zip(&places) {
                    let seed = mix(u64::from(set) << 32 | k);
                    let sequence = if is_halton { Sequence::halton(false, seed) } else { Sequence::Sobol };
                    let numbers = sequence.numbers(set, index, count, seed);
                    let portable = sequence.numbers_portable(set, index, count, seed);
                    assert_eq!(
                        numbers.map(f64::to_bits),
                        portable.map(f64::to_bits),
                        "{sequence:?} {set} {index} {count}"
                    );
                }
            }
        }
    }

    /// To the bit, in all dimensions that there are.
    #[test]
    fn points_of_several_pixels_have_the_same_numbers() {
        const MOST: u32 = (1 << 31) - 1;
        for dimension in 0..16 * SET as u32 {
            for count in [1, 5, 64, 100_000, MOST] {
                let bits: [u64; LANES] =
                    from_fn(|lane| mix(u64::from(dimension) << 40 | u64::from(count) << 8 | lane as u64));
                let seeds = if dimension.is_multiple_of(2) { bits } else { [bits[0]; LANES] };
                let indices = bits.map(|bits| bits as u32 % count);
                let Some(points) = halton_points(dimension, &indices, count, &halton::Seeds::new(seeds))
                else {
                    continue;
                };
                for lane in 0..LANES {
                    let sequence = Sequence::halton(false, seeds[lane]);
                    let (set, at) = (dimension / SET as u32, dimension as usize % SET);
                    let own = sequence.numbers(set, indices[lane], count, seeds[lane])[at];
                    assert_eq!(points[lane].to_bits(), own.to_bits(), "{dimension} {count}");
                }
            }
        }
        let seeds = halton::Seeds::new([0; LANES]);
        assert!(halton_points(0, &[1 << 31; LANES], u32::MAX, &seeds).is_none());
        assert!(halton_points(128, &[0; LANES], 1, &seeds).is_none());
    }
}
