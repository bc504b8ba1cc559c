//! How surfaces scatter light.

use std::f32::consts::FRAC_1_PI;

use glam::{DVec2, DVec3, Vec3};
use lookat_scene::Material;

use crate::warp::{Frame, square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf};

/// The scattering of light at a point of a surface. Directions are in the world and point away from the surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bsdf {
    /// The shading frame: z is the shading normal.
    frame: Frame,
    /// The geometric normal: it decides which directions are on the same side.
    n: DVec3,
    lobe: Lobe,
}

#[derive(Debug, Clone, Copy)]
enum Lobe {
    /// PBR 8.3.
    Lambert { reflectance: Vec3 },
    /// PBR 8.4.1.
    OrenNayar { reflectance: Vec3, a: f64, b: f64 },
}

/// A direction that light may come from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BsdfSample {
    pub wi: DVec3,
    /// The BSDF times the cosine to the shading normal.
    pub f_cos: Vec3,
    /// Density of `wi` by solid angle, more than 0.
    pub pdf: f64,
}

impl Bsdf {
    /// `None` for a material that is not there: light passes.
    pub fn new(material: &Material, n: DVec3, ns: DVec3) -> Option<Self> {
        let Material::Matte { kd, sigma } = *material else { return None };
        let lobe = if sigma == 0.0 {
            Lobe::Lambert { reflectance: kd }
        } else {
            let squared = sigma.to_radians().powi(2);
            let a = 1.0 - squared / (2.0 * (squared + 0.33));
            Lobe::OrenNayar { reflectance: kd, a, b: 0.45 * squared / (squared + 0.09) }
        };
        Some(Bsdf { frame: Frame::from_z(ns), n, lobe })
    }

    /// The BSDF times the cosine between `wi` and the shading normal.
    pub fn f_cos(&self, wo: DVec3, wi: DVec3) -> Vec3 {
        if wi.dot(self.n) * wo.dot(self.n) <= 0.0 {
            return Vec3::ZERO;
        }
        let (wo, wi) = (self.frame.to_local(wo), self.frame.to_local(wi));
        self.lobe.f(wo, wi) * wi.z.abs() as f32
    }

    /// Density by solid angle with which [`Bsdf::sample`] gives `wi`.
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let side = self.frame.z.dot(wo) * self.frame.z.dot(wi);
        if side > 0.0 { square_to_cosine_hemisphere_pdf(self.frame.z.dot(wi).abs()) } else { 0.0 }
    }

    /// A direction in proportion to the cosine. `None` where no light is scattered.
    pub fn sample(&self, wo: DVec3, u: DVec2) -> Option<BsdfSample> {
        let cos_o = self.frame.z.dot(wo);
        if cos_o == 0.0 {
            return None;
        }
        let mut local = square_to_cosine_hemisphere(u);
        let pdf = square_to_cosine_hemisphere_pdf(local.z);
        local.z = local.z.copysign(cos_o);
        let wi = self.frame.to_world(local);
        let f_cos = self.f_cos(wo, wi);
        (pdf > 0.0 && f_cos != Vec3::ZERO).then_some(BsdfSample { wi, f_cos, pdf })
    }
}

impl Lobe {
    /// The value for directions in the shading frame.
    fn f(&self, wo: DVec3, wi: DVec3) -> Vec3 {
        match *self {
            Lobe::Lambert { reflectance } => reflectance * FRAC_1_PI,
            Lobe::OrenNayar { reflectance, a, b } => {
                let (sin_i, sin_o) = (wi.truncate().length(), wo.truncate().length());
                let across = wi.truncate().dot(wo.truncate());
                let cos_phi = if sin_i * sin_o > 1e-8 { (across / (sin_i * sin_o)).max(0.0) } else { 0.0 };
                // The larger angle to the normal is alpha, the smaller one beta.
                let (sin_alpha, tan_beta) = if wi.z.abs() > wo.z.abs() {
                    (sin_o, sin_i / wi.z.abs())
                } else {
                    (sin_i, sin_o / wo.z.abs())
                };
                reflectance * FRAC_1_PI * (a + b * cos_phi * sin_alpha * tan_beta) as f32
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bsdfs() -> [Bsdf; 2] {
        let n = DVec3::new(0.3, -0.5, 0.8).normalize();
        [0.0, 40.0].map(|sigma| {
            Bsdf::new(&Material::Matte { kd: Vec3::splat(0.8), sigma }, n, n).expect("matte scatters")
        })
    }

    fn grid(side: u32) -> impl Iterator<Item = DVec2> {
        let cell = move |i: u32| (f64::from(i) + 0.5) / f64::from(side);
        (0..side * side).map(move |i| DVec2::new(cell(i % side), cell(i / side)))
    }

    #[test]
    fn sampled_values_are_those_of_f_and_pdf() {
        for bsdf in bsdfs() {
            let wo = bsdf.frame.to_world(DVec3::new(0.6, 0.0, 0.8));
            for sample in grid(16).filter_map(|u| bsdf.sample(wo, u)) {
                assert!((sample.pdf - bsdf.pdf(wo, sample.wi)).abs() < 1e-12);
                assert!((sample.f_cos - bsdf.f_cos(wo, sample.wi)).length() < 1e-6);
            }
        }
    }

    /// Light is neither made nor, by Lambert, lost; and what goes one way goes the other.
    #[test]
    fn energy_and_reciprocity() {
        let [lambert, rough] = bsdfs();
        for wo in [DVec3::Z, DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.99, 0.0, 0.141)] {
            let albedo = |bsdf: &Bsdf| -> f64 {
                let wo = bsdf.frame.to_world(wo.normalize());
                let samples = grid(64).filter_map(|u| bsdf.sample(wo, u));
                samples.map(|s| f64::from(s.f_cos.x) / s.pdf).sum::<f64>() / 4096.0
            };
            assert!((albedo(&lambert) - 0.8).abs() < 1e-6);
            assert!(albedo(&rough) < 1.0);
        }
        for u in grid(8) {
            let (a, b) = (square_to_cosine_hemisphere(u), DVec3::new(0.48, -0.36, 0.8));
            assert!((rough.lobe.f(a, b) - rough.lobe.f(b, a)).length() < 1e-6);
        }
    }
}
