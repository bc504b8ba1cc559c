//! The test of eight boxes by AVX2.

use std::arch::x86_64::{
    __m256, _CMP_LE_OQ, _mm256_cmp_ps, _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps,
    _mm256_set1_ps, _mm256_setzero_ps, _mm256_sub_ps,
};

use bytemuck::cast;
use glam::Vec3A;

use super::Slabs;
use super::lanes::ManySlabs;
use crate::bvh::{Node, WIDTH};
use crate::lanes::LANES;

/// [`Slabs`], each number in all lanes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WideSlabs {
    near_o: [__m256; 3],
    far_o: [__m256; 3],
    near_inverse: [__m256; 3],
    far_inverse: [__m256; 3],
    near: [usize; 3],
}

impl WideSlabs {
    #[target_feature(enable = "avx2,fma")]
    #[inline]
    pub fn new(slabs: &Slabs) -> Self {
        WideSlabs {
            near_o: splat(slabs.near_o),
            far_o: splat(slabs.far_o),
            near_inverse: splat(slabs.near_inverse),
            far_inverse: splat(slabs.far_inverse),
            near: slabs.near,
        }
    }

    /// Those of one of several rays.
    #[target_feature(enable = "avx2,fma")]
    #[inline]
    pub fn of(slabs: &ManySlabs, lane: usize) -> Self {
        WideSlabs {
            near_o: splat_one(&slabs.near_o, lane),
            far_o: splat_one(&slabs.far_o, lane),
            near_inverse: splat_one(&slabs.near_inverse, lane),
            far_inverse: splat_one(&slabs.far_inverse, lane),
            near: slabs.near(lane),
        }
    }

    /// As [`Slabs::meet`], to the bit.
    #[target_feature(enable = "avx2,fma")]
    #[inline]
    pub fn meet(&self, node: &Node, t_max: f32) -> (u32, [f32; WIDTH]) {
        let (mut near, mut far) = (_mm256_setzero_ps(), _mm256_set1_ps(t_max));
        for (axis, planes) in node.planes.iter().enumerate() {
            let entered = self.near[axis];
            let (first, last): (__m256, __m256) = (cast(planes[entered & 1]), cast(planes[!entered & 1]));
            let enter = _mm256_mul_ps(_mm256_sub_ps(first, self.near_o[axis]), self.near_inverse[axis]);
            let leave = _mm256_mul_ps(_mm256_sub_ps(last, self.far_o[axis]), self.far_inverse[axis]);
            // Of a NaN and a number, these give the second.
            near = _mm256_max_ps(enter, near);
            far = _mm256_min_ps(leave, far);
        }
        let hits = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far));
        (hits as u32, cast(near))
    }
}

#[target_feature(enable = "avx2,fma")]
#[inline]
fn splat(v: Vec3A) -> [__m256; 3] {
    [_mm256_set1_ps(v.x), _mm256_set1_ps(v.y), _mm256_set1_ps(v.z)]
}

#[target_feature(enable = "avx2,fma")]
#[inline]
fn splat_one([x, y, z]: &[[f32; LANES]; 3], lane: usize) -> [__m256; 3] {
    [_mm256_set1_ps(x[lane]), _mm256_set1_ps(y[lane]), _mm256_set1_ps(z[lane])]
}
