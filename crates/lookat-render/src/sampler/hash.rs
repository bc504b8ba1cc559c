//! Hashes of numbers, one by one and side by side.

use fearless_simd::{Simd, f64x8, prelude::*, u32x8, u64x8};

/// The seed of a pixel or of another place.
pub(super) fn of_place(seed: u64, place: u64) -> u64 {
    mix(mix(seed ^ 0x9e37_79b9_7f4a_7c15) ^ place)
}

/// Chooses the scramble of one dimension of a pixel.
pub(super) fn of_dimension(seed: u64, dimension: u32) -> u64 {
    mix(seed ^ (u64::from(dimension) << 32 | 0x5bd1))
}

/// A random number of sample `index`.
pub(super) fn random(seed: u64, dimension: u32, index: u32) -> f64 {
    unit(mix(of_dimension(seed, dimension) ^ u64::from(index) << 32))
}

/// The largest number below one.
pub(super) const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// 52 bits as a number: the middle of one of 2^52 equal steps from 0 to 1. It is never 0, which would choose what has next to no
/// probability.
pub(super) fn unit(bits: u64) -> f64 {
    f64::from_bits(bits >> 12 | 1.0_f64.to_bits()) - BELOW_ONE
}

/// The same of 32 bits side by side. A hash of them and of the scramble gives 20 more: enough to choose one of a million, and to use what
/// is left of the number.
#[inline(always)]
pub(super) fn units<S: Simd>(bits: u32x8<S>, scramble: u32x8<S>) -> f64x8<S> {
    let all = widened(bits) << 20 | widened(lowbias(bits ^ scramble)) >> 12 | 1.0_f64.to_bits();
    let above_one: f64x8<S> = all.bitcast();
    above_one - BELOW_ONE
}

/// Spreads every bit over all bits (Stafford's variant 13 of the finaliser of MurmurHash3).
pub(super) fn mix(mut x: u64) -> u64 {
    x ^= x >> 30;
    x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^= x >> 27;
    x = x.wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// The same of 32 bits (Wellons's hash "lowbias32").
#[inline(always)]
pub(super) fn lowbias<S: Simd>(mut x: u32x8<S>) -> u32x8<S> {
    x ^= x >> 16;
    x *= 0x7feb_352d;
    x ^= x >> 15;
    x *= 0x846c_a68b;
    x ^ x >> 16
}

/// Owen's scramble of numbers whose bits are in reverse; that of `sobol_burley` (Burley, "Practical Hash-based Owen Scrambling", JCGT
/// 9(4), 2020).
#[inline(always)]
pub(super) fn owen_scramble_rev<S: Simd>(mut x: u32x8<S>, scramble: u32x8<S>) -> u32x8<S> {
    x ^= x * 0x3d20_adea;
    x += scramble;
    x *= scramble >> 16 | 1;
    x ^= x * 0x0552_6c56;
    x ^ (x * 0x53a2_2864)
}

/// The bits in reverse.
#[inline(always)]
pub(super) fn reversed<S: Simd>(mut x: u32x8<S>) -> u32x8<S> {
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

#[cfg(test)]
mod tests {
    use sobol_burley::parts;

    use super::*;
    use crate::testing::baseline;

    /// So what has less than half a step of probability is not chosen, wherever it comes.
    #[test]
    fn numbers_are_the_middles_of_steps() {
        const STEP: f64 = f64::EPSILON;
        assert_eq!([0, u64::MAX].map(unit), [0.5 * STEP, 1.0 - 0.5 * STEP]);
        assert_eq!(unit(5 << 12), 5.5 * STEP);
        assert_eq!(unit(1 << 63), 0.5 + 0.5 * STEP);
    }

    #[test]
    fn side_by_side_is_as_one_by_one() {
        for k in 0..10_000 {
            let bits = mix(k);
            let (a, b) = (bits as u32 >> (k % 32), (bits >> 32) as u32 >> (k / 32 % 32));
            baseline!(simd => {
                let (x, y): (u32x8<_>, u32x8<_>) = (a.simd_into(simd), b.simd_into(simd));
                assert_eq!(owen_scramble_rev(x, y)[3], parts::owen_scramble_rev(a, b));
                assert_eq!(reversed(x)[5], a.reverse_bits());
                let more = u64::from(lowbias(x ^ y)[6]);
                assert_eq!(units(x, y)[6], unit(u64::from(a) << 32 | more));
            });
        }
    }
}
