//! Directions that light comes from, but that BSDF samples miss.

use glam::{DVec2, DVec3};

use crate::bsdf::Domain;
use crate::frame::Frame;

/// Directions between two planes: above the surface, but on the other side of the shading normal than `wo`. Where light
/// comes through the surface, also those opposite to them.
///
/// pbrt-v3 counts light from there, by the absolute cosine to the shading normal, and does not sample it by the BSDF.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lune {
    n: DVec3,
    ns: DVec3,
    /// The edge of the lune, of length one: across both normals.
    axis: DVec3,
    /// Between the normals, more than 0 and up to pi.
    angle: f64,
    /// With the opposite lune.
    is_double: bool,
}

/// The sine of the least angle between normals that counts: below it, less than 1e-12 of the light is left out, and
/// rounding would decide what lies inside.
const LEAST: f64 = 1e-6;

impl Lune {
    /// `None` where the normals are the same, but for rounding.
    #[inline]
    pub fn new(domain: &Domain) -> Option<Lune> {
        (domain.n != domain.ns).then(|| Lune::between(domain)).flatten()
    }

    fn between(&Domain { n, ns, is_two_sided, .. }: &Domain) -> Option<Lune> {
        let (across, cos) = (n.cross(ns), n.dot(ns));
        let sin = across.length();
        let axis = match sin > LEAST {
            true => across / sin,
            false if cos > 0.0 => return None,
            // Any, as the lune is a hemisphere.
            false => Frame::from_z(n).x,
        };
        Some(Lune { n, ns, axis, angle: sin.atan2(cos), is_double: is_two_sided })
    }

    /// What it adds to the irradiance under a sky that is everywhere alike, by the cosine to the shading normal, over that of
    /// a whole hemisphere; for two lunes the sum.
    pub fn share(&self) -> f64 {
        (0.5 * self.angle).sin().powi(2) * if self.is_double { 2.0 } else { 1.0 }
    }

    /// A direction, all alike.
    pub fn sample(&self, u: DVec2) -> DVec3 {
        let z = 2.0 * u.x - 1.0;
        let (sign, u) = match self.is_double {
            true if u.y < 0.5 => (-1.0, 2.0 * u.y),
            true => (1.0, 2.0 * u.y - 1.0),
            false => (1.0, u.y),
        };
        // From the plane of the surface, which is a quarter turn before its normal.
        let (sin, cos) = (self.angle * u).sin_cos();
        let around = self.n * sin - self.axis.cross(self.n) * cos;
        sign * (self.axis * z + around * ((1.0 - z) * (1.0 + z)).max(0.0).sqrt())
    }

    /// Density of [`Lune::sample`] by solid angle.
    pub fn pdf(&self, wi: DVec3) -> f64 {
        let (above, before) = (wi.dot(self.n), wi.dot(self.ns));
        let is_inside = above * before < 0.0 && (self.is_double || above > 0.0);
        if is_inside { self.inside_pdf() } else { 0.0 }
    }

    /// The density inside.
    pub fn inside_pdf(&self) -> f64 {
        1.0 / (2.0 * self.angle * if self.is_double { 2.0 } else { 1.0 })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn domain(degrees: f64, is_two_sided: bool) -> Domain {
        let n = DVec3::new(0.6, 0.0, 0.8);
        let ns = glam::DQuat::from_axis_angle(DVec3::new(0.8, 0.0, -0.6), degrees.to_radians()) * n;
        Domain { n, ns, is_two_sided, is_diffuse: false }
    }

    fn grid(side: u32) -> impl Iterator<Item = DVec2> {
        let cell = move |i: u32| (f64::from(i) + 0.5) / f64::from(side);
        (0..side * side).map(move |i| DVec2::new(cell(i % side), cell(i / side)))
    }

    /// All samples lie inside, and cover it: its irradiance is that which the share says.
    #[test]
    fn samples_cover_the_lune_with_their_density() {
        for (degrees, is_two_sided) in
            [(1e-4, false), (5.0, false), (40.0, true), (130.0, false), (180.0, false)]
        {
            let domain = domain(degrees, is_two_sided);
            let lune = Lune::new(&domain).unwrap();
            let mut irradiance = 0.0;
            for u in grid(200) {
                let wi = lune.sample(u);
                assert!((wi.length() - 1.0).abs() < 1e-12);
                assert_eq!(lune.pdf(wi), lune.inside_pdf(), "{domain:?} {wi}");
                irradiance += wi.dot(domain.ns).abs() / lune.inside_pdf() / 40_000.0;
            }
            assert!((irradiance / (PI * lune.share()) - 1.0).abs() < 1e-3, "{domain:?} {irradiance}");
        }
    }

    /// The density is that of the solid angle which satisfies the definition.
    #[test]
    fn the_density_has_an_integral_of_one() {
        for (degrees, is_two_sided) in [(20.0, false), (20.0, true), (100.0, false)] {
            let domain = domain(degrees, is_two_sided);
            let lune = Lune::new(&domain).unwrap();
            let on_sphere = |u: DVec2| {
                let z = 1.0 - 2.0 * u.y;
                (DVec2::from_angle(2.0 * PI * u.x) * ((1.0 - z) * (1.0 + z)).sqrt()).extend(z)
            };
            let mean = grid(1000).map(|u| lune.pdf(on_sphere(u))).sum::<f64>() / 1e6;
            assert!((mean * 4.0 * PI - 1.0).abs() < 0.01, "{domain:?} {mean}");
        }
    }

    #[test]
    fn equal_normals_leave_nothing_out() {
        assert!(Lune::new(&domain(0.0, true)).is_none());
        let Domain { n, .. } = domain(0.0, false);
        for tilt in [1e-17, 1e-16, 3e-16, 1e-12, 1e-8] {
            let ns = (n + DVec3::new(0.8, 0.0, -0.6) * tilt).normalize();
            assert!(Lune::new(&Domain { n, ns, is_two_sided: false, is_diffuse: false }).is_none(), "{tilt}");
        }
    }
}
