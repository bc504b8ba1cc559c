//! Where light is looked for.

use glam::DVec3;

use crate::bsdf::Domain;

/// A point of a surface, relative to the origin, and the directions that it scatters light from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Receiver {
    pub p: DVec3,
    pub domain: Domain,
}

/// Estimates are no better than this: a smaller cosine counts for as much.
pub(super) const LEAST_COSINE: f64 = 0.1;

impl Receiver {
    /// About the cosine at which light arrives from a ball in direction `wi`, whose radius is `spread` times its distance.
    /// 0 where all of it arrives from a side that nothing is scattered from. 1 from elsewhere, where that depends on more than
    /// the cosine: highlights are brightest in grazing light.
    #[inline]
    pub fn cosine(&self, wi: DVec3, spread: f64) -> f64 {
        let Domain { n, ns, is_two_sided, is_diffuse } = self.domain;
        if !is_two_sided && wi.dot(n) <= -spread {
            return 0.0;
        }
        // Of the part that is highest above the surface.
        if is_diffuse { (wi.dot(ns) + spread).clamp(LEAST_COSINE, 1.0) } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_from_behind_counts_where_it_comes_through() {
        let ns = DVec3::new(0.6, 0.0, 0.8);
        let domain = Domain { n: DVec3::Z, ns, is_two_sided: false, is_diffuse: true };
        let at = |domain| Receiver { p: DVec3::ZERO, domain };
        let through = at(Domain { is_two_sided: true, is_diffuse: false, ..domain });
        let glossy = at(Domain { is_diffuse: false, ..domain });
        let (above, below, grazing) = (DVec3::Z, -DVec3::Z, DVec3::new(-0.8, 0.0, 0.6));
        assert_eq!([above, below].map(|wi| at(domain).cosine(wi, 0.0)), [0.8, 0.0]);
        assert_eq!([above, below].map(|wi| through.cosine(wi, 0.0)), [1.0, 1.0]);
        assert_eq!([at(domain), glossy].map(|at| at.cosine(grazing, 0.0)), [LEAST_COSINE, 1.0]);
        // What reaches above the surface.
        assert_eq!([0.9, 1.1].map(|spread| at(domain).cosine(below, spread) > 0.0), [false, true]);
    }
}
