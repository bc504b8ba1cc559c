//! Low-discrepancy sequences: the numbers of several dimensions at once.

use std::array::from_fn;

use super::{LANES, halton, hash, mix, sobol, unit};
use crate::arithmetic::{Simd, SimdKind};

/// Which sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sequence {
    /// With the seeds of the first set of a pixel, which all its samples take.
    Halton {
        pixel_center: bool,
        first: [u32; LANES],
    },
    Sobol,
}

impl Sequence {
    /// That of a pixel.
    pub fn halton(pixel_center: bool, seed: u64) -> Self {
        Sequence::Halton { pixel_center, first: halton::seeds(0, seed) }
    }

    /// The numbers of a set of dimensions.
    pub fn numbers(&self, set: u32, index: u32, count: u32, seed: u64) -> [f64; LANES] {
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
    fn numbers_avx2(&self, set: u32, index: u32, count: u32, seed: u64) -> [f64; LANES] {
        match self {
            Sequence::Sobol => sobol::avx2::numbers(set, index, seed),
            Sequence::Halton { first, .. } => {
                let seeds = halton::seeds_of_set(set, first, seed);
                halton::avx2::numbers(set, index, count, &seeds)
                    .unwrap_or_else(|| beyond_halton(set, index, seed))
            }
        }
    }

    fn numbers_portable(&self, set: u32, index: u32, count: u32, seed: u64) -> [f64; LANES] {
        match self {
            Sequence::Sobol => sobol::numbers(set, index, seed),
            Sequence::Halton { first, .. } => {
                let seeds = halton::seeds_of_set(set, first, seed);
                halton::numbers(set, index, count, &seeds).unwrap_or_else(|| beyond_halton(set, index, seed))
            }
        }
    }
}

/// Beyond the sequence its numbers are random.
#[cold]
fn beyond_halton(set: u32, index: u32, seed: u64) -> [f64; LANES] {
    from_fn(|lane| {
        let hash = hash(seed, set * LANES as u32 + lane as u32);
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
}
