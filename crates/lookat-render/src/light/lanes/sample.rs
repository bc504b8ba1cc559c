//! Samples of lights side by side.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};

use crate::lanes::{Colors, bits};
use crate::light::LightSample;
use crate::trace::lanes::{Labels, Rays};

/// As [`LightSample`], where there is one.
pub(crate) struct LightSamples<S: Simd> {
    pub is_there: mask64x8<S>,
    pub li: Colors<S>,
    pub pdf: f64x8<S>,
    pub has_pdf: mask64x8<S>,
    pub shadow: Rays<S>,
    /// Where the light has to be asked one by one.
    pub is_open: mask64x8<S>,
}

impl<S: Simd> LightSamples<S> {
    /// These where `mask` says so, and the others elsewhere.
    #[inline(always)]
    pub fn or(self, mask: mask64x8<S>, others: Self) -> Self {
        LightSamples {
            is_there: mask & self.is_there | !mask & others.is_there,
            li: self.li.or(mask, others.li),
            pdf: mask.select(self.pdf, others.pdf),
            has_pdf: mask & self.has_pdf | !mask & others.has_pdf,
            shadow: self.shadow.or(mask, others.shadow),
            is_open: mask & self.is_open | !mask & others.is_open,
        }
    }

    /// Puts what one of them is in its place.
    pub fn put(&mut self, lane: usize, sample: Option<&LightSample>, labels: Labels) {
        let simd = self.pdf.token();
        let lane_bit = bits(simd, 1 << lane);
        self.is_open &= !lane_bit;
        self.is_there &= !lane_bit;
        let Some(LightSample { li, pdf, shadow }) = sample else { return };
        self.is_there |= lane_bit;
        self.has_pdf = if pdf.is_some() { self.has_pdf | lane_bit } else { self.has_pdf & !lane_bit };
        self.pdf[lane] = pdf.unwrap_or(1.0);
        self.li.put(lane, *li);
        self.shadow.o.put(lane, shadow.o);
        self.shadow.d.put(lane, shadow.d);
        self.shadow.t_max[lane] = shadow.t_max;
        self.shadow.target[lane] = labels.of(shadow.target);
    }
}
