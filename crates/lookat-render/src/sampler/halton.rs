//! The Halton sequence, scrambled after Owen.

#[cfg(target_arch = "x86_64")]
pub(super) mod avx2;

use sobol_burley::parts::owen_scramble_rev;

use super::SET;
use crate::lanes::LANES;

/// The numbers of a point of the sequence in the dimensions of a set, where `count` points are taken of it. `seeds` are those
/// of the set. `None` beyond the dimensions, or the points, that there are.
pub(super) fn numbers(set: u32, index: u32, count: u32, seeds: &[u32; SET]) -> Option<[f64; SET]> {
    let bases = BASES.get(set as usize).filter(|_| index <= MOST)?;
    Some(scrambled_radical_inverses(bases, index, count, seeds))
}

/// The same in two dimensions alone, from `dimension` on.
pub(super) fn pair(dimension: u32, index: u32, count: u32, seed: u64) -> Option<[f64; 2]> {
    let prime = |at: u32| Some(BASES.get(at as usize / SET)?.prime[at as usize % SET]);
    let bases = Bases::new([prime(dimension)?, prime(dimension + 1)?]);
    (index <= MOST).then(|| scrambled_radical_inverses(&bases, index, count, &seeds(dimension, seed)))
}

/// Seeds of several pixels: their lower and upper halves.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Seeds {
    low: [u32; LANES],
    high: [u32; LANES],
}

impl Seeds {
    #[cfg(test)]
    pub fn new(seeds: [u64; LANES]) -> Self {
        Seeds { low: seeds.map(|seed| seed as u32), high: seeds.map(|seed| (seed >> 32) as u32) }
    }

    #[inline(always)]
    pub fn put(&mut self, lane: usize, seed: u64) {
        (self.low[lane], self.high[lane]) = (seed as u32, (seed >> 32) as u32);
    }

    pub fn lane(&self, lane: usize) -> u64 {
        u64::from(self.high[lane]) << 32 | u64::from(self.low[lane])
    }
}

/// What chooses the scrambles of dimensions. Those of the first set do not change from sample to sample of a pixel.
#[inline(always)]
pub(super) fn seeds<const N: usize>(first: u32, seed: u64) -> [u32; N] {
    let mut seeds = [0; N];
    for lane in 0..N {
        seeds[lane] = lowbias(seed as u32 ^ lowbias((seed >> 32) as u32 ^ (first + NUMBERS[lane])));
    }
    seeds
}

/// Those of a set, where `first` are those of the first.
#[inline(always)]
pub(super) fn seeds_of_set(set: u32, first: &[u32; SET], seed: u64) -> [u32; SET] {
    if set == 0 { *first } else { seeds(set * SET as u32, seed) }
}

/// Of dimensions among their neighbors.
const NUMBERS: [u32; SET] = [0, 1, 2, 3, 4, 5, 6, 7];

/// The radical inverses of `index` with their digits permuted after Owen: each by the digits before it. Digits beyond those
/// that tell `count` indices apart are random.
///
/// The permutations are the affine maps modulo the base, a prime. Any two digits go to any two others with the same
/// probability under them, which is all that the variance of Owen's scrambling depends on.
#[inline(always)]
fn scrambled_radical_inverses<const N: usize>(
    bases: &Bases<N>,
    index: u32,
    count: u32,
    seeds: &[u32; N],
) -> [f64; N] {
    // `rest` of the index is above the digits before, and `power` above all numbers with so many digits.
    let (mut rest, mut power) = ([index; N], [1_u32; N]);
    let (mut number, mut scale) = ([0.0; N], [1.0; N]);
    // The least base but 2 needs the most digits. What the others have too many is random, as it should be.
    let mut least = 1;
    while least < u64::from(count) {
        let mut digit = [0; N];
        for lane in 0..N {
            let prime = bases.prime[lane];
            // The digits before, with a leading one: no two that differ have the same, whatever their lengths. It may
            // overflow only below the digits that are needed.
            let before = power[lane].wrapping_add(index).wrapping_sub(rest[lane].wrapping_mul(power[lane]));
            let random = lowbias(seeds[lane] ^ before);
            let factor = 1 + high(random.rotate_left(16), prime - 1);
            let above = bases.quotient(lane, rest[lane]);
            let image = (rest[lane] - above * prime) * factor + high(random, prime);
            digit[lane] = image - bases.quotient(lane, image) * prime;
            rest[lane] = above;
            power[lane] = power[lane].wrapping_mul(prime);
        }
        for lane in 0..N {
            scale[lane] *= bases.inverse[lane];
            number[lane] += f64::from(digit[lane] as i32) * scale[lane];
        }
        least *= bases.least;
    }
    let mut beyond = [0; N];
    for lane in 0..N {
        beyond[lane] = lowbias(seeds[lane] ^ power[lane].wrapping_add(index)) >> 1;
    }
    for lane in 0..N {
        let beyond = f64::from(beyond[lane] as i32) * (1.0 / f64::from(1_u32 << 31));
        number[lane] = (number[lane] + beyond * scale[lane]).min(BELOW_ONE);
    }
    if bases.begins_with_2() {
        number[0] = scrambled_in_base_2(index, seeds[0]);
    }
    number
}

/// The same in base 2, all digits at once (Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020).
#[inline(always)]
fn scrambled_in_base_2(index: u32, seed: u32) -> f64 {
    f64::from(owen_scramble_rev(index, seed).reverse_bits()) * (1.0 / 4_294_967_296.0)
}

/// The upper half of a product: of a random number, one below `n`.
#[inline(always)]
fn high(x: u32, n: u32) -> u32 {
    ((u64::from(x) * u64::from(n)) >> 32) as u32
}

/// The largest number below one.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// Spreads every bit over all bits (Wellons's hash "lowbias32").
#[inline(always)]
fn lowbias(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

/// Bases of some dimensions.
#[derive(Debug, Clone, Copy)]
struct Bases<const N: usize> {
    prime: [u32; N],
    inverse: [f64; N],
    /// A power of two from 2^32 on over each prime, rounded up, and the exponent beyond 32.
    reciprocal: [u32; N],
    exponent: [u32; N],
    /// The least of those that are computed digit by digit: the first may be 2, which is not.
    least: u64,
}

/// The highest index that [`Bases::quotient`] divides.
const MOST: u32 = (1 << 31) - 1;

impl<const N: usize> Bases<N> {
    const fn new(primes: [u32; N]) -> Self {
        let mut bases = Bases {
            prime: primes,
            inverse: [0.0; N],
            reciprocal: [0; N],
            exponent: [0; N],
            // They are in order.
            least: if primes[0] == 2 { primes[1] as u64 } else { primes[0] as u64 },
        };
        let mut lane = 0;
        while lane < N {
            let prime = primes[lane];
            bases.inverse[lane] = 1.0 / prime as f64;
            bases.exponent[lane] = (prime - 1).ilog2();
            bases.reciprocal[lane] = (1_u64 << (32 + bases.exponent[lane])).div_ceil(prime as u64) as u32;
            lane += 1;
        }
        bases
    }

    #[inline(always)]
    const fn begins_with_2(&self) -> bool {
        self.prime[0] == 2
    }

    /// A number of at most [`MOST`] over a prime, rounded down, without a division: the reciprocal is off by less than 2^-31
    /// of itself (Granlund and Montgomery, "Division by Invariant Integers using Multiplication", 1994).
    #[inline(always)]
    fn quotient(&self, lane: usize, x: u32) -> u32 {
        high(x, self.reciprocal[lane]) >> self.exponent[lane]
    }
}

/// The bases of the Halton sequence, set by set.
static BASES: [Bases<SET>; 16] = bases();

const fn bases() -> [Bases<SET>; 16] {
    let mut primes = [2; 16 * SET];
    let (mut found, mut candidate) = (1, 3);
    while found < primes.len() {
        let mut at = 0;
        while at < found && candidate % primes[at] != 0 {
            at += 1;
        }
        if at == found {
            primes[found] = candidate;
            found += 1;
        }
        candidate += 2;
    }
    let mut bases = [Bases::new([2; SET]); 16];
    let mut set = 0;
    while set < bases.len() {
        let mut own = [0; SET];
        let mut lane = 0;
        while lane < SET {
            own[lane] = primes[set * SET + lane];
            lane += 1;
        }
        bases[set] = Bases::new(own);
        set += 1;
    }
    bases
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_seed(set: u32, index: u32, count: u32, seed: u64) -> Option<[f64; SET]> {
        numbers(set, index, count, &seeds(set * SET as u32, seed))
    }

    /// The number in one dimension, with a scramble.
    fn number(prime: u32, index: u32, count: u32, seed: u32) -> f64 {
        let bases = Bases::new([prime; SET]);
        scrambled_radical_inverses(&bases, index, count, &[lowbias(seed); SET])[0]
    }

    /// Wherever a block of the sequence begins, it has one point in each stratum.
    #[test]
    fn blocks_of_halton_are_stratified() {
        for (prime, digits) in [(2, 6), (3, 4), (5, 3), (7, 2), (719, 1)] {
            let size: u32 = u32::pow(prime, digits);
            let last = MOST / size - 1;
            for block in [0, 1, 2, last] {
                let mut strata = vec![0; size as usize];
                for index in block * size..(block + 1) * size {
                    strata[(number(prime, index, MOST, 7) * f64::from(size)) as usize] += 1;
                }
                assert!(strata.iter().all(|count| *count == 1), "{prime} {block}: {strata:?}");
            }
        }
    }

    /// Each dimension has a base and a scramble of its own.
    #[test]
    fn all_dimensions_are_stratified() {
        for set in 0..BASES.len() as u32 {
            for lane in 0..SET {
                let prime = BASES[set as usize].prime[lane];
                let numbers = |seed| -> Vec<f64> {
                    (0..prime).map(|index| of_seed(set, index, prime, seed).unwrap()[lane]).collect()
                };
                let mut strata: Vec<u32> = numbers(5).iter().map(|x| (x * f64::from(prime)) as u32).collect();
                strata.sort_unstable();
                assert_eq!(strata, (0..prime).collect::<Vec<_>>());
                assert_ne!(numbers(5), numbers(6));
                assert_ne!(numbers(5), numbers(5 | 1 << 32));
            }
        }
        assert!(of_seed(BASES.len() as u32, 0, 1, 0).is_none() && of_seed(0, MOST + 1, 1, 0).is_none());
        assert!(pair(127, 0, 1, 0).is_none() && pair(0, MOST + 1, 1, 0).is_none());
    }

    /// Pairs have the bases and scrambles of their dimensions: they differ only in digits beyond those that are needed.
    #[test]
    fn pairs_are_those_of_sets() {
        for dimension in [0, 3, 7, 8, 126] {
            for index in 0..100 {
                let of_set = |at: u32| of_seed(at / 8, index, 100, 5).unwrap()[at as usize % SET];
                let prime = f64::from(BASES[dimension as usize / SET].prime[dimension as usize % SET]);
                let [first, second] = pair(dimension, index, 100, 5).unwrap();
                let digits = 100_f64.log(prime).ceil();
                assert!((first - of_set(dimension)).abs() < prime.powf(-digits), "{dimension} {index}");
                assert!((second - of_set(dimension + 1)).abs() < 0.01, "{dimension} {index}");
            }
        }
    }

    /// The permutations of the first digits, and of second digits after different first ones, have nothing in common.
    #[test]
    fn permutations_of_digits_are_independent() {
        for prime in [2_u32, 3, 7] {
            let (n, tries) = (prime as usize, 20_000_u32);
            let mut counts = [vec![0_u32; n * n], vec![0_u32; n * n]];
            for i in 0..tries {
                let digits = |index| {
                    let number = number(prime, index, prime * prime, i);
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
        for (bases, lane) in BASES.iter().flat_map(|bases| (0..SET).map(move |lane| (bases, lane))) {
            let (prime, end) = (bases.prime[lane], MOST + 1);
            let mut numbers = (0..prime * prime).chain(end - 2 * prime..end);
            assert!(numbers.all(|x| bases.quotient(lane, x) == x / prime), "{prime}");
        }
    }
}
