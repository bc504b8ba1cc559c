//! Eight dimensions of the Halton sequence by AVX2.

use std::arch::x86_64::{
    __m256d, __m256i, _mm256_add_epi32, _mm256_add_pd, _mm256_blend_pd, _mm256_cvtsi256_si32,
    _mm256_madd_epi16, _mm256_min_pd, _mm256_mul_pd, _mm256_mullo_epi32, _mm256_set1_pd, _mm256_setzero_pd,
    _mm256_shufflehi_epi16, _mm256_shufflelo_epi16, _mm256_srli_epi32, _mm256_srlv_epi32, _mm256_sub_epi32,
    _mm256_xor_si256,
};

use bytemuck::cast;

use super::{BASES, BELOW_ONE, Bases, LANES, MOST, scrambled_in_base_2};
use crate::sampler::avx2::{high, lowbias, splat, to_f64};

/// As [`super::numbers`], to the bit.
#[target_feature(enable = "avx2")]
pub(in crate::sampler) fn numbers(
    set: u32,
    index: u32,
    count: u32,
    seeds: &[u32; LANES],
) -> Option<[f64; LANES]> {
    let bases = BASES.get(set as usize).filter(|_| index <= MOST)?;
    Some(scrambled_radical_inverses(bases, index, count, cast(*seeds)))
}

/// The steps are those of [`super::scrambled_radical_inverses`].
#[target_feature(enable = "avx2")]
#[inline]
fn scrambled_radical_inverses(bases: &Bases<LANES>, index: u32, count: u32, seeds: __m256i) -> [f64; LANES] {
    let (prime, reciprocal): (__m256i, __m256i) = (cast(bases.prime), cast(bases.reciprocal));
    let (exponent, inverse): (__m256i, [__m256d; 2]) = (cast(bases.exponent), cast(bases.inverse));
    let quotient = |x| _mm256_srlv_epi32(high(x, reciprocal), exponent);
    let (own_index, index, one) = (index, splat(index), splat(1));
    let (mut rest, mut power) = (index, one);
    let (mut number, mut scale) = ([_mm256_setzero_pd(); 2], [_mm256_set1_pd(1.0); 2]);
    let mut least = 1;
    while least < u64::from(count) {
        let before = _mm256_sub_epi32(_mm256_add_epi32(power, index), _mm256_mullo_epi32(rest, power));
        let random = lowbias(_mm256_xor_si256(seeds, before));
        let factor = _mm256_add_epi32(one, high(halves_swapped(random), _mm256_sub_epi32(prime, one)));
        let above = quotient(rest);
        let own = _mm256_sub_epi32(rest, _mm256_mullo_epi32(above, prime));
        let image = _mm256_add_epi32(small_product(own, factor), high(random, prime));
        let digit = to_f64(_mm256_sub_epi32(image, small_product(quotient(image), prime)));
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
    if bases.begins_with_2() {
        let first = scrambled_in_base_2(own_index, _mm256_cvtsi256_si32(seeds) as u32);
        number[0] = _mm256_blend_pd::<1>(number[0], _mm256_set1_pd(first));
    }
    cast(number)
}

/// Rotated by 16 bits.
#[target_feature(enable = "avx2")]
#[inline]
fn halves_swapped(x: __m256i) -> __m256i {
    _mm256_shufflelo_epi16::<0b10_11_00_01>(_mm256_shufflehi_epi16::<0b10_11_00_01>(x))
}

/// Products of numbers below 2^15, of which processors make more at once than of others.
#[target_feature(enable = "avx2")]
#[inline]
fn small_product(a: __m256i, b: __m256i) -> __m256i {
    _mm256_madd_epi16(a, b)
}
