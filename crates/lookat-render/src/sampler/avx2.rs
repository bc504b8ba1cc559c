//! What sequences in eight dimensions share, by AVX2.

use std::arch::x86_64::{
    __m256d, __m256i, _mm256_add_epi32, _mm256_and_si256, _mm256_blend_epi32, _mm256_castsi256_si128,
    _mm256_cvtepi32_pd, _mm256_extracti128_si256, _mm256_mul_epu32, _mm256_mullo_epi32, _mm256_or_si256,
    _mm256_set1_epi8, _mm256_set1_epi32, _mm256_shuffle_epi8, _mm256_slli_epi32, _mm256_srli_epi32,
    _mm256_srli_epi64, _mm256_xor_si256,
};

use bytemuck::cast;

#[target_feature(enable = "avx2")]
#[inline]
pub(super) fn splat(x: u32) -> __m256i {
    _mm256_set1_epi32(x as i32)
}

/// Wellons's hash "lowbias32".
#[target_feature(enable = "avx2")]
#[inline]
pub(super) fn lowbias(x: __m256i) -> __m256i {
    let x = _mm256_xor_si256(x, _mm256_srli_epi32::<16>(x));
    let x = _mm256_mullo_epi32(x, splat(0x7feb_352d));
    let x = _mm256_xor_si256(x, _mm256_srli_epi32::<15>(x));
    let x = _mm256_mullo_epi32(x, splat(0x846c_a68b));
    _mm256_xor_si256(x, _mm256_srli_epi32::<16>(x))
}

/// The upper halves of products.
#[target_feature(enable = "avx2")]
#[inline]
pub(super) fn high(a: __m256i, b: __m256i) -> __m256i {
    let even = _mm256_srli_epi64::<32>(_mm256_mul_epu32(a, b));
    let odd = _mm256_mul_epu32(_mm256_srli_epi64::<32>(a), _mm256_srli_epi64::<32>(b));
    _mm256_blend_epi32::<0b1010_1010>(even, odd)
}

/// That of `sobol_burley`.
#[target_feature(enable = "avx2")]
#[inline]
pub(super) fn owen_scramble_rev(x: __m256i, scramble: __m256i) -> __m256i {
    let stirred = |x, factor| _mm256_xor_si256(x, _mm256_mullo_epi32(x, splat(factor)));
    let x = _mm256_add_epi32(stirred(x, 0x3d20_adea), scramble);
    let x = _mm256_mullo_epi32(x, _mm256_or_si256(_mm256_srli_epi32::<16>(scramble), splat(1)));
    stirred(stirred(x, 0x0552_6c56), 0x53a2_2864)
}

/// The bits in reverse.
#[target_feature(enable = "avx2")]
#[inline]
pub(super) fn reversed(x: __m256i) -> __m256i {
    let low = _mm256_set1_epi8(0x0f);
    let upper = _mm256_and_si256(_mm256_srli_epi32::<4>(x), low);
    let bytes = _mm256_or_si256(
        _mm256_slli_epi32::<4>(_mm256_shuffle_epi8(cast([NIBBLES; 2]), _mm256_and_si256(x, low))),
        _mm256_shuffle_epi8(cast([NIBBLES; 2]), upper),
    );
    _mm256_shuffle_epi8(bytes, cast([BYTES; 2]))
}

/// Four bits in reverse.
const NIBBLES: [u8; 16] = [0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15];

/// The bytes of each number in reverse.
const BYTES: [u8; 16] = [3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12];

/// Of numbers below 2^31.
#[target_feature(enable = "avx2")]
#[inline]
pub(super) fn to_f64(x: __m256i) -> [__m256d; 2] {
    [_mm256_cvtepi32_pd(_mm256_castsi256_si128(x)), _mm256_cvtepi32_pd(_mm256_extracti128_si256::<1>(x))]
}
