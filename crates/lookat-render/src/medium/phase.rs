//! Phase functions: the directions into which media scatter light (PBR 11.2, 15.2.3).

use std::f64::consts::PI;

use fearless_simd::{Simd, f32x8, f64x8, mask32x8, prelude::*};

use crate::frame::Frames;
use crate::number::{Vec3fx8, splat_f32, to_f32};
use crate::warp::at_turn;

/// Phase functions of Henyey and Greenstein (PBR 11.2), at points that light leaves towards `wo`.
#[derive(Clone, Copy)]
pub(crate) struct Phase<S: Simd> {
    pub wo: Vec3fx8<S>,
    /// Above -1 and below 1.
    pub asymmetry: f32x8<S>,
}

impl<S: Simd> Phase<S> {
    /// The phase function, which is also the density of [`Phase::sample`] by solid angle.
    #[inline(always)]
    pub fn p(&self, wi: Vec3fx8<S>) -> f32x8<S> {
        let g = self.asymmetry;
        // 1 + g² + 2 g cos, without cancellation.
        let towards = wi + self.wo * splat_f32(g.token(), 1.0).copysign(g);
        let below = (1.0 - g.abs()) * (1.0 - g.abs()) + g.abs() * towards.length_squared();
        (1.0 - g * g) * (1.0 / (4.0 * PI) as f32) / (below * below.sqrt())
    }

    /// Samples a direction.
    #[inline(always)]
    pub fn sample(&self, [u, v]: [f64x8<S>; 2]) -> Vec3fx8<S> {
        let (simd, g) = (u.token(), self.asymmetry);
        let (u, turn) = (to_f32(u), to_f32(v));
        let is_even: mask32x8<S> = g.simd_eq(0.0);
        let root = (1.0 - g * g) / (1.0 + g - 2.0 * g * u);
        let cos = -(1.0 + g * g - root * root) / (2.0 * is_even.select(splat_f32(simd, 1.0), g));
        let cos = is_even.select(1.0 - 2.0 * u, cos).max(-1.0).min(1.0);
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let [x, y] = at_turn(turn);
        let Frames { x: a, y: b, .. } = Frames::from_z(self.wo);
        (a * (x * sin) + b * (y * sin) + self.wo * cos).normalize()
    }
}
