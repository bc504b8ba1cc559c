//! The Fresnel equations: how much a smooth boundary reflects (PBR 8.2.1).

use fearless_simd::{Simd, f32x8, prelude::*};
use glam::Vec3;

use crate::number::{Vec3fx8, splat_f32};

/// The reflected share of unpolarized light at a boundary between dielectrics. `cos`: the cosine to the normal, negative for light from
/// behind. `eta`: the index of refraction behind the boundary over the index in front, where the normal points.
#[inline(always)]
pub(super) fn dielectric<S: Simd>(cos: f32x8<S>, eta: f32x8<S>) -> f32x8<S> {
    let ratio = cos.simd_gt(0.0).select(eta, 1.0 / eta);
    let cos = cos.abs();
    // The squared cosine behind the boundary times the squared ratio, without a difference of nearly equal numbers where media are alike.
    let squared = (ratio - 1.0) * (ratio + 1.0) + cos * cos;
    let (behind, before) = (squared.sqrt(), ratio * ratio * cos);
    let parallel = (before - behind) / (before + behind);
    let perpendicular = (cos - behind) / (cos + behind);
    let share = (parallel * parallel + perpendicular * perpendicular) * 0.5;
    squared.simd_le(0.0).select(splat_f32(cos.token(), 1.0), share)
}

/// The reflected share at a conductor of some index of refraction and absorption coefficient, channel by channel.
#[inline(always)]
pub(super) fn conductor<S: Simd>(cos: f32x8<S>, [eta, k]: [Vec3fx8<S>; 2]) -> Vec3fx8<S> {
    let of = |eta, k| conductor_channel(cos.abs(), eta, k);
    Vec3fx8 { x: of(eta.x, k.x), y: of(eta.y, k.y), z: of(eta.z, k.z) }
}

#[inline(always)]
fn conductor_channel<S: Simd>(cos: f32x8<S>, eta: f32x8<S>, k: f32x8<S>) -> f32x8<S> {
    let root = |x: f32x8<S>| x.max(0.0).sqrt();
    let cos2 = cos * cos;
    let sin2 = (1.0 - cos2).max(0.0);
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
    both.is_nan().select(splat_f32(cos.token(), 1.0), both)
}

/// Schlick's approximation of what is reflected: `at_normal` at normal incidence.
#[inline(always)]
pub(super) fn schlick<S: Simd>(at_normal: Vec3fx8<S>, cos: f32x8<S>) -> Vec3fx8<S> {
    let (white, x) = (Vec3fx8::splat(cos.token(), Vec3::ONE), 1.0 - cos);
    at_normal + (white - at_normal) * (x * x * x * x * x)
}

/// The weight of grazing light in Schlick's approximation.
#[inline(always)]
pub(super) fn schlick_weight<S: Simd>(cos: f32x8<S>) -> f32x8<S> {
    let x = (1.0 - cos).max(0.0).min(1.0);
    x * x * x * x * x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::baseline;

    fn dielectric_at(cos: f32, eta: f32) -> f32 {
        baseline!(simd => dielectric(splat_f32(simd, cos), splat_f32(simd, eta))[0])
    }

    fn conductor_at(cos: f32, eta: Vec3, k: Vec3) -> Vec3 {
        let of = |eta, k| {
            baseline!(simd => {
                conductor_channel(splat_f32(simd, cos), splat_f32(simd, eta), splat_f32(simd, k))[0]
            })
        };
        Vec3::new(of(eta.x, k.x), of(eta.y, k.y), of(eta.z, k.z))
    }

    /// At normal incidence ((eta - 1) / (eta + 1))^2; at Brewster's angle half of what is perpendicular; beyond the
    /// critical angle everything.
    #[test]
    fn dielectrics_have_their_known_values() {
        assert!((dielectric_at(1.0, 1.5) - 0.04).abs() < 1e-7);
        assert!((dielectric_at(-1.0, 1.5) - 0.04).abs() < 1e-7);
        let brewster = 1.5_f32.atan().cos();
        assert!((dielectric_at(brewster, 1.5) - 0.5 * (1.25 / 3.25_f32).powi(2)).abs() < 1e-7);
        assert_eq!(dielectric_at(-0.7, 1.5), 1.0);
        assert!(dielectric_at(0.3, 1.0) < 1e-12);
    }

    /// At normal incidence ((eta - 1)^2 + k^2) / ((eta + 1)^2 + k^2); grazing light is reflected; without absorption it is
    /// the dielectric.
    #[test]
    fn conductors_have_their_known_values() {
        let (eta, k) = (Vec3::new(0.2, 0.9, 1.1), Vec3::new(3.9, 2.4, 2.1));
        let normal = ((eta - 1.0) * (eta - 1.0) + k * k) / ((eta + 1.0) * (eta + 1.0) + k * k);
        assert!((conductor_at(1.0, eta, k) - normal).abs().max_element() < 1e-6);
        assert!((conductor_at(0.0, eta, k) - Vec3::ONE).abs().max_element() < 1e-6);
        for cos in [0.1, 0.5, 0.9] {
            let clear = conductor_at(cos, Vec3::splat(1.5), Vec3::ZERO);
            assert!((clear.x - dielectric_at(cos, 1.5)).abs() < 1e-5);
        }
        assert!(conductor_at(0.0, Vec3::ZERO, Vec3::ZERO).is_finite());
    }
}
