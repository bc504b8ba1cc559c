//! Directions that light comes from, but that BSDF samples miss.

use std::f64::consts::TAU;

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};

use crate::bsdf::Domain;
use crate::frame::Frames;
use crate::number::{Number, Vec3x8, narrow, splat_f32, to_f32, widen};
use crate::warp::{angle, at_turn};

/// Directions between two planes: above the surface, but on the other side of the shading normal than `wo`. Where light
/// comes through the surface, also those opposite to them.
///
/// pbrt-v3 counts light from there, by the absolute cosine to the shading normal, and does not sample it by the BSDF.
///
/// In `f64`, as few digits of the normals are left between them.
#[derive(Clone, Copy)]
pub(crate) struct Lunes<S: Simd> {
    /// The points with a lune: their normals differ by more than rounding.
    pub is_valid: mask64x8<S>,
    n: Vec3x8<S>,
    ns: Vec3x8<S>,
    /// The edge of the lune, of length one: across both normals.
    axis: Vec3x8<S>,
    /// Between the normals, more than 0 and up to pi.
    angle: f64x8<S>,
    /// With the opposite lune.
    is_double: mask64x8<S>,
}

/// The sine of the least angle between normals that counts: below it, less than 1e-12 of the light is left out, and
/// rounding would decide what lies inside.
const LEAST: f64 = 1e-6;

impl<S: Simd> Lunes<S> {
    /// The lunes at some points. `None` if no active point has one.
    #[inline(always)]
    pub fn new(&Domain { n, ns, is_two_sided, .. }: &Domain<S>, active: mask64x8<S>) -> Option<Self> {
        let [n, ns] = [n.widen(), ns.widen()];
        let (across, cos) = (n.cross(ns), n.dot(ns));
        let sin = across.length_squared().sqrt();
        let is_wide = sin.simd_gt(LEAST);
        let is_valid = active & (is_wide | !cos.simd_gt(0.0));
        if !is_valid.any_true() {
            return None;
        }
        let [n, ns] = [n.normalize(), ns.normalize()];
        // Any axis, as the lune is a hemisphere.
        let axis = (across * (1.0 / sin)).keep_where(is_wide, Frames::from_z(n).x);
        Some(Lunes { is_valid, n, ns, axis, angle: angle(sin, cos), is_double: widen(is_two_sided) })
    }

    /// The irradiance from the lunes under a constant sky, relative to that from a whole hemisphere, weighted by the cosine
    /// to the shading normal. For two lunes: the sum. 0 without a lune.
    #[inline(always)]
    pub fn share(&self) -> f64x8<S> {
        let [_, sine] = at_turn(self.angle * (0.5 / TAU));
        let none = 0.0.simd_into(sine.token());
        self.is_valid.select(sine * sine * self.count(), none)
    }

    /// The number of lunes: two if the opposite one counts.
    #[inline(always)]
    fn count(&self) -> f64x8<S> {
        let simd = self.angle.token();
        self.is_double.select(f64x8::of(simd, 2.0), f64x8::of(simd, 1.0))
    }

    /// Samples directions uniformly in the lunes.
    #[inline(always)]
    pub fn sample(&self, [u, v]: [f64x8<S>; 2]) -> Vec3x8<S> {
        let simd = u.token();
        let z = 2.0 * u - 1.0;
        let is_low = v.simd_lt(0.5);
        let half = 2.0 * v - is_low.select(f64x8::of(simd, 0.0), f64x8::of(simd, 1.0));
        let v = self.is_double.select(half, v);
        let sign = (self.is_double & is_low).select(f64x8::of(simd, -1.0), f64x8::of(simd, 1.0));
        // From the plane of the surface, which is a quarter turn before its normal.
        let [cos, sin] = at_turn(self.angle * v * (1.0 / TAU));
        let around = self.n * sin - self.axis.cross(self.n) * cos;
        (self.axis * z + around * ((1.0 - z) * (1.0 + z)).max(0.0).sqrt()) * sign
    }

    /// Densities of [`Lunes::sample`] by solid angle.
    #[inline(always)]
    pub fn pdf(&self, wi: Vec3x8<S>) -> f32x8<S> {
        let (above, before) = (wi.dot(self.n), wi.dot(self.ns));
        let is_inside = (above * before).simd_lt(0.0) & (self.is_double | above.simd_gt(0.0));
        narrow(self.is_valid & is_inside).select(self.inside_pdf(), splat_f32(above.token(), 0.0))
    }

    /// The densities inside.
    #[inline(always)]
    pub fn inside_pdf(&self) -> f32x8<S> {
        to_f32(1.0 / (2.0 * self.angle * self.count()))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use fearless_simd::mask32x8;
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::number::{Vec3fx8, bits};
    use crate::testing::baseline;

    /// Normals at an angle.
    fn normals(degrees: f64) -> [DVec3; 2] {
        let n = DVec3::new(0.6, 0.0, 0.8);
        [n, glam::DQuat::from_axis_angle(DVec3::new(0.8, 0.0, -0.6), degrees.to_radians()) * n]
    }

    fn lunes<S: Simd>(simd: S, [n, ns]: [DVec3; 2], is_two_sided: bool) -> Option<Lunes<S>> {
        let [n, ns] = [n, ns].map(|n| Vec3fx8::splat(simd, n.as_vec3()));
        let [is_two_sided, is_diffuse] = [is_two_sided, false].map(|all| mask32x8::splat(simd, all));
        Lunes::new(&Domain { n, ns, is_two_sided, is_diffuse }, bits(simd, 0xff))
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
            baseline!(simd => {
                let lunes = lunes(simd, normals(degrees), is_two_sided).unwrap();
                let mut irradiance = 0.0;
                for u in grid(200) {
                    let wi = lunes.sample([u.x.simd_into(simd), u.y.simd_into(simd)]);
                    assert!((wi.lane(0).length() - 1.0).abs() < 1e-12);
                    let inside = f64::from(lunes.inside_pdf()[0]);
                    assert_eq!(f64::from(lunes.pdf(wi)[0]), inside, "{degrees} {}", wi.lane(0));
                    irradiance += wi.lane(0).dot(normals(degrees)[1]).abs() / inside / 40_000.0;
                }
                let share = lunes.share()[0];
                assert!((irradiance / (PI * share) - 1.0).abs() < 1e-3, "{degrees} {irradiance} {share}");
            });
        }
    }

    /// The density is that of the solid angle which satisfies the definition.
    #[test]
    fn the_density_has_an_integral_of_one() {
        for (degrees, is_two_sided) in [(20.0, false), (20.0, true), (100.0, false)] {
            let on_sphere = |u: DVec2| {
                let z = 1.0 - 2.0 * u.y;
                (DVec2::from_angle(2.0 * PI * u.x) * ((1.0 - z) * (1.0 + z)).sqrt()).extend(z)
            };
            let mean = baseline!(simd => {
                let lunes = lunes(simd, normals(degrees), is_two_sided).unwrap();
                grid(1000).map(|u| f64::from(lunes.pdf(Vec3x8::splat(simd, on_sphere(u)))[0])).sum::<f64>() / 1e6
            });
            assert!((mean * 4.0 * PI - 1.0).abs() < 0.01, "{degrees} {mean}");
        }
    }

    #[test]
    fn equal_normals_leave_nothing_out() {
        let is_valid = |normals| baseline!(simd => lunes(simd, normals, false).is_some());
        let [n, same] = normals(0.0);
        assert!(!is_valid([n, same]));
        for tilt in [1e-17, 1e-16, 3e-16, 1e-12, 1e-8] {
            let ns = (n + DVec3::new(0.8, 0.0, -0.6) * tilt).normalize();
            assert!(!is_valid([n, ns]), "{tilt}");
        }
    }
}
