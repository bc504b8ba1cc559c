//! The filter of eight triangles by AVX2.

use std::arch::x86_64::{
    __m256, _CMP_GT_OQ, _CMP_LE_OQ, _CMP_LT_OQ, _mm256_and_ps, _mm256_andnot_ps, _mm256_cmp_ps,
    _mm256_fmsub_ps, _mm256_fnmadd_ps, _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps,
    _mm256_or_ps, _mm256_set1_ps, _mm256_sub_ps,
};

use bytemuck::cast;

use super::{Block, FilterRay, Scale, Sides};
use crate::bvh::WIDTH;
use crate::ray::Ray;
use crate::triangle::lanes::ManyFilters;
use crate::triangle::{Axis, ShearedRay};

/// A ray for the filter of eight triangles.
pub(crate) type WideFilter = FilterRay<__m256>;

/// The filter's form of a ray.
#[target_feature(enable = "avx2,fma")]
#[inline]
pub(crate) fn filter_ray(ray: &Ray, sheared: &ShearedRay) -> WideFilter {
    FilterRay::new(ray, sheared, |x| _mm256_set1_ps(x))
}

impl WideFilter {
    /// That of one of several rays, whose axes these are.
    #[target_feature(enable = "avx2,fma")]
    #[inline]
    pub fn of(rays: &ManyFilters, axes: [Axis; 3], lane: usize) -> Self {
        let ManyFilters { turned: [x, y, z], shear: [shear_x, shear_y], sign, length, magnitude } = rays;
        FilterRay {
            turned: [_mm256_set1_ps(x[lane]), _mm256_set1_ps(y[lane]), _mm256_set1_ps(z[lane])],
            axes,
            shear: [_mm256_set1_ps(shear_x[lane]), _mm256_set1_ps(shear_y[lane])],
            sign: _mm256_set1_ps(sign[lane]),
            scale: Scale { length: length[lane], magnitude: magnitude[lane] },
        }
    }

    /// As for one number at a time, but for what rounding does to triangles that may be met or not.
    #[target_feature(enable = "avx2,fma")]
    #[inline]
    pub fn may_meet(&self, block: &Block, t_max: f64) -> u32 {
        let limits = self.scale.limits(block, t_max);
        let Sides { least, greatest, front, back, .. } = self.sides(block);
        let passes = _mm256_and_ps(
            _mm256_cmp_ps::<_CMP_LT_OQ>(least, _mm256_set1_ps(-limits.side)),
            _mm256_cmp_ps::<_CMP_GT_OQ>(greatest, _mm256_set1_ps(limits.side)),
        );
        let is_out = _mm256_or_ps(
            passes,
            _mm256_or_ps(
                _mm256_cmp_ps::<_CMP_GT_OQ>(front, _mm256_set1_ps(limits.farthest)),
                _mm256_cmp_ps::<_CMP_LT_OQ>(back, _mm256_set1_ps(limits.nearest)),
            ),
        );
        !_mm256_movemask_ps(is_out) as u32 & block.all()
    }

    /// As for one number at a time, likewise.
    #[target_feature(enable = "avx2,fma")]
    #[inline]
    pub fn surely_meets(&self, block: &Block, t_max: f64) -> u32 {
        let limits = self.scale.limits(block, t_max);
        let Sides { least, greatest, front, back, away } = self.sides(block);
        let is_between = _mm256_and_ps(
            _mm256_cmp_ps::<_CMP_GT_OQ>(front, _mm256_set1_ps(limits.surely[0])),
            _mm256_cmp_ps::<_CMP_LT_OQ>(back, _mm256_set1_ps(limits.surely[1])),
        );
        let is_one_side = _mm256_or_ps(
            _mm256_cmp_ps::<_CMP_GT_OQ>(least, _mm256_set1_ps(limits.side)),
            _mm256_cmp_ps::<_CMP_LT_OQ>(greatest, _mm256_set1_ps(-limits.side)),
        );
        let is_near = _mm256_cmp_ps::<_CMP_LE_OQ>(away, _mm256_set1_ps(limits.size));
        let is_met = _mm256_and_ps(is_between, _mm256_and_ps(is_one_side, is_near));
        _mm256_movemask_ps(is_met) as u32 & block.all()
    }

    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn sides(&self, block: &Block) -> Sides<__m256> {
        let (a, b, c) = (
            self.sheared(&block.corners[0]),
            self.sheared(&block.corners[1]),
            self.sheared(&block.corners[2]),
        );
        let (u, v, w) = (cross(c, b), cross(a, c), cross(b, a));
        Sides {
            least: _mm256_min_ps(u, _mm256_min_ps(v, w)),
            greatest: _mm256_max_ps(u, _mm256_max_ps(v, w)),
            front: _mm256_min_ps(a[2], _mm256_min_ps(b[2], c[2])),
            back: _mm256_max_ps(a[2], _mm256_max_ps(b[2], c[2])),
            away: _mm256_max_ps(away(a), _mm256_max_ps(away(b), away(c))),
        }
    }

    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn sheared(&self, corner: &[[f32; WIDTH]; 3]) -> [__m256; 3] {
        let [x, y, z] = self.axes;
        let x = _mm256_sub_ps(cast(x.of(corner)), self.turned[0]);
        let y = _mm256_sub_ps(cast(y.of(corner)), self.turned[1]);
        let z = _mm256_sub_ps(cast(z.of(corner)), self.turned[2]);
        [
            _mm256_fnmadd_ps(self.shear[0], z, x),
            _mm256_fnmadd_ps(self.shear[1], z, y),
            _mm256_mul_ps(z, self.sign),
        ]
    }
}

/// The greater of the sizes of x and y.
#[target_feature(enable = "avx2,fma")]
#[inline]
fn away(p: [__m256; 3]) -> __m256 {
    let sign = _mm256_set1_ps(-0.0);
    _mm256_max_ps(_mm256_andnot_ps(sign, p[0]), _mm256_andnot_ps(sign, p[1]))
}

/// `p.x * q.y - p.y * q.x`.
#[target_feature(enable = "avx2,fma")]
#[inline]
fn cross(p: [__m256; 3], q: [__m256; 3]) -> __m256 {
    _mm256_fmsub_ps(p[0], q[1], _mm256_mul_ps(p[1], q[0]))
}
