//! Where light is looked for.

use glam::DVec3;

use crate::bsdf::Domain;

/// A point of a surface, relative to the eye, and the directions that it scatters light from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Receiver {
    pub p: DVec3,
    pub domain: Domain,
}

/// Glossy surfaces scatter grazing light too: a cosine counts for no less.
pub(super) const LEAST_COSINE: f64 = 0.1;

impl Receiver {
    /// About the cosine at which light arrives from a ball in direction `wi`, whose radius is `spread` times its distance.
    /// 0 where all of it arrives from a side that nothing is scattered from.
    #[inline]
    pub fn cosine(&self, wi: DVec3, spread: f64) -> f64 {
        let Domain { n, ns, is_two_sided } = self.domain;
        if !is_two_sided && wi.dot(n) <= -spread {
            return 0.0;
        }
        let cosine = if is_two_sided { wi.dot(ns).abs() } else { wi.dot(ns) };
        // Of the part that is highest above the surface.
        (cosine + spread).clamp(LEAST_COSINE, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_from_behind_counts_where_it_comes_through() {
        let at = |is_two_sided| Receiver {
            p: DVec3::ZERO,
            domain: Domain { n: DVec3::Z, ns: DVec3::new(0.6, 0.0, 0.8), is_two_sided },
        };
        let (above, below, grazing) = (DVec3::Z, -DVec3::Z, DVec3::new(-0.8, 0.0, 0.6));
        assert_eq!([above, below].map(|wi| at(false).cosine(wi, 0.0)), [0.8, 0.0]);
        assert_eq!([above, below].map(|wi| at(true).cosine(wi, 0.0)), [0.8, 0.8]);
        assert_eq!(at(false).cosine(grazing, 0.0), LEAST_COSINE);
        // What reaches above the surface.
        assert_eq!([0.9, 1.1].map(|spread| at(false).cosine(below, spread) > 0.0), [false, true]);
    }
}
