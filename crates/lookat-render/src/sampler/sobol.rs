//! Owen-scrambled Sobol' points, eight dimensions at a time.
//!
//! The numbers are those of `sobol_burley` (Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020; direction
//! numbers of Joe and Kuo). Here the bits of an index are looked up by fours, and twice as many dimensions are scrambled at
//! once.

#[cfg(target_arch = "x86_64")]
pub(super) mod avx2;

use std::array::from_fn;
use std::sync::LazyLock;

use sobol_burley::NUM_DIMENSIONS;
use sobol_burley::parts::{hash, owen_scramble_rev, sobol_rev};

use super::{SET, mix};

/// Sets of dimensions that there are; beyond them others, scrambled on their own, take over.
const SETS: u32 = NUM_DIMENSIONS / SET as u32;

/// For each set, each four bits of the upper half of an index and all that these may be: what they add to the points.
type Table = Vec<[[[u32; SET]; 16]; 4]>;

static TABLE: LazyLock<Table> = LazyLock::new(|| {
    let added = |set: u32, quarter: usize, bits: u32| -> [u32; SET] {
        from_fn(|lane| sobol_rev(bits << (16 + 4 * quarter), set * SET as u32 + lane as u32))
    };
    (0..SETS).map(|set| from_fn(|quarter| from_fn(|bits| added(set, quarter, bits as u32)))).collect()
});

/// The numbers of a point in the dimensions of a set. `seed` chooses the scramble. The sequence has 2^16 points; beyond them
/// others, scrambled on their own, take over too.
pub(super) fn numbers(set: u32, index: u32, seed: u64) -> [f64; SET] {
    let Place { added, own } = Place::new(set, index, seed);
    from_fn(|lane| {
        let point = added.iter().fold(0, |point, added| point ^ added[lane]);
        let bits = owen_scramble_rev(point, hash(own ^ SCRAMBLES[lane])).reverse_bits() >> 9;
        f64::from(bits) * SCALE
    })
}

/// Where the numbers of a point come from.
struct Place {
    /// What the bits of its shuffled index add to it, by fours.
    added: [&'static [u32; SET]; 4],
    /// What chooses its scrambles.
    own: u32,
}

impl Place {
    #[inline(always)]
    fn new(set: u32, index: u32, seed: u64) -> Self {
        let (round, within) = (index >> 16, index & 0xffff);
        let seed = mix(seed ^ (u64::from(round) << 32 | u64::from(set / SETS))) as u32;
        // The bits of what is scrambled are in reverse.
        let shuffled = owen_scramble_rev(within.reverse_bits(), hash(seed ^ 0x79c6_8e4a)) >> 16;
        let set = set % SETS;
        let quarters = &TABLE[set as usize];
        let added = from_fn(|at| &quarters[at][(shuffled >> (4 * at)) as usize % 16]);
        Place { added, own: seed.wrapping_mul(0x9c8f_2d3b) ^ (2 * set) }
    }
}

/// Makes a number below one of 23 bits.
const SCALE: f64 = 1.0 / 8_388_608.0;

/// As in `sobol_burley`, for each of four dimensions and the next four.
const SCRAMBLES: [u32; SET] = {
    let [a, b, c, d] = [0x912f_69ba, 0x174f_18ab, 0x691e_72ca, 0xb40c_c1b8];
    [a, b, c, d, a ^ 1, b ^ 1, c ^ 1, d ^ 1]
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_library() {
        for seed in 0..20 {
            let own = mix(seed) as u32;
            for set in 0..SETS {
                for index in (0..64).chain([77, 4096, 40_001, 65_535]) {
                    let found = numbers(set, index, seed);
                    let library: Vec<f64> = (0..SET as u32)
                        .map(|lane| sobol_burley::sample(index, set * SET as u32 + lane, own).into())
                        .collect();
                    assert_eq!(found.to_vec(), library, "{seed} {set} {index}");
                }
            }
        }
        // Beyond, they are those of another scramble.
        for (set, index) in [(SETS + 3, 5), (3, (1 << 16) + 5)] {
            let (round, beyond) = (u64::from(index >> 16), u64::from(set / SETS));
            let own = mix(7 ^ (round << 32 | beyond)) as u32;
            let library: Vec<f64> =
                (0..8).map(|lane| sobol_burley::sample(5, 3 * 8 + lane, own).into()).collect();
            assert_eq!(numbers(set, index, 7).to_vec(), library);
        }
    }
}
