//! Owen-scrambled Sobol' points.
//!
//! The first 23 bits of each number equal the number of `sobol_burley` (Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4),
//! 2020; direction numbers of Joe and Kuo).

use std::array::from_fn;
use std::sync::LazyLock;

use fearless_simd::{Simd, f64x8, prelude::*, u32x8};
use sobol_burley::NUM_DIMENSIONS;
use sobol_burley::parts::sobol_rev;

use super::hash::{lowbias, mix, owen_scramble_rev, reversed, units};
use crate::number::LANES;

/// For each dimension, what each bit of the upper half of an index adds to the points.
static DIRECTIONS: LazyLock<Vec<[u32; 16]>> = LazyLock::new(|| {
    (0..NUM_DIMENSIONS).map(|dimension| from_fn(|bit| sobol_rev(1 << (16 + bit), dimension))).collect()
});

/// Points of the sequence, shuffled and to be scrambled: what all dimensions share.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Shuffled {
    seeds: [u32; LANES],
    indices: [u32; LANES],
}

impl Shuffled {
    /// `seeds` choose the scrambles. The sequence has 2^16 points; beyond them others, scrambled on their own, take over. `turn`: how
    /// many times all its dimensions have been taken.
    #[inline(always)]
    pub fn new<S: Simd>(simd: S, turn: u32, indices: [u32; LANES], seeds: [u64; LANES]) -> Self {
        let own = |index: u32| u64::from(index >> 16) << 32 | u64::from(turn);
        let seeds: [u32; LANES] = from_fn(|lane| mix(seeds[lane] ^ own(indices[lane])) as u32);
        let indices: u32x8<S> = indices.simd_into(simd);
        // The bits of what is scrambled are in reverse.
        let scramble = hash(u32x8::from_slice(simd, &seeds) ^ 0x79c6_8e4a);
        let shuffled = owen_scramble_rev(reversed(indices & 0xffff), scramble) >> 16;
        Shuffled { seeds, indices: shuffled.to_array() }
    }
}

/// The numbers of points in a dimension. `first`: the points as the first dimensions shuffle them.
#[inline(always)]
pub(super) fn numbers<S: Simd>(
    simd: S,
    dimension: u32,
    (indices, seeds): ([u32; LANES], impl Fn() -> [u64; LANES]),
    first: &Shuffled,
) -> f64x8<S> {
    let (turn, dimension) = (dimension / NUM_DIMENSIONS, dimension % NUM_DIMENSIONS);
    let points = if turn == 0 { *first } else { Shuffled::new(simd, turn, indices, seeds()) };
    let (seeds, shuffled): (u32x8<S>, u32x8<S>) =
        (points.seeds.simd_into(simd), points.indices.simd_into(simd));
    let mut point: u32x8<S> = 0.simd_into(simd);
    for (bit, direction) in DIRECTIONS[dimension as usize].iter().enumerate() {
        // All bits where this one is set.
        let is_set = u32x8::splat(simd, 0) - (shuffled >> bit as u32 & 1);
        point ^= is_set & *direction;
    }
    // As in `sobol_burley`, for each of four dimensions.
    const SCRAMBLES: [u32; 4] = [0x912f_69ba, 0x174f_18ab, 0x691e_72ca, 0xb40c_c1b8];
    let own = SCRAMBLES[dimension as usize % 4] ^ (dimension / 4);
    let scramble = hash((seeds * 0x9c8f_2d3b) ^ own);
    units(reversed(owen_scramble_rev(point, scramble)), scramble)
}

/// That of `sobol_burley`.
#[inline(always)]
fn hash<S: Simd>(x: u32x8<S>) -> u32x8<S> {
    lowbias(x ^ 0xe6fe_3beb)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::baseline;

    /// A number, rounded down to the 23 bits of the library.
    fn number(dimension: u32, index: u32, seed: u64) -> f64 {
        const STEPS: f64 = (1 << 23) as f64;
        let number = baseline!(simd => {
            let (indices, seeds) = ([index; LANES], [seed; LANES]);
            numbers(simd, dimension, (indices, || seeds), &Shuffled::new(simd, 0, indices, seeds))[0]
        });
        (number * STEPS).floor() / STEPS
    }

    #[test]
    fn numbers_are_those_of_the_library() {
        for seed in 0..20 {
            let own = mix(seed) as u32;
            for dimension in 0..NUM_DIMENSIONS {
                for index in (0..64).chain([77, 4096, 40_001, 65_535]) {
                    let library = sobol_burley::sample(index, dimension, own);
                    assert_eq!(
                        number(dimension, index, seed),
                        f64::from(library),
                        "{seed} {dimension} {index}"
                    );
                }
            }
        }
        // Beyond, they are those of another scramble.
        for (dimension, index) in [(NUM_DIMENSIONS + 27, 5), (27, (1 << 16) + 5)] {
            let (round, beyond) = (u64::from(index >> 16), u64::from(dimension / NUM_DIMENSIONS));
            let own = mix(7 ^ (round << 32 | beyond)) as u32;
            assert_eq!(number(dimension, index, 7), f64::from(sobol_burley::sample(5, 27, own)));
        }
    }
}
