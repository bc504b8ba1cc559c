//! Order statistics without sorting.

use rayon::prelude::*;

/// The number of low bits of a float that the second pass looks at, of 31 without the sign.
const LOW_BITS: u32 = 15;
const LOW: u32 = (1 << LOW_BITS) - 1;
const GRAIN: usize = 1 << 18;

/// The smallest number of values that are at least the given share of `count`: the nearest rank, from 1 to
/// `count`. The share is in 0..1.
pub(crate) fn nearest_rank(share: f64, count: usize) -> usize {
    // A share such as 0.99 is not exact, and 0.99 * 100 is not to become 100.
    ((share * count as f64 * (1.0 - f64::EPSILON)).ceil() as usize).clamp(1, count.max(1))
}

/// The value with the given rank, 1 for the smallest, among the values at all of `count` places. None is negative; NaN
/// counts as the largest. 0 if there are none.
///
/// Floats that are not negative sort as their bits do. So two histograms are enough, of the high bits and of
/// the low bits below the right high ones, and the values need not be kept.
pub(crate) fn ranked<const N: usize>(
    count: usize,
    values: impl Fn(usize) -> [f32; N] + Sync,
    rank: usize,
) -> f32 {
    let bits = |place: usize| values(place).map(|value| value.abs().to_bits());
    let (high, rank) = bin_of(&counts(count, |place| bits(place).map(|bits| Some(bits >> LOW_BITS))), rank);
    let below = |bits: u32| (bits >> LOW_BITS == high).then_some(bits & LOW);
    let (low, _) = bin_of(&counts(count, |place| bits(place).map(below)), rank);
    f32::from_bits(high << LOW_BITS | low)
}

/// How often each key below 2^16 occurs.
fn counts<const N: usize>(count: usize, keys: impl Fn(usize) -> [Option<u32>; N] + Sync) -> Vec<u64> {
    let empty = || vec![0_u64; 1 << 16];
    let tally = |mut counts: Vec<u64>, block: usize| {
        for place in block * GRAIN..count.min((block + 1) * GRAIN) {
            keys(place).into_iter().flatten().for_each(|key| counts[key as usize] += 1);
        }
        counts
    };
    let add = |a: Vec<u64>, b: Vec<u64>| a.iter().zip(b).map(|(a, b)| a + b).collect();
    (0..count.div_ceil(GRAIN)).into_par_iter().fold(empty, tally).reduce(empty, add)
}

/// The bin that holds the given rank, and the rank within that bin. (0, 1) past the end.
fn bin_of(counts: &[u64], rank: usize) -> (u32, usize) {
    let mut left = rank as u64;
    for (bin, &count) in (0..).zip(counts) {
        if left <= count {
            return (bin, left as usize);
        }
        left -= count;
    }
    (0, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_what_sorting_finds() {
        let mut hash = 1_u32;
        let mut next = || {
            hash = hash.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            // Some equal numbers, some that differ in the last bit, over many orders of magnitude.
            f32::from_bits((hash >> 31) * 0x3f80_0000 + (hash >> 10 & 0x7fff) * (1 << (hash >> 5 & 15)))
        };
        let items: Vec<[f32; 2]> = (0..500).map(|_| [next(), next()]).collect();
        let mut sorted = items.as_flattened().to_vec();
        sorted.sort_by(f32::total_cmp);
        for (i, &expected) in sorted.iter().enumerate() {
            assert_eq!(ranked(items.len(), |i| items[i], i + 1), expected, "{i}");
        }
    }

    #[test]
    fn odd_values_have_a_place() {
        let items = [[f32::NAN], [-0.0], [f32::INFINITY], [2.0]];
        assert_eq!(ranked(items.len(), |i| items[i], 1), 0.0);
        assert_eq!(ranked(items.len(), |i| items[i], 2), 2.0);
        assert_eq!(ranked(items.len(), |i| items[i], 3), f32::INFINITY);
        assert!(ranked(items.len(), |i| items[i], 4).is_nan());
        assert_eq!(ranked(0, |i| items[i], 1), 0.0);
    }

    #[test]
    fn ranks_are_the_nearest() {
        let check =
            |share, count, expected| assert_eq!(nearest_rank(share, count), expected, "{share} {count}");
        check(0.99, 1, 1);
        check(0.99, 100, 99);
        check(0.99, 101, 100);
        check(0.999, 1000, 999);
        check(0.0, 5, 1);
        check(1.0, 5, 5);
        check(0.99, 0, 1);
    }
}
