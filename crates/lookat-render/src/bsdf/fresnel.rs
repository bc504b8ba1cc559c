//! How much a smooth boundary reflects (PBR 8.2.1).

use glam::Vec3;

/// What reflects.
#[derive(Debug, Clone, Copy)]
pub(super) enum Fresnel {
    /// Everything is reflected.
    Perfect,
    /// A boundary between dielectrics. `eta` is the index of refraction behind it by that before it, where the normal
    /// points.
    Dielectric { eta: f64 },
    /// A conductor in air: index of refraction and absorption coefficient.
    Conductor { eta: Vec3, k: Vec3 },
}

impl Fresnel {
    /// The reflected share of unpolarized light that comes at an angle of cosine `cos` to the normal.
    pub fn reflected(&self, cos: f64) -> Vec3 {
        match *self {
            Fresnel::Perfect => Vec3::ONE,
            Fresnel::Dielectric { eta } => Vec3::splat(dielectric(cos, eta) as f32),
            Fresnel::Conductor { eta, k } => conductor(cos.abs() as f32, eta, k),
        }
    }
}

/// The reflected share at a boundary between dielectrics. A negative `cos` is that of light from behind it.
pub(super) fn dielectric(cos: f64, eta: f64) -> f64 {
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

/// The reflected share at a conductor, channel by channel.
fn conductor(cos: f32, eta: Vec3, k: Vec3) -> Vec3 {
    let (cos2, sin2) = (Vec3::splat(cos * cos), Vec3::splat((1.0 - cos * cos).max(0.0)));
    let (eta2, k2) = (eta * eta, k * k);
    let t0 = eta2 - k2 - sin2;
    let a2_plus_b2 = root(t0 * t0 + 4.0 * eta2 * k2);
    let a = root(0.5 * (a2_plus_b2 + t0));
    let across = 2.0 * cos * a;
    let perpendicular = (a2_plus_b2 + cos2 - across) / (a2_plus_b2 + cos2 + across);
    let (sum, along) = (cos2 * a2_plus_b2 + sin2 * sin2, across * sin2);
    let parallel = perpendicular * (sum - along) / (sum + along);
    // Without an index, 0 by 0 at grazing light, which is reflected.
    let both = 0.5 * (perpendicular + parallel);
    Vec3::select(both.is_nan_mask(), Vec3::ONE, both)
}

fn root(x: Vec3) -> Vec3 {
    x.max(Vec3::ZERO).map(f32::sqrt)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At normal incidence ((eta - 1) / (eta + 1))^2; at Brewster's angle half of what is perpendicular; beyond the
    /// critical angle everything.
    #[test]
    fn dielectrics_have_their_known_values() {
        assert!((dielectric(1.0, 1.5) - 0.04).abs() < 1e-12);
        assert!((dielectric(-1.0, 1.5) - 0.04).abs() < 1e-12);
        let brewster = 1.5_f64.atan().cos();
        assert!((dielectric(brewster, 1.5) - 0.5 * (1.25 / 3.25_f64).powi(2)).abs() < 1e-12);
        assert_eq!(dielectric(-0.7, 1.5), 1.0);
        assert!(dielectric(0.3, 1.0) < 1e-30);
    }

    /// At normal incidence ((eta - 1)^2 + k^2) / ((eta + 1)^2 + k^2); grazing light is reflected; without absorption it is
    /// the dielectric.
    #[test]
    fn conductors_have_their_known_values() {
        let (eta, k) = (Vec3::new(0.2, 0.9, 1.1), Vec3::new(3.9, 2.4, 2.1));
        let normal = ((eta - 1.0) * (eta - 1.0) + k * k) / ((eta + 1.0) * (eta + 1.0) + k * k);
        assert!((conductor(1.0, eta, k) - normal).abs().max_element() < 1e-6);
        assert!((conductor(0.0, eta, k) - Vec3::ONE).abs().max_element() < 1e-6);
        for cos in [0.1, 0.5, 0.9] {
            let clear = conductor(cos as f32, Vec3::splat(1.5), Vec3::ZERO);
            assert!((f64::from(clear.x) - dielectric(cos, 1.5)).abs() < 1e-5);
        }
        assert!(conductor(0.0, Vec3::ZERO, Vec3::ZERO).is_finite());
    }
}
