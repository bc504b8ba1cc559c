//! The Halton sequence, scrambled after Owen.

use fearless_simd::{Simd, f64x8, prelude::*, u32x8};

use super::hash::{BELOW_ONE, high, lowbias, owen_scramble_rev, reversed, to_f64, units};
use crate::number::LANES;

/// The numbers of points of the sequence in a dimension, where `count` points are taken of it. `None` beyond the dimensions, or the
/// points, that there are.
#[inline(always)]
pub(super) fn numbers<S: Simd>(
    simd: S,
    dimension: u32,
    (indices, count): ([u32; LANES], u32),
    [low, upper]: [u32x8<S>; 2],
) -> Option<f64x8<S>> {
    let base = BASES.get(dimension as usize)?;
    if count > MOST + 1 {
        return None;
    }
    let scrambles = lowbias(low ^ lowbias(upper ^ dimension));
    Some(base.scrambled_radical_inverse(indices.simd_into(simd), count, scrambles))
}

/// The base of a dimension.
#[derive(Debug, Clone, Copy)]
struct Base {
    prime: u32,
    inverse: f64,
    /// A power of two from 2^32 on over the prime, rounded up, and the exponent beyond 32.
    reciprocal: u32,
    exponent: u32,
}

/// The highest index that [`Base::quotient`] divides.
const MOST: u32 = (1 << 31) - 1;

impl Base {
    const fn new(prime: u32) -> Self {
        let exponent = (prime - 1).ilog2();
        let reciprocal =
            if prime == 2 { 0 } else { (1_u64 << (32 + exponent)).div_ceil(prime as u64) as u32 };
        Base { prime, inverse: 1.0 / prime as f64, reciprocal, exponent }
    }

    /// The radical inverses of indices with their digits permuted after Owen: each by the digits before it. Digits beyond those
    /// that tell `count` indices apart are random.
    ///
    /// The permutations are the affine maps modulo the base, a prime. Any two digits go to any two others with the same
    /// probability under them, which is all that the variance of Owen's scrambling depends on.
    #[inline(always)]
    fn scrambled_radical_inverse<S: Simd>(
        &self,
        index: u32x8<S>,
        count: u32,
        scrambles: u32x8<S>,
    ) -> f64x8<S> {
        let simd = index.token();
        if self.prime == 2 {
            // All digits at once.
            return units(reversed(owen_scramble_rev(index, scrambles)), scrambles);
        }
        let prime = u32x8::splat(simd, self.prime);
        // `rest` of the index is above the digits before, and `power` above all numbers with so many digits.
        let (mut rest, mut power) = (index, 1_u32);
        let (mut number, mut scale) = (f64x8::splat(simd, 0.0), 1.0);
        let mut told = 1_u64;
        while told < u64::from(count) {
            // The digits before, with a leading one: no two that differ have the same, whatever their lengths. It may
            // overflow only below the digits that are needed.
            let before = index + power - rest * power;
            let random = lowbias(scrambles ^ before);
            let factor = high(random << 16 | random >> 16, prime - 1) + 1;
            let above = self.quotient(rest);
            let image = (rest - above * prime) * factor + high(random, prime);
            let digit = image - self.quotient(image) * prime;
            rest = above;
            power = power.wrapping_mul(self.prime);
            scale *= self.inverse;
            number += to_f64(digit) * scale;
            told *= u64::from(self.prime);
        }
        let beyond = units(lowbias(scrambles ^ (index + power)), scrambles);
        (number + beyond * scale).min(BELOW_ONE)
    }

    /// Numbers of at most [`MOST`] over the prime, rounded down, without a division: the reciprocal is off by less than 2^-31
    /// of itself (Granlund and Montgomery, "Division by Invariant Integers using Multiplication", 1994).
    #[inline(always)]
    fn quotient<S: Simd>(&self, x: u32x8<S>) -> u32x8<S> {
        high(x, self.reciprocal.simd_into(x.token())) >> self.exponent
    }
}

/// The bases of the Halton sequence: the first primes.
static BASES: [Base; 128] = bases();

const fn bases() -> [Base; 128] {
    let mut bases = [Base::new(2); 128];
    let (mut found, mut candidate) = (1, 3);
    while found < bases.len() {
        let mut at = 0;
        while at < found && candidate % bases[at].prime != 0 {
            at += 1;
        }
        if at == found {
            bases[found] = Base::new(candidate);
            found += 1;
        }
        candidate += 2;
    }
    bases
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::baseline;

    /// Numbers in one dimension, with a scramble.
    fn scrambled(prime: u32, indices: impl Iterator<Item = u32>, count: u32, seed: u32) -> Vec<f64> {
        baseline!(simd => {
            let scrambles = lowbias(seed.simd_into(simd));
            let of = |index: u32| {
                Base::new(prime).scrambled_radical_inverse(index.simd_into(simd), count, scrambles)[0]
            };
            indices.map(of).collect()
        })
    }

    fn of_seed(dimension: u32, indices: std::ops::Range<u32>, count: u32, seed: u64) -> Option<Vec<f64>> {
        baseline!(simd => {
            let seeds = [(seed as u32).simd_into(simd), ((seed >> 32) as u32).simd_into(simd)];
            indices.map(|index| Some(numbers(simd, dimension, ([index; LANES], count), seeds)?[0])).collect()
        })
    }

    /// Wherever a block of the sequence begins, it has one point in each stratum.
    #[test]
    fn blocks_of_halton_are_stratified() {
        for (prime, digits) in [(2, 6), (3, 4), (5, 3), (7, 2), (719, 1)] {
            let size: u32 = u32::pow(prime, digits);
            let last = MOST / size - 1;
            for block in [0, 1, 2, last] {
                let mut strata = vec![0; size as usize];
                for number in scrambled(prime, block * size..(block + 1) * size, MOST, 7) {
                    strata[(number * f64::from(size)) as usize] += 1;
                }
                assert!(strata.iter().all(|count| *count == 1), "{prime} {block}: {strata:?}");
            }
        }
    }

    /// Each dimension has a base and a scramble of its own.
    #[test]
    fn all_dimensions_are_stratified() {
        for (dimension, Base { prime, .. }) in (0..).zip(&BASES) {
            let numbers = |seed| of_seed(dimension, 0..*prime, *prime, seed).unwrap();
            let mut strata: Vec<u32> = numbers(5).iter().map(|x| (x * f64::from(*prime)) as u32).collect();
            strata.sort_unstable();
            assert_eq!(strata, (0..*prime).collect::<Vec<_>>());
            assert_ne!(numbers(5), numbers(6));
            assert_ne!(numbers(5), numbers(5 | 1 << 32));
        }
        assert!(of_seed(BASES.len() as u32, 0..1, 1, 0).is_none() && of_seed(0, 0..1, MOST + 2, 0).is_none());
    }

    /// The permutations of the first digits, and of second digits after different first ones, have nothing in common.
    #[test]
    fn permutations_of_digits_are_independent() {
        for prime in [2_u32, 3, 7] {
            let (n, tries) = (prime as usize, 20_000_u32);
            let mut counts = [vec![0_u32; n * n], vec![0_u32; n * n]];
            for i in 0..tries {
                let digits: Vec<_> = scrambled(prime, 0..2, prime * prime, i)
                    .into_iter()
                    .map(|number| {
                        let first = (number * f64::from(prime)) as usize;
                        (first, (number * f64::from(prime * prime)) as usize % n)
                    })
                    .collect();
                let (here, there) = (digits[0], digits[1]);
                counts[0][here.0 * n + here.1] += 1;
                counts[1][here.1 * n + there.1] += 1;
            }
            let expected = tries as f64 / (n * n) as f64;
            for counts in counts {
                let chi_square: f64 =
                    counts.iter().map(|n| (f64::from(*n) - expected).powi(2) / expected).sum();
                // Mean and five standard deviations.
                let freedom = (n * n - 1) as f64;
                assert!(chi_square < freedom + 5.0 * (2.0 * freedom).sqrt(), "{prime}: {chi_square}");
            }
        }
    }

    #[test]
    fn quotients_need_no_division() {
        for base in &BASES[1..] {
            let (prime, end) = (base.prime, MOST + 1);
            baseline!(simd => for x in (0..prime * prime).chain(end - 2 * prime..end) {
                assert_eq!(base.quotient(u32x8::splat(simd, x))[0], x / prime, "{prime}");
            });
        }
    }
}
