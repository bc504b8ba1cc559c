//! Eight dimensions of the Halton sequence by AVX2.

use std::arch::x86_64::{
    __m256d, __m256i, _mm256_add_epi32, _mm256_add_pd, _mm256_min_pd, _mm256_mul_pd, _mm256_mullo_epi32,
    _mm256_set1_pd, _mm256_setzero_pd, _mm256_srli_epi32, _mm256_srlv_epi32, _mm256_sub_epi32,
    _mm256_xor_si256,
};

use bytemuck::cast;

use super::{BASES, BELOW_ONE, Bases, LANES, MOST, NUMBERS, SPREAD};
use crate::sampler::avx2::{high, lowbias, splat, to_f64};

/// As [`super::numbers`], to the bit.
#[target_feature(enable = "avx2")]
pub(in crate::sampler) fn numbers(set: u32, index: u32, count: u32, seed: u64) -> Option<[f64; LANES]> {
    let bases = BASES.get(set as usize).filter(|_| index <= MOST)?;
    Some(scrambled_radical_inverses(bases, index, count, seeds(set * LANES as u32, seed)))
}

#[target_feature(enable = "avx2")]
#[inline]
fn seeds(first: u32, seed: u64) -> __m256i {
    let dimensions = _mm256_add_epi32(splat(first), cast(NUMBERS));
    let seeds = lowbias(_mm256_xor_si256(splat((seed >> 32) as u32), dimensions));
    lowbias(_mm256_xor_si256(splat(seed as u32), seeds))
}

/// The steps are those of [`super::scrambled_radical_inverses`].
#[target_feature(enable = "avx2")]
#[inline]
fn scrambled_radical_inverses(bases: &Bases<LANES>, index: u32, count: u32, seeds: __m256i) -> [f64; LANES] {
    let (prime, reciprocal): (__m256i, __m256i) = (cast(bases.prime), cast(bases.reciprocal));
    let (exponent, inverse): (__m256i, [__m256d; 2]) = (cast(bases.exponent), cast(bases.inverse));
    let quotient = |x| _mm256_srlv_epi32(high(x, reciprocal), exponent);
    let (index, one) = (splat(index), splat(1));
    let (mut rest, mut power) = (index, one);
    let (mut number, mut scale) = ([_mm256_setzero_pd(); 2], [_mm256_set1_pd(1.0); 2]);
    let mut least = 1;
    while least < u64::from(count) {
        let before = _mm256_sub_epi32(_mm256_add_epi32(power, index), _mm256_mullo_epi32(rest, power));
        let random = lowbias(_mm256_xor_si256(seeds, before));
        let spread = _mm256_mullo_epi32(random, splat(SPREAD));
        let factor = _mm256_add_epi32(one, high(spread, _mm256_sub_epi32(prime, one)));
        let above = quotient(rest);
        let own = _mm256_sub_epi32(rest, _mm256_mullo_epi32(above, prime));
        let image = _mm256_add_epi32(_mm256_mullo_epi32(own, factor), high(random, prime));
        let digit = to_f64(_mm256_sub_epi32(image, _mm256_mullo_epi32(quotient(image), prime)));
        for half in 0..2 {
            scale[half] = _mm256_mul_pd(scale[half], inverse[half]);
            number[half] = _mm256_add_pd(number[half], _mm256_mul_pd(digit[half], scale[half]));
        }
        (rest, power) = (above, _mm256_mullo_epi32(power, prime));
        least *= bases.least;
    }
    let beyond = lowbias(_mm256_xor_si256(seeds, _mm256_add_epi32(power, index)));
    let beyond = to_f64(_mm256_srli_epi32::<1>(beyond));
    for half in 0..2 {
        let beyond = _mm256_mul_pd(beyond[half], _mm256_set1_pd(1.0 / f64::from(1_u32 << 31)));
        let sum = _mm256_add_pd(number[half], _mm256_mul_pd(beyond, scale[half]));
        number[half] = _mm256_min_pd(sum, _mm256_set1_pd(BELOW_ONE));
    }
    cast(number)
}
