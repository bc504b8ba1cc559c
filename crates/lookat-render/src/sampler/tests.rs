use super::*;
use crate::testing::baseline;
use sobol_burley::parts;

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
