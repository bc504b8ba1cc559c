//! Light from a sky that is everywhere alike.

use glam::{DVec2, DVec3};

use crate::bsdf::Domain;
use crate::frame::Frame;
use crate::warp::{
    square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf, square_to_uniform_hemisphere,
    square_to_uniform_hemisphere_pdf,
};

/// A direction to a sky that is everywhere alike, and its density by solid angle.
///
/// In proportion to the cosine; but where the shading normal is not the geometric one, light also comes from directions
/// below the horizon of the shading normal, so there all directions above the surface are alike. Where light comes
/// through the surface, half of the directions are on either side.
pub(super) fn sample(domain: &Domain, u: DVec2) -> (DVec3, f64) {
    let (n, u) = match (domain.is_two_sided, u.x < 0.5) {
        (false, _) => (domain.n, u),
        (true, true) => (domain.n, DVec2::new(2.0 * u.x, u.y)),
        (true, false) => (-domain.n, DVec2::new(2.0 * u.x - 1.0, u.y)),
    };
    let local = if domain.is_flat { square_to_cosine_hemisphere(u) } else { square_to_uniform_hemisphere(u) };
    let wi = Frame::from_z(n).to_world(local);
    (wi, pdf(domain, wi))
}

/// Density of [`sample`].
pub(super) fn pdf(domain: &Domain, wi: DVec3) -> f64 {
    let cos = domain.n.dot(wi);
    let (cos, share) = if domain.is_two_sided { (cos.abs(), 0.5) } else { (cos, 1.0) };
    let density = match (cos > 0.0, domain.is_flat) {
        (false, _) => 0.0,
        (true, true) => square_to_cosine_hemisphere_pdf(cos),
        (true, false) => square_to_uniform_hemisphere_pdf(),
    };
    density * share
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every domain is covered: the mean of one over the density, over directions that count, is their solid angle.
    #[test]
    fn densities_are_those_of_samples() {
        for (is_flat, is_two_sided) in [(true, false), (false, false), (true, true), (false, true)] {
            let domain = Domain { n: DVec3::new(0.6, 0.0, 0.8), is_flat, is_two_sided };
            let side = 512;
            let cell = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
            let (mut above, mut below) = (0.0, 0.0);
            for i in 0..side * side {
                let (wi, pdf) = sample(&domain, DVec2::new(cell(i % side), cell(i / side)));
                let cos = wi.dot(domain.n);
                // Directions within a cone of cosine 0.5 on either side: of solid angle pi each.
                above += if cos > 0.5 { 1.0 / pdf } else { 0.0 };
                below += if cos < -0.5 { 1.0 / pdf } else { 0.0 };
            }
            let count = f64::from(side * side);
            assert!((above / count - std::f64::consts::PI).abs() < 0.02, "{domain:?} {}", above / count);
            let expected = if is_two_sided { std::f64::consts::PI } else { 0.0 };
            assert!((below / count - expected).abs() < 0.02, "{domain:?} {}", below / count);
        }
    }
}
