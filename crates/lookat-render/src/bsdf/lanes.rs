//! Diffuse reflection side by side.

use std::f32::consts::FRAC_1_PI;

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::Vec3;
use lookat_scene::{Material, Texture};

use super::lambert;
use crate::frame::lanes::Frames;
use crate::lanes::{Colors, Vec3x8, to_f32};
use crate::warp::lanes::{square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf};

/// The scattering of light at points of diffuse surfaces; as [`super::Bsdf`], to the bit.
#[derive(Clone, Copy)]
pub(crate) struct DiffuseBsdfs<S: Simd> {
    frame: Frames<S>,
    /// Geometric normals on the side of the directions towards which light is scattered.
    n: Vec3x8<S>,
    /// The cosines between these directions and the normals.
    cos_o: f64x8<S>,
    /// Reflectances over pi.
    f: Colors<S>,
}

/// Directions that light may come from; as [`super::BsdfSample`], where there is one.
pub(crate) struct BsdfSamples<S: Simd> {
    pub is_there: mask64x8<S>,
    pub wi: Vec3x8<S>,
    /// By what radiance is multiplied.
    pub weight: Colors<S>,
}

/// What [`DiffuseBsdfs`] is made of: the reflectance over pi of a material that is diffuse and everywhere alike.
pub(crate) fn diffuse(material: &Material) -> Option<Vec3> {
    let Texture::Constant(kd) = lambert(&material.kind)? else { return None };
    (!material.needs.coordinates).then(|| kd.max(Vec3::ZERO) * FRAC_1_PI)
}

impl<S: Simd> DiffuseBsdfs<S> {
    /// Those at points with normals `n`, towards `wo`; `f` is that of [`diffuse`].
    #[inline(always)]
    pub fn new(n: Vec3x8<S>, wo: Vec3x8<S>, f: Colors<S>) -> Self {
        let cos_o = n.dot(wo);
        DiffuseBsdfs { frame: Frames::from_z(n), n: (-n).or(cos_o.simd_lt(0.0), n), cos_o, f }
    }

    /// As [`super::Bsdf::f_cos`].
    #[inline(always)]
    pub fn f_cos(&self, wi: Vec3x8<S>) -> Colors<S> {
        let is_above = self.cos_o.simd_ne(0.0) & wi.dot(self.n).simd_gt(0.0);
        let value = self.f * to_f32(self.frame.z.dot(wi).abs());
        value.or(is_above, Colors::splat(wi.x.token(), Vec3::ZERO))
    }

    /// As [`super::Bsdf::sample`].
    #[inline(always)]
    pub fn sample(&self, u: [f64x8<S>; 2]) -> BsdfSamples<S> {
        let local = square_to_cosine_hemisphere(u);
        let wi = self.frame.to_world(Vec3x8 { z: local.z.copysign(self.cos_o), ..local });
        let (pdf, f_cos) = (square_to_cosine_hemisphere_pdf(local.z), self.f_cos(wi));
        let is_there = self.cos_o.simd_ne(0.0) & pdf.simd_gt(0.0) & f_cos.is_light();
        BsdfSamples { is_there, wi, weight: f_cos / to_f32(pdf) }
    }
}
