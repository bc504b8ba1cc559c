//! Eight dimensions of Sobol' points by AVX2.

use std::arch::x86_64::{
    __m256i, _mm256_mul_pd, _mm256_set1_pd, _mm256_setzero_si256, _mm256_srli_epi32, _mm256_xor_si256,
};

use bytemuck::cast;

use super::{Place, SCALE, SCRAMBLES, SET};
use crate::sampler::avx2::{lowbias, owen_scramble_rev, reversed, splat, to_f64};

/// As [`super::numbers`], to the bit.
#[target_feature(enable = "avx2")]
pub(in crate::sampler) fn numbers(set: u32, index: u32, seed: u64) -> [f64; SET] {
    let Place { added, own } = Place::new(set, index, seed);
    let mut point = _mm256_setzero_si256();
    for added in added {
        point = _mm256_xor_si256(point, cast(*added));
    }
    let scramble = hash(_mm256_xor_si256(splat(own), cast(SCRAMBLES)));
    let bits = _mm256_srli_epi32::<9>(reversed(owen_scramble_rev(point, scramble)));
    let [low, high] = to_f64(bits);
    cast([_mm256_mul_pd(low, _mm256_set1_pd(SCALE)), _mm256_mul_pd(high, _mm256_set1_pd(SCALE))])
}

/// That of `sobol_burley`.
#[target_feature(enable = "avx2")]
#[inline]
fn hash(x: __m256i) -> __m256i {
    lowbias(_mm256_xor_si256(x, splat(0xe6fe_3beb)))
}
