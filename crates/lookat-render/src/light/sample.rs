//! Light that may reach points from one direction each.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};

use crate::number::{Colors, bits};
use crate::trace::rays::Rays;

/// Samples of lights.
pub(crate) struct LightSample<S: Simd> {
    /// Where there is one.
    pub is_there: mask64x8<S>,
    /// Radiance, or for lights that are only a point or direction the irradiance on a surface that faces them. Nothing has been looked
    /// up about what is in the way.
    pub li: Colors<S>,
    /// Densities by solid angle; 1 for lights that no other direction can hit.
    pub pdf: f64x8<S>,
    /// Where other directions can hit the light.
    pub has_pdf: mask64x8<S>,
    /// The rays that must be free.
    pub shadow: Rays<S>,
}

impl<S: Simd> LightSample<S> {
    /// Of a light that no other direction can hit.
    #[inline(always)]
    pub fn of_delta(is_there: mask64x8<S>, li: Colors<S>, shadow: Rays<S>) -> Self {
        let simd = shadow.t_max.token();
        LightSample { is_there, li, pdf: 1.0.simd_into(simd), has_pdf: bits(simd, 0), shadow }
    }

    /// Of a light that others can.
    #[inline(always)]
    pub fn with_pdf(is_there: mask64x8<S>, li: Colors<S>, pdf: f64x8<S>, shadow: Rays<S>) -> Self {
        let is_there = is_there & pdf.simd_gt(0.0) & pdf.is_finite();
        LightSample { is_there, li, pdf, has_pdf: bits(pdf.token(), 0xff), shadow }
    }

    /// These where `mask` says so, and the others elsewhere.
    #[inline(always)]
    pub fn or(self, mask: mask64x8<S>, others: Self) -> Self {
        LightSample {
            is_there: mask & self.is_there | !mask & others.is_there,
            li: self.li.or_wide(mask, others.li),
            pdf: mask.select(self.pdf, others.pdf),
            has_pdf: mask & self.has_pdf | !mask & others.has_pdf,
            shadow: self.shadow.or(mask, others.shadow),
        }
    }
}
