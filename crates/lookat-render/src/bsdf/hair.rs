//! Hair (Chiang et al., "A Practical and Controllable Hair and Fur Model for Production Path Tracing", EGSR 2016;
//! materials/hair.cpp). A fiber lies along x of the shading frame.

use std::f32::consts::{PI, TAU};

use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use glam::Vec3;
use lookat_scene::LUMINANCE;

use super::BELOW_ONE;
use super::fresnel::dielectric;
use super::lobe::Lobes;
use crate::number::{V3, Vec3fx8, exp_minus, ln, splat_f32, to_f32, to_f64, vectorized};
use crate::warp::{angle, at_turn};

/// The events of light in a fiber: reflection, transmission, reflection inside, and all that have more of these.
const EVENTS: usize = 4;

/// What fibers scatter of light from one direction.
struct Fibers<S: Simd> {
    /// The sines and cosines of the angles to the normal plane: of `wo`, as the tilted scales turn it, for each event.
    tilted: [[f32x8<S>; 2]; EVENTS],
    /// The attenuation by each event (`Ap`).
    attenuation: [Vec3fx8<S>; EVENTS],
    /// The probability with which each event is sampled.
    share: [f32x8<S>; EVENTS],
    /// The azimuths to which a smooth fiber would turn light (`Phi`), except for the last event.
    azimuth: [f32x8<S>; EVENTS - 1],
    /// The variance along the fiber of each event.
    variance: [f32x8<S>; EVENTS],
    /// The scale of the logistic distribution around the fiber.
    scale: f32x8<S>,
}

impl<S: Simd> Fibers<S> {
    /// `colors` of the lobe: the absorption coefficient; and the offset `h` across the fiber with sine and cosine of the
    /// angle of the scales. `roughness`: the variance along the fiber and the scale around it.
    #[inline(always)]
    fn new(lobe: &Lobes<S>, wo: Vec3fx8<S>) -> Self {
        let [absorption, V3 { x: h, y: sin, z: cos }] = lobe.colors;
        let [v, scale] = lobe.roughness;
        let eta = lobe.eta;
        let [sin_o, cos_o] = sin_cos(wo.x);
        // The refracted ray.
        let sin_t = sin_o / eta;
        let cos_t = (1.0 - sin_t * sin_t).max(LEAST).sqrt();
        let across = (eta * eta - sin_o * sin_o).max(LEAST).sqrt() / cos_o.max(LEAST);
        let (sin_gamma_t, cos_gamma_o) = (h / across, (1.0 - h * h).max(0.0).sqrt());
        let cos_gamma_t = (1.0 - sin_gamma_t * sin_gamma_t).max(0.0).sqrt();
        let (gamma_o, gamma_t) = (azimuth(h, cos_gamma_o), azimuth(sin_gamma_t, cos_gamma_t));

        let fresnel = dielectric(cos_o * cos_gamma_o, eta);
        let length = 2.0 * cos_gamma_t / cos_t;
        let passed = absorption * length;
        let passed = V3 { x: exp_minus(passed.x), y: exp_minus(passed.y), z: exp_minus(passed.z) };
        let white = Vec3fx8::splat(eta.token(), Vec3::ONE);
        let first = passed * ((1.0 - fresnel) * (1.0 - fresnel));
        let inside = passed * fresnel;
        let second = first * inside;
        let rest = second * inside;
        let rest = V3 { x: rest.x / left(inside.x), y: rest.y / left(inside.y), z: rest.z / left(inside.z) };
        let attenuation = [white * fresnel, first, second, rest];
        let [a, b, c, d] = attenuation;
        let amounts = [amount(a), amount(b), amount(c), amount(d)];
        let sum = amounts[0] + amounts[1] + amounts[2] + amounts[3];
        // A fiber may absorb all light that enters, and reflect none.
        let sum = sum.max(splat_f32(sum.token(), f32::MIN_POSITIVE));

        let (sin_2, cos_2) = (2.0 * cos * sin, cos * cos - sin * sin);
        let (sin_4, cos_4) = (2.0 * cos_2 * sin_2, cos_2 * cos_2 - sin_2 * sin_2);
        let turned =
            |sin: f32x8<S>, cos: f32x8<S>| [sin_o * cos + cos_o * sin, (cos_o * cos - sin_o * sin).abs()];
        Fibers {
            tilted: [turned(-sin_2, cos_2), turned(sin, cos), turned(sin_4, cos_4), [sin_o, cos_o]],
            attenuation,
            share: [amounts[0] / sum, amounts[1] / sum, amounts[2] / sum, amounts[3] / sum],
            azimuth: [-2.0 * gamma_o, 2.0 * (gamma_t - gamma_o) + PI, 4.0 * gamma_t - 2.0 * gamma_o + TAU],
            variance: [v, 0.25 * v, 4.0 * v, 4.0 * v],
            scale,
        }
    }

    /// The density along the fiber (`Mp`), by the cosine of the angle.
    #[inline(always)]
    fn along(&self, event: usize, [sin_i, cos_i]: [f32x8<S>; 2]) -> f32x8<S> {
        let ([sin_o, cos_o], v) = (self.tilted[event], self.variance[event]);
        // 2 - 2 cos(theta_o + theta_i), without a difference of nearly equal numbers.
        let (x, y) = (cos_i - cos_o, sin_i + sin_o);
        let falloff = exp_minus((x * x + y * y) / (2.0 * v));
        bessel(cos_i * cos_o / v) * falloff / (v * (1.0 - exp_minus(2.0 / v)))
    }

    /// The density around the fiber (`Np`).
    #[inline(always)]
    fn around(&self, event: usize, phi: f32x8<S>) -> f32x8<S> {
        let Some(azimuth) = self.azimuth.get(event) else { return splat_f32(phi.token(), 1.0 / TAU) };
        let turned = phi - *azimuth;
        let turned = turned - (turned * (1.0 / TAU) + 0.5).floor() * TAU;
        let e = exp_minus(turned.abs() / self.scale);
        let (_, range) = self.logistic_range();
        e / (self.scale * (1.0 + e) * (1.0 + e) * range)
    }

    /// The density of an event. Out of line: its copies for all events would leave the instruction cache.
    #[inline(never)]
    fn density(&self, event: usize, along: [f32x8<S>; 2], phi: f32x8<S>) -> f32x8<S> {
        vectorized!(phi.token(), self.along(event, along) * self.around(event, phi))
    }

    /// The share of a logistic distribution below minus pi, and the share from there to pi.
    #[inline(always)]
    fn logistic_range(&self) -> (f32x8<S>, f32x8<S>) {
        let e = exp_minus(PI / self.scale);
        (e / (1.0 + e), (1.0 - e) / (1.0 + e))
    }
}

impl<S: Simd> Lobes<'_, S> {
    /// The value of the BSDF, and the density of [`Lobes::hair_sample`].
    #[inline(never)]
    pub fn hair_f_pdf(&self, wo: Vec3fx8<S>, wi: Vec3fx8<S>) -> (Vec3fx8<S>, f32x8<S>) {
        let simd = wo.x.token();
        vectorized!(simd, {
            let (fibers, along) = (Fibers::new(self, wo), sin_cos(wi.x));
            let phi = azimuth(wi.z * wo.y - wi.y * wo.z, wi.y * wo.y + wi.z * wo.z);
            let (mut f, mut pdf) = (Vec3fx8::splat(simd, Vec3::ZERO), splat_f32(simd, 0.0));
            for event in 0..EVENTS {
                let density = fibers.density(event, along, phi);
                f = f + fibers.attenuation[event] * density;
                pdf += fibers.share[event] * density;
            }
            let cos = wi.z.abs();
            (self.color * f * (1.0 / cos.simd_gt(0.0).select(cos, splat_f32(simd, 1.0))), pdf)
        })
    }

    /// A direction. `fine`: a third number from 0 to 1.
    #[inline(never)]
    pub fn hair_sample(
        &self,
        wo: Vec3fx8<S>,
        [u, v]: [f32x8<S>; 2],
        fine: f32x8<S>,
    ) -> (Vec3fx8<S>, mask32x8<S>) {
        let simd = wo.x.token();
        vectorized!(simd, {
            let all = mask32x8::splat(simd, true);
            let fibers = Fibers::new(self, wo);
            // The last event, unless an earlier one is chosen.
            let (mut open, mut rest) = (all, u);
            let last = EVENTS - 1;
            let ([mut sin_o, mut cos_o], mut variance) = (fibers.tilted[last], fibers.variance[last]);
            let (mut share, mut azimuth) = (fibers.share[last], splat_f32(simd, 0.0));
            for event in 0..last {
                let own = open & rest.simd_lt(fibers.share[event]);
                let [sin, cos] = fibers.tilted[event];
                (sin_o, cos_o) = (own.select(sin, sin_o), own.select(cos, cos_o));
                variance = own.select(fibers.variance[event], variance);
                azimuth = own.select(fibers.azimuth[event], azimuth);
                share = own.select(fibers.share[event], share);
                open &= !own;
                rest = open.select(rest - fibers.share[event], rest);
            }
            let rest = (rest / share).max(0.0).min(BELOW_ONE);

            // Along the fiber: from 1 - cos, as the cosine is near 1.
            let fine = fine.max(1e-7);
            let below = variance * -ln(fine + (1.0 - fine) * exp_minus(2.0 / variance));
            let below = below.max(0.0).min(2.0);
            let (cos, sin) = (1.0 - below, (below * (2.0 - below)).sqrt());
            let sin_i = (sin * at_turn(v)[0] * cos_o - cos * sin_o).max(-1.0).min(1.0);
            let [sin_i, cos_i] = sin_cos(sin_i);

            // Around it.
            let (before, range) = fibers.logistic_range();
            let logistic = -fibers.scale * ln((1.0 / (rest * range + before) - 1.0).max(0.0));
            let turned = open.select(rest * TAU, azimuth + logistic.max(-PI).min(PI)) * (1.0 / TAU);
            let [cos, sin] = at_turn(turned - turned.floor());
            let inverse = 1.0 / (wo.y * wo.y + wo.z * wo.z).sqrt();
            let is_across = inverse.is_finite();
            let y = is_across.select(wo.y * inverse, splat_f32(simd, 1.0));
            let z = is_across.select(wo.z * inverse, splat_f32(simd, 0.0));
            (V3 { x: sin_i, y: cos_i * (y * cos - z * sin), z: cos_i * (y * sin + z * cos) }, all)
        })
    }

    /// What hair scatters of light from across it.
    #[inline(always)]
    pub fn hair_albedo(&self) -> Vec3fx8<S> {
        let [a, b, c, d] = Fibers::new(self, Vec3fx8::splat(self.eta.token(), Vec3::Z)).attenuation;
        self.color * (a + b + c + d)
    }
}

/// The variance along a fiber, by its roughness from 0 to 1.
#[inline(always)]
pub(super) fn variance<S: Simd>(beta_m: f32x8<S>) -> f32x8<S> {
    let beta = beta_m.max(LEAST_ROUGHNESS);
    let root = 0.726 * beta + 0.812 * beta * beta + 3.7 * power_20(beta);
    root * root
}

/// The scale of the logistic distribution around a fiber, by its roughness from 0 to 1.
#[inline(always)]
pub(super) fn logistic_scale<S: Simd>(beta_n: f32x8<S>) -> f32x8<S> {
    /// The root of pi / 8.
    const ROOT: f32 = 0.626_657_07;
    let beta = beta_n.max(LEAST_ROUGHNESS);
    let squared = beta * beta;
    ROOT * (0.265 * beta + 1.194 * squared + 5.372 * power_20(beta) * squared)
}

/// pbrt-v3 aborts at a roughness of 0.
const LEAST_ROUGHNESS: f32 = 0.002;
/// The least cosine and the like that something is divided by.
const LEAST: f32 = 1e-6;

#[inline(always)]
fn power_20<S: Simd>(x: f32x8<S>) -> f32x8<S> {
    let x4 = x * x * x * x;
    let x16 = x4 * x4 * x4 * x4;
    x16 * x4
}

/// The absorption coefficient that gives a mass of hair a color, for a roughness around the fiber (Chiang et al., equation 9).
#[inline(always)]
pub(super) fn absorption<S: Simd>(color: Vec3fx8<S>, beta_n: f32x8<S>) -> Vec3fx8<S> {
    let mut divisor = beta_n * 0.245;
    for factor in [5.574, -10.73, 2.532, -0.215] {
        divisor = (divisor + factor) * beta_n;
    }
    let divisor = divisor + 5.969;
    V3 { x: absorbed(color.x, divisor), y: absorbed(color.y, divisor), z: absorbed(color.z, divisor) }
}

/// By how much light an event is chosen.
#[inline(always)]
fn amount<S: Simd>(color: Vec3fx8<S>) -> f32x8<S> {
    color.x * LUMINANCE.x as f32 + color.y * LUMINANCE.y as f32 + color.z * LUMINANCE.z as f32
}

/// The absorption of a channel (Chiang et al. 2016, equation 9).
#[inline(always)]
fn absorbed<S: Simd>(channel: f32x8<S>, divisor: f32x8<S>) -> f32x8<S> {
    let root = ln(channel.max(f32::MIN_POSITIVE)) / divisor;
    root * root
}

/// 1 - `x`, more than 0.
#[inline(always)]
fn left<S: Simd>(x: f32x8<S>) -> f32x8<S> {
    (1.0 - x).max(LEAST)
}

/// A sine within its range, and the cosine.
#[inline(always)]
fn sin_cos<S: Simd>(sin: f32x8<S>) -> [f32x8<S>; 2] {
    let sin = sin.max(-1.0).min(1.0);
    [sin, (1.0 - sin * sin).sqrt()]
}

/// The angle of a point.
#[inline(always)]
fn azimuth<S: Simd>(y: f32x8<S>, x: f32x8<S>) -> f32x8<S> {
    to_f32(angle(to_f64(y), to_f64(x)))
}

/// The modified Bessel function of order 0 over the exponential function, of numbers of 0 or more (Abramowitz and Stegun, 9.8.1
/// and 9.8.2), to 2e-7.
#[inline(always)]
fn bessel<S: Simd>(x: f32x8<S>) -> f32x8<S> {
    const NEAR: [f32; 6] = [0.004_581_3, 0.036_076_8, 0.265_973_2, 1.206_749_2, 3.089_942_4, 3.515_622_9];
    const FAR: [f32; 8] = [
        0.003_923_77,
        -0.016_476_33,
        0.026_355_37,
        -0.020_577_06,
        0.009_162_81,
        -0.001_575_65,
        0.002_253_19,
        0.013_285_92,
    ];
    const SPLIT: f32 = 3.75;
    let t = x * (1.0 / SPLIT);
    let (square, inverse) = (t * t, 1.0 / t.max(1.0));
    let (mut near, mut far) = (splat_f32(x.token(), 0.0), splat_f32(x.token(), 0.0));
    for factor in NEAR {
        near = (near + factor) * square;
    }
    for factor in FAR {
        far = (far + factor) * inverse;
    }
    let far = (far + 0.398_942_3) / x.max(SPLIT).sqrt();
    t.simd_lt(1.0).select((near + 1.0) * exp_minus(x.min(SPLIT)), far)
}
