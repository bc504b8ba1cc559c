//! Where rays side by side may find what glows.

use fearless_simd::{Simd, mask64x8, prelude::*};

use super::Emitters;
use crate::bvh::BoxRays;
use crate::lanes::bits;
use crate::trace::lanes::Rays;

impl Emitters {
    /// Which rays may meet what emits; as [`Emitters::may_be_met`].
    #[inline(always)]
    pub fn may_be_met_by<S: Simd>(&self, simd: S, rays: &Rays<S>) -> mask64x8<S> {
        let mut may_be = bits(simd, 0);
        if self.is_empty() {
            return may_be;
        }
        let rays = BoxRays::new(rays.o, rays.d);
        for bounds in &self.0 {
            let (low, high) = bounds.corners();
            let (near, far) = rays.ends(simd, &low, &high);
            may_be |= near.simd_le(far);
        }
        may_be
    }
}
