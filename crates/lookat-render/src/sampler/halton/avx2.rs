//! Eight dimensions of the Halton sequence by AVX2.

use std::arch::x86_64::{
    __m256d, __m256i, _mm256_add_epi32, _mm256_add_pd, _mm256_and_si256, _mm256_blend_pd, _mm256_madd_epi16,
    _mm256_min_pd, _mm256_mul_pd, _mm256_mullo_epi32, _mm256_set1_pd, _mm256_setzero_pd,
    _mm256_shufflehi_epi16, _mm256_shufflelo_epi16, _mm256_srli_epi32, _mm256_srlv_epi32, _mm256_sub_epi32,
    _mm256_xor_si256,
};

use bytemuck::cast;

use super::{BASES, BELOW_ONE, MOST, SET, Seeds};
use crate::lanes::LANES;
use crate::sampler::avx2::{high, lowbias, owen_scramble_rev, reversed, splat, to_f64};

/// As [`super::numbers`], to the bit.
#[target_feature(enable = "avx2")]
pub(in crate::sampler) fn numbers(
    set: u32,
    index: u32,
    count: u32,
    seeds: &[u32; SET],
) -> Option<[f64; SET]> {
    let bases = BASES.get(set as usize).filter(|_| index <= MOST)?;
    let wide = WideBases {
        prime: cast(bases.prime),
        reciprocal: cast(bases.reciprocal),
        exponent: cast(bases.exponent),
        inverse: cast(bases.inverse),
        least: bases.least,
    };
    let mut numbers = scrambled_radical_inverses(&wide, splat(index), count, cast(*seeds));
    if bases.begins_with_2() {
        let first = super::scrambled_in_base_2(index, seeds[0]);
        numbers[0] = _mm256_blend_pd::<1>(numbers[0], _mm256_set1_pd(first));
    }
    Some(cast(numbers))
}

/// One dimension of eight points, as [`super::numbers`] has it; `seeds` are those of their pixels.
#[target_feature(enable = "avx2")]
pub(in crate::sampler) fn points(
    dimension: u32,
    indices: &[u32; LANES],
    count: u32,
    seeds: &Seeds,
) -> Option<[f64; LANES]> {
    let (set, lane) = (dimension as usize / SET, dimension as usize % SET);
    let are_there = indices.iter().all(|index| *index <= MOST);
    let bases = BASES.get(set).filter(|_| are_there)?;
    let index = cast(*indices);
    let seeds = scrambles(dimension, seeds);
    if bases.prime[lane] == 2 {
        return Some(cast(scrambled_in_base_2(index, seeds)));
    }
    let bases = WideBases {
        prime: splat(bases.prime[lane]),
        reciprocal: splat(bases.reciprocal[lane]),
        exponent: splat(bases.exponent[lane]),
        inverse: [_mm256_set1_pd(bases.inverse[lane]); 2],
        least: bases.least,
    };
    Some(cast(scrambled_radical_inverses(&bases, index, count, seeds)))
}

/// As [`super::seeds`], of one dimension of several pixels.
#[target_feature(enable = "avx2")]
#[inline]
fn scrambles(dimension: u32, seeds: &Seeds) -> __m256i {
    let upper = lowbias(_mm256_xor_si256(cast(seeds.high), splat(dimension)));
    lowbias(_mm256_xor_si256(cast(seeds.low), upper))
}

/// The bases of eight numbers.
struct WideBases {
    prime: __m256i,
    reciprocal: __m256i,
    exponent: __m256i,
    inverse: [__m256d; 2],
    least: u64,
}

/// The steps are those of [`super::scrambled_radical_inverses`].
#[target_feature(enable = "avx2")]
#[inline]
fn scrambled_radical_inverses(bases: &WideBases, index: __m256i, count: u32, seeds: __m256i) -> [__m256d; 2] {
    let WideBases { prime, reciprocal, exponent, inverse, .. } = *bases;
    let quotient = |x| _mm256_srlv_epi32(high(x, reciprocal), exponent);
    let one = splat(1);
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
    number
}

/// As [`super::scrambled_in_base_2`].
#[target_feature(enable = "avx2")]
#[inline]
fn scrambled_in_base_2(index: __m256i, seeds: __m256i) -> [__m256d; 2] {
    let bits = reversed(owen_scramble_rev(index, seeds));
    // Processors convert 31 bits.
    let upper = to_f64(_mm256_srli_epi32::<1>(bits));
    let lowest = to_f64(_mm256_and_si256(bits, splat(1)));
    let scale = _mm256_set1_pd(1.0 / 4_294_967_296.0);
    let number = |half: usize| {
        let bits = _mm256_add_pd(_mm256_add_pd(upper[half], upper[half]), lowest[half]);
        _mm256_mul_pd(bits, scale)
    };
    [number(0), number(1)]
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
