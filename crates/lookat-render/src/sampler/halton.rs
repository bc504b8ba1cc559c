//! The Halton sequence, scrambled after Owen.

use super::unit;

/// The number of a point of the sequence in one dimension, where `count` points are taken of it. `hash` chooses the scramble.
/// `None` beyond the dimensions that there are.
#[inline(always)]
pub(super) fn number(dimension: u32, index: u32, count: u32, hash: u64) -> Option<f64> {
    BASES.get(dimension as usize).map(|base| match base {
        Base { prime: 2, .. } => scrambled_van_der_corput(index, hash as u32),
        base => scrambled_radical_inverse(base, index, count, hash),
    })
}

/// The radical inverse of `index` with its digits permuted after Owen: each by the digits before it. Digits beyond those
/// that tell `count` indices apart are random.
///
/// The permutations are the affine maps modulo the base, a prime. Any two digits go to any two others with the same
/// probability under them, which is all that the variance of Owen's scrambling depends on.
#[inline(always)]
fn scrambled_radical_inverse(base: &Base, index: u32, count: u32, hash: u64) -> f64 {
    let below = |bits: u64, n: u32| ((bits & 0xffff_ffff) * u64::from(n)) >> 32;
    let (index, prime) = (u64::from(index), u64::from(base.prime));
    // `rest` of the index is above the digits before, and `power` above all numbers with so many digits.
    let (mut rest, mut power) = (index, 1);
    let (mut digits, mut scale) = (0, 1.0);
    while power < u64::from(count) {
        // The digits before, with a leading one: no two that differ have the same, whatever their lengths.
        let random = fold(hash ^ (power + index - rest * power));
        let (factor, shift) = (1 + below(random >> 32, base.prime - 1), below(random, base.prime));
        let above = base.quotient(rest);
        let image = (rest - above * prime) * factor + shift;
        digits = digits * prime + image - base.quotient(image) * prime;
        (rest, power, scale) = (above, power * prime, scale * base.inverse);
    }
    let beyond = unit(fold(hash ^ (power + index)));
    ((digits as i64 as f64 + beyond) * scale).min(BELOW_ONE)
}

/// The same in base 2, all digits at once (Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020, with the
/// constants of Vegdahl).
#[inline(always)]
fn scrambled_van_der_corput(index: u32, seed: u32) -> f64 {
    // The digits of the index count from its lowest bit, as the scrambling does.
    let mut x = index;
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    f64::from(x.reverse_bits()) * (0.5 / f64::from(1_u32 << 31))
}

/// The largest number below one.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// Spreads every bit over all bits (the folded product of Yi's wyhash). Neighbours are first torn apart, for both factors
/// hold the same number.
fn fold(x: u64) -> u64 {
    let x = x.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let product = u128::from(x ^ 0xa076_1d64_78bd_642f) * u128::from(x ^ 0xe703_7ed1_a0b4_28db);
    (product >> 64) as u64 ^ product as u64
}

/// A base of the Halton sequence.
#[derive(Debug, Clone, Copy)]
struct Base {
    prime: u32,
    inverse: f64,
    /// 2^64 over the prime, rounded up.
    reciprocal: u64,
}

impl Base {
    const fn new(prime: u32) -> Self {
        Base { prime, inverse: 1.0 / prime as f64, reciprocal: u64::MAX / prime as u64 + 1 }
    }

    /// A number below 2^32 over the prime, rounded down, without a division (Lemire, Kaser and Kurz, "Faster Remainder by
    /// Direct Computation", 2019).
    fn quotient(&self, x: u64) -> u64 {
        ((u128::from(x) * u128::from(self.reciprocal)) >> 64) as u64
    }
}

/// The bases of the Halton sequence.
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
    use super::super::mix;
    use super::*;

    /// Wherever a block of the sequence begins, it has one point in each stratum.
    #[test]
    fn blocks_of_halton_are_stratified() {
        for (prime, digits) in [(3, 4), (5, 3), (7, 2), (719, 1)] {
            let (base, size) = (Base::new(prime), prime.pow(digits));
            let last = u32::MAX / size - 1;
            for block in [0, 1, 2, last] {
                let mut strata = vec![0; size as usize];
                for index in block * size..(block + 1) * size {
                    let number = scrambled_radical_inverse(&base, index, u32::MAX, mix(7));
                    strata[(number * f64::from(size)) as usize] += 1;
                }
                assert!(strata.iter().all(|count| *count == 1), "{prime} {block}: {strata:?}");
            }
        }
    }

    /// The permutations of the first digits, and of second digits after different first ones, have nothing in common.
    #[test]
    fn permutations_of_digits_are_independent() {
        for prime in [3_u32, 7] {
            let (n, tries) = (prime as usize, 20_000_u64);
            let (base, mut counts) = (Base::new(prime), [vec![0_u32; n * n], vec![0_u32; n * n]]);
            for i in 0..tries {
                let digits = |index| {
                    let number = scrambled_radical_inverse(&base, index, prime * prime, mix(i));
                    ((number * f64::from(prime)) as usize, (number * f64::from(prime * prime)) as usize % n)
                };
                let (here, there) = (digits(0), digits(1));
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
        for base in &BASES {
            let (prime, end) = (u64::from(base.prime), 1_u64 << 32);
            let mut numbers = (0..prime * prime).chain(end - 2 * prime..end);
            assert!(numbers.all(|x| base.quotient(x) == x / prime), "{prime}");
        }
    }
}
