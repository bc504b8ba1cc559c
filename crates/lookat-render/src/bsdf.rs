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
    /// PBR 8.2.2.
    Mirror { reflectance: Vec3 },
    /// PBR 8.2.2, 8.2.3.
    Glass { reflectance: Vec3, transmittance: Vec3, eta: f64 },
}

/// A direction that light may come from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BsdfSample {
    pub wi: DVec3,
    /// The BSDF times the cosine to the shading normal.
    pub f_cos: Vec3,
    /// Density of `wi` by solid angle, more than 0. Of a specular sample the probability of its direction.
    pub pdf: f64,
    /// No other direction could have been sampled nearby.
    pub is_specular: bool,
    /// What refraction alone does to radiance, and the way out undoes: the ratio of the squared indices of refraction, or 1.
    pub compression: f32,
}

impl BsdfSample {
    /// By what radiance from `wi` is multiplied.
    pub fn weight(&self) -> Vec3 {
        self.f_cos / self.pdf as f32
    }
}

impl Bsdf {
    /// `None` for a material that is not there: light passes.
    pub fn new(material: &Material, n: DVec3, ns: DVec3) -> Option<Self> {
        let lobe = match *material {
            Material::Matte { kd, sigma: 0.0 } => Lobe::Lambert { reflectance: kd },
            Material::Matte { kd, sigma } => {
                let squared = sigma.to_radians().powi(2);
                let a = 1.0 - squared / (2.0 * (squared + 0.33));
                Lobe::OrenNayar { reflectance: kd, a, b: 0.45 * squared / (squared + 0.09) }
            }
            Material::Mirror { kr } => Lobe::Mirror { reflectance: kr },
            Material::Glass { kr, kt, eta } => Lobe::Glass { reflectance: kr, transmittance: kt, eta },
            Material::None => return None,
        };
        Some(Bsdf { frame: Frame::from_z(ns), n, lobe })
    }

    /// Whether it scatters into single directions only, which lights cannot be sampled for.
    pub fn is_specular(&self) -> bool {
        matches!(self.lobe, Lobe::Mirror { .. } | Lobe::Glass { .. })
    }

    /// The BSDF times the cosine between `wi` and the shading normal; 0 if it is specular.
    pub fn f_cos(&self, wo: DVec3, wi: DVec3) -> Vec3 {
        if wi.dot(self.n) * wo.dot(self.n) <= 0.0 || self.is_specular() {
            return Vec3::ZERO;
        }
        let (wo, wi) = (self.frame.to_local(wo), self.frame.to_local(wi));
        self.lobe.f(wo, wi) * wi.z.abs() as f32
    }

    /// Density by solid angle with which [`Bsdf::sample`] gives `wi`; 0 if it is specular.
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let side = self.frame.z.dot(wo) * self.frame.z.dot(wi);
        if side > 0.0 && !self.is_specular() {
            square_to_cosine_hemisphere_pdf(self.frame.z.dot(wi).abs())
        } else {
            0.0
        }
    }

    /// A direction in proportion to the cosine, or one of those of a specular surface. `None` where no light is scattered.
    pub fn sample(&self, wo: DVec3, u: DVec2) -> Option<BsdfSample> {
        let cos_o = self.frame.z.dot(wo);
        if cos_o == 0.0 {
            return None;
        }
        match self.lobe {
            Lobe::Mirror { reflectance } => return self.reflected(wo, cos_o, reflectance, 1.0),
            Lobe::Glass { reflectance, transmittance, eta } => {
                let reflected = fresnel(cos_o, eta);
                return if u.x < reflected {
                    self.reflected(wo, cos_o, reflectance * reflected as f32, reflected)
                } else {
                    self.refracted(wo, cos_o, transmittance * (1.0 - reflected) as f32, 1.0 - reflected, eta)
                };
            }
            Lobe::Lambert { .. } | Lobe::OrenNayar { .. } => {}
        }
        let mut local = square_to_cosine_hemisphere(u);
        let pdf = square_to_cosine_hemisphere_pdf(local.z);
        local.z = local.z.copysign(cos_o);
        let wi = self.frame.to_world(local);
        let f_cos = self.f_cos(wo, wi);
        let sample = BsdfSample { wi, f_cos, pdf, is_specular: false, compression: 1.0 };
        (pdf > 0.0 && f_cos != Vec3::ZERO).then_some(sample)
    }

    /// Light that comes by way of a mirror.
    fn reflected(&self, wo: DVec3, cos_o: f64, f_cos: Vec3, pdf: f64) -> Option<BsdfSample> {
        let wi = (self.frame.z * (2.0 * cos_o) - wo).normalize();
        (f_cos != Vec3::ZERO).then_some(BsdfSample { wi, f_cos, pdf, is_specular: true, compression: 1.0 })
    }

    /// Light that comes from the other side (Snell's law).
    fn refracted(&self, wo: DVec3, cos_o: f64, f_cos: Vec3, pdf: f64, eta: f64) -> Option<BsdfSample> {
        // From the side of `wo` to the other one.
        let ratio = if cos_o > 0.0 { 1.0 / eta } else { eta };
        let along = (wo - self.frame.z * cos_o) * -ratio;
        let squared = 1.0 - along.length_squared();
        if squared <= 0.0 {
            return None;
        }
        let wi = (along - self.frame.z * squared.sqrt().copysign(cos_o)).normalize();
        let compression = (ratio * ratio) as f32;
        let sample = BsdfSample { wi, f_cos: f_cos * compression, pdf, is_specular: true, compression };
        (f_cos != Vec3::ZERO).then_some(sample)
    }
}

/// The share of unpolarized light that a smooth surface between dielectrics reflects (PBR 8.2.1). `cos` is that of the
/// angle to the normal; `eta` the index of refraction behind the surface by that before it, where the normal points.
fn fresnel(cos: f64, eta: f64) -> f64 {
    let ratio = if cos > 0.0 { eta } else { 1.0 / eta };
    let cos = cos.abs();
    let squared = 1.0 - (1.0 - cos * cos) / (ratio * ratio);
    if squared <= 0.0 {
        return 1.0;
    }
    let cos_t = squared.sqrt();
    let parallel = (ratio * cos - cos_t) / (ratio * cos + cos_t);
    let perpendicular = (cos - ratio * cos_t) / (cos + ratio * cos_t);
    (parallel * parallel + perpendicular * perpendicular) / 2.0
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
            Lobe::Mirror { .. } | Lobe::Glass { .. } => Vec3::ZERO,
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

    /// At normal incidence ((eta - 1) / (eta + 1))^2; at Brewster's angle half of what is perpendicular; beyond the
    /// critical angle everything.
    #[test]
    fn fresnel_has_its_known_values() {
        assert!((fresnel(1.0, 1.5) - 0.04).abs() < 1e-12);
        assert!((fresnel(-1.0, 1.5) - 0.04).abs() < 1e-12);
        let brewster = 1.5_f64.atan().cos();
        assert!((fresnel(brewster, 1.5) - 0.5 * (1.25 / 3.25_f64).powi(2)).abs() < 1e-12);
        assert_eq!(fresnel(-0.7, 1.5), 1.0);
        assert!(fresnel(0.3, 1.0) < 1e-30);
    }

    /// Light that goes in and out of glass keeps its direction and its energy.
    #[test]
    fn refraction_is_undone_on_the_way_out() {
        let n = DVec3::new(0.3, -0.5, 0.8).normalize();
        let glass = Material::Glass { kr: Vec3::ONE, kt: Vec3::ONE, eta: 1.5 };
        let bsdf = Bsdf::new(&glass, n, n).unwrap();
        for local in [DVec3::Z, DVec3::new(0.6, 0.0, 0.8), DVec3::new(-0.9, 0.2, 0.4)] {
            let wo = bsdf.frame.to_world(local.normalize());
            let through = bsdf.sample(wo, DVec2::splat(0.999_999)).unwrap();
            assert!(through.is_specular && through.wi.dot(n) < 0.0);
            let sines = [wo, through.wi].map(|w| w.cross(n).length());
            assert!((sines[0] - 1.5 * sines[1]).abs() < 1e-12);
            let back = bsdf.sample(through.wi, DVec2::splat(0.999_999)).unwrap();
            assert!((back.wi - wo).length() < 1e-12);
            assert!((through.weight() * back.weight() - Vec3::ONE).length() < 1e-6);
            assert!((through.compression * back.compression - 1.0).abs() < 1e-6);
            // With all directions everything comes back: the white furnace.
            let all: f64 = [0.0, 0.999_999]
                .iter()
                .filter_map(|u| bsdf.sample(wo, DVec2::splat(*u)))
                .map(|sample| f64::from(sample.f_cos.x / sample.compression))
                .sum();
            assert!((all - 1.0).abs() < 1e-6);
            let mirrored = bsdf.sample(wo, DVec2::ZERO).unwrap().wi;
            assert!((mirrored + wo - n * (2.0 * wo.dot(n))).length() < 1e-12);
        }
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
