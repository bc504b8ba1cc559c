//! The filter of eight triangles by AVX2.

use std::arch::x86_64::{
    __m256, _CMP_GT_OQ, _CMP_LT_OQ, _mm256_and_ps, _mm256_cmp_ps, _mm256_fmsub_ps, _mm256_fnmadd_ps,
    _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps, _mm256_or_ps, _mm256_set1_ps,
    _mm256_sub_ps,
};

use bytemuck::cast;

use super::{Block, FilterRay};
use crate::bvh::WIDTH;

/// [`FilterRay`], each number in all lanes, its axes in their turned order.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WideFilterRay {
    ray: FilterRay,
    o: [__m256; 3],
    shear: [__m256; 2],
    sign: __m256,
}

impl WideFilterRay {
    #[target_feature(enable = "avx2,fma")]
    #[inline]
    pub fn new(ray: FilterRay) -> Self {
        let [x, y, z] = ray.axes.map(|axis| axis.of(&ray.o));
        WideFilterRay {
            ray,
            o: [_mm256_set1_ps(x), _mm256_set1_ps(y), _mm256_set1_ps(z)],
            shear: [_mm256_set1_ps(ray.shear[0]), _mm256_set1_ps(ray.shear[1])],
            sign: _mm256_set1_ps(ray.sign),
        }
    }

    /// As [`FilterRay::may_meet`], but for what rounding does to triangles that may be met or not.
    #[target_feature(enable = "avx2,fma")]
    #[inline]
    pub fn may_meet(&self, block: &Block, t_max: f64) -> u32 {
        let limits = self.ray.limits(block, t_max);
        let (a, b, c) = (
            self.sheared(&block.corners[0]),
            self.sheared(&block.corners[1]),
            self.sheared(&block.corners[2]),
        );
        let (u, v, w) = (cross(c, b), cross(a, c), cross(b, a));
        let least = _mm256_min_ps(u, _mm256_min_ps(v, w));
        let greatest = _mm256_max_ps(u, _mm256_max_ps(v, w));
        let passes = _mm256_and_ps(
            _mm256_cmp_ps::<_CMP_LT_OQ>(least, _mm256_set1_ps(-limits.side)),
            _mm256_cmp_ps::<_CMP_GT_OQ>(greatest, _mm256_set1_ps(limits.side)),
        );
        let front = _mm256_min_ps(a[2], _mm256_min_ps(b[2], c[2]));
        let back = _mm256_max_ps(a[2], _mm256_max_ps(b[2], c[2]));
        let is_out = _mm256_or_ps(
            passes,
            _mm256_or_ps(
                _mm256_cmp_ps::<_CMP_GT_OQ>(front, _mm256_set1_ps(limits.farthest)),
                _mm256_cmp_ps::<_CMP_LT_OQ>(back, _mm256_set1_ps(limits.nearest)),
            ),
        );
        !_mm256_movemask_ps(is_out) as u32 & block.all()
    }

    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn sheared(&self, corner: &[[f32; WIDTH]; 3]) -> [__m256; 3] {
        let [x, y, z] = self.ray.axes;
        let x = _mm256_sub_ps(cast(x.of(corner)), self.o[0]);
        let y = _mm256_sub_ps(cast(y.of(corner)), self.o[1]);
        let z = _mm256_sub_ps(cast(z.of(corner)), self.o[2]);
        [
            _mm256_fnmadd_ps(self.shear[0], z, x),
            _mm256_fnmadd_ps(self.shear[1], z, y),
            _mm256_mul_ps(z, self.sign),
        ]
    }
}

/// `p.x * q.y - p.y * q.x`.
#[target_feature(enable = "avx2,fma")]
#[inline]
fn cross(p: [__m256; 3], q: [__m256; 3]) -> __m256 {
    _mm256_fmsub_ps(p[0], q[1], _mm256_mul_ps(p[1], q[0]))
}
