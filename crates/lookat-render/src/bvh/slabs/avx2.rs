//! The test of eight boxes by AVX2.

use std::arch::x86_64::{
    __m256, _CMP_LE_OQ, _mm256_cmp_ps, _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps,
    _mm256_set1_ps, _mm256_setzero_ps, _mm256_sub_ps,
};

use bytemuck::cast;

use super::{Slab, Slabs};
use crate::bvh::{Node, WIDTH};

/// [`Slabs`], each number in all lanes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WideSlabs([WideSlab; 3]);

#[derive(Debug, Clone, Copy)]
struct WideSlab {
    near_o: __m256,
    far_o: __m256,
    near_inverse: __m256,
    far_inverse: __m256,
    near: usize,
}

impl WideSlab {
    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn new(slab: &Slab) -> Self {
        WideSlab {
            near_o: _mm256_set1_ps(slab.near_o),
            far_o: _mm256_set1_ps(slab.far_o),
            near_inverse: _mm256_set1_ps(slab.near_inverse),
            far_inverse: _mm256_set1_ps(slab.far_inverse),
            near: slab.near,
        }
    }
}

impl WideSlabs {
    #[target_feature(enable = "avx2,fma")]
    #[inline]
    pub fn new(Slabs([x, y, z]): &Slabs) -> Self {
        WideSlabs([WideSlab::new(x), WideSlab::new(y), WideSlab::new(z)])
    }

    /// As [`Slabs::meet`], to the bit.
    #[target_feature(enable = "avx2,fma")]
    #[inline]
    pub fn meet(&self, node: &Node, t_max: f32) -> (u32, [f32; WIDTH]) {
        let (mut near, mut far) = (_mm256_setzero_ps(), _mm256_set1_ps(t_max));
        for (slab, planes) in self.0.iter().zip(&node.planes) {
            let (first, last): (__m256, __m256) = (cast(planes[slab.near & 1]), cast(planes[!slab.near & 1]));
            let enter = _mm256_mul_ps(_mm256_sub_ps(first, slab.near_o), slab.near_inverse);
            let leave = _mm256_mul_ps(_mm256_sub_ps(last, slab.far_o), slab.far_inverse);
            // Of a NaN and a number, these give the second.
            near = _mm256_max_ps(enter, near);
            far = _mm256_min_ps(leave, far);
        }
        let hits = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far));
        (hits as u32, cast(near))
    }
}
