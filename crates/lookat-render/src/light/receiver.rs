//! Where light is looked for.

use fearless_simd::{Simd, f64x8, prelude::*};

use super::lune::Lunes;
use crate::bsdf::Domain;
use crate::number::Vec3x8;
use crate::surface::Surfaces;

/// Points of surfaces, and the directions that these scatter light from.
pub(crate) struct Receivers<'v, S: Simd> {
    pub surfaces: &'v Surfaces<S>,
    pub domain: Domain<S>,
    /// Where samples of the BSDF miss light of skies; `None` if nowhere.
    pub lunes: Option<Lunes<S>>,
}

/// Estimates are no better than this: a smaller cosine counts for as much.
pub(super) const LEAST_COSINE: f64 = 0.1;

impl<S: Simd> Receivers<'_, S> {
    /// One number where there is no lune, and another one where there is.
    #[inline(always)]
    pub fn by_lune(&self, simd: S, numbers: [f64; 2]) -> f64x8<S> {
        let [without, with] = numbers.map(|number| number.simd_into(simd));
        match &self.lunes {
            Some(lunes) => lunes.is_there.select(with, without),
            None => without,
        }
    }

    /// About the cosine at which light arrives from a ball in direction `wi`, whose radius is `spread` times its distance.
    /// 0 where all of it arrives from a side that nothing is scattered from. 1 from elsewhere, where that depends on more than
    /// the cosine: highlights are brightest in grazing light.
    #[inline(always)]
    pub fn cosine(&self, wi: Vec3x8<S>, spread: f64x8<S>) -> f64x8<S> {
        let Domain { n, ns, is_two_sided, is_diffuse } = self.domain;
        let (none, one) = (0.0.simd_into(spread.token()), 1.0.simd_into(spread.token()));
        let is_behind = !is_two_sided & wi.dot(n).simd_le(-spread);
        // Of the part that is highest above the surface.
        let cosine = (wi.dot(ns) + spread).max(LEAST_COSINE).min(1.0);
        is_behind.select(none, is_diffuse.select(cosine, one))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::number::bits;
    use crate::testing::{baseline, surfaces_at};

    #[test]
    fn light_from_behind_counts_where_it_comes_through() {
        let ns = DVec3::new(0.6, 0.0, 0.8);
        let cosine = |[is_two_sided, is_diffuse]: [bool; 2], wi: DVec3, spread: f64| {
            baseline!(simd => {
                let mask = |all: bool| bits(simd, if all { 0xff } else { 0 });
                let domain = Domain {
                    n: Vec3x8::splat(simd, DVec3::Z),
                    ns: Vec3x8::splat(simd, ns),
                    is_two_sided: mask(is_two_sided),
                    is_diffuse: mask(is_diffuse),
                };
                let receivers = Receivers { surfaces: &surfaces_at(simd, DVec3::ZERO), domain, lunes: None };
                receivers.cosine(Vec3x8::splat(simd, wi), spread.simd_into(simd))[0]
            })
        };
        let (diffuse, through, glossy) = ([false, true], [true, false], [false, false]);
        let (above, below, grazing) = (DVec3::Z, -DVec3::Z, DVec3::new(-0.8, 0.0, 0.6));
        assert_eq!([above, below].map(|wi| cosine(diffuse, wi, 0.0)), [0.8, 0.0]);
        assert_eq!([above, below].map(|wi| cosine(through, wi, 0.0)), [1.0, 1.0]);
        assert_eq!([diffuse, glossy].map(|of| cosine(of, grazing, 0.0)), [LEAST_COSINE, 1.0]);
        // What reaches above the surface.
        assert_eq!([0.9, 1.1].map(|spread| cosine(diffuse, below, spread) > 0.0), [false, true]);
    }
}
