//! Single directions, in the world: exact, so that what is seen in a mirror is where it is.

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};

use super::fresnel::{Fresnel, dielectric};
use super::lobe::{Kind, Lobes};
use crate::number::{Colors, Vec3x8, narrow, splat_f32, to_f32, to_f64, widen};

/// Directions of lobes that have only single ones.
#[derive(Clone, Copy)]
pub(crate) struct Single<S: Simd> {
    pub is_there: mask64x8<S>,
    pub wi: Vec3x8<S>,
    /// Radiance from `wi` times this comes along `wo`.
    pub factor: Colors<S>,
    /// The probability of this direction among the directions of the lobe.
    pub probability: f32x8<S>,
    /// What refraction alone does to radiance: the ratio of the squared indices, or 1.
    pub compression: f32x8<S>,
}

impl<S: Simd> Lobes<S> {
    /// One of the single directions at points with shading normals `n`.
    #[inline(always)]
    pub fn single(&self, n: Vec3x8<S>, wo: Vec3x8<S>, u: f64x8<S>) -> Single<S> {
        let cos = n.dot(wo);
        match self.kind {
            Kind::Mirror(fresnel) => mirrored(n, wo, self.fresnel(fresnel, to_f32(cos))),
            Kind::Glass => {
                let share = dielectric(to_f32(cos), self.eta);
                let [reflectance, transmittance] = self.colors;
                let reflected = Single { probability: share, ..mirrored(n, wo, reflectance * share) };
                let refracted = Single {
                    probability: 1.0 - share,
                    ..self.refracted(n, wo, transmittance * (1.0 - share))
                };
                reflected.or(u.simd_lt(to_f64(share)), refracted)
            }
            _ => self.refracted(n, wo, self.color - self.fresnel(Fresnel::Dielectric, to_f32(cos))),
        }
    }

    /// Light that a smooth boundary refracts.
    #[inline(always)]
    fn refracted(&self, n: Vec3x8<S>, wo: Vec3x8<S>, factor: Colors<S>) -> Single<S> {
        let (eta, cos) = (to_f64(self.eta), n.dot(wo));
        let (n, cos) = ((-n).or(cos.simd_lt(0.0), n), (cos, cos.abs()));
        let ratio = cos.0.simd_gt(0.0).select(eta, 1.0 / eta);
        let along = (n * cos.1 - wo) * (1.0 / ratio);
        let squared = 1.0 - along.length_squared();
        let compression = self.compression(to_f32(cos.0), to_f32(cos.0));
        Single {
            is_there: squared.simd_gt(0.0),
            wi: (along - n * squared.max(0.0).sqrt()).normalize(),
            factor: factor * compression,
            probability: splat_f32(compression.token(), 1.0),
            compression,
        }
    }
}

#[inline(always)]
fn mirrored<S: Simd>(n: Vec3x8<S>, wo: Vec3x8<S>, factor: Colors<S>) -> Single<S> {
    let one = splat_f32(factor.x.token(), 1.0);
    Single {
        is_there: widen(one.simd_gt(0.0)),
        wi: (n * (2.0 * n.dot(wo)) - wo).normalize(),
        factor,
        probability: one,
        compression: one,
    }
}

impl<S: Simd> Single<S> {
    /// These where `mask` says so, and the others elsewhere.
    #[inline(always)]
    pub fn or(self, mask: mask64x8<S>, others: Self) -> Self {
        let own = narrow(mask);
        Single {
            is_there: mask & self.is_there | !mask & others.is_there,
            wi: self.wi.or(mask, others.wi),
            factor: self.factor.or(own, others.factor),
            probability: own.select(self.probability, others.probability),
            compression: own.select(self.compression, others.compression),
        }
    }
}
