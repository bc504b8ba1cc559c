//! Triangles, sampled by the solid angle at which points see them (Arvo 1995; PBR 4th ed. 6.5.4).

use std::f64::consts::TAU;

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};

use crate::number::{Vec2x8, Vec3x8};
use crate::surface::Surfaces;
use crate::warp::{angle, at_turn};

/// Solid angles, in steradians, that are sampled as such. Of smaller ones too few digits are left, and of larger ones of what lies beside.
const RANGE: [f64; 2] = [1e-5, 6.2];
/// The most squared sizes that a squared distance may be to sample the solid angle. From farther away, points of equal areas are as good,
/// and faster.
pub(super) const NEAR: f64 = 64.0;

/// True where a solid angle is to be sampled as such.
#[inline(always)]
pub(super) fn is_in_range<S: Simd>(solid_angle: f64x8<S>) -> mask64x8<S> {
    let [least, most] = RANGE;
    solid_angle.simd_ge(least) & solid_angle.simd_le(most)
}

/// Triangles as points see them, one for each.
pub(super) struct SphericalTriangles<S: Simd> {
    /// One over the distances of the corners a, b and c.
    inverse: [f64x8<S>; 3],
    /// The cosines of the sides: between b and c, c and a, a and b.
    sides: [f64x8<S>; 3],
    /// The determinant of the directions of the corners.
    determinant: f64x8<S>,
    pub area: f64x8<S>,
    pub solid_angle: f64x8<S>,
    /// The points that sample the triangles by solid angle. Points in the planes sample no light.
    pub is_in_range: mask64x8<S>,
}

impl<S: Simd> SphericalTriangles<S> {
    #[inline(always)]
    pub fn new(at: &Surfaces<S>, [a, b, c]: [Vec3x8<S>; 3]) -> Self {
        let rounding = at.rounding(a.magnitude().max(b.magnitude()).max(c.magnitude()));
        let (e, f) = (b - a, c - a);
        let across = e.cross(f);
        let double_area = across.length_squared().sqrt();
        let (a, b, c) = (a - at.p, b - at.p, c - at.p);
        let volume = a.dot(across).abs();
        let squared = a.length_squared();
        let is_near = squared.simd_lt(e.length_squared().max(f.length_squared()) * NEAR);
        let (ia, ib) = (1.0 / squared.sqrt(), 1.0 / b.length_squared().sqrt());
        let ic = 1.0 / c.length_squared().sqrt();
        let determinant = volume * ia * ib * ic;
        let (ca, cb, cc) = (b.dot(c) * (ib * ic), c.dot(a) * (ic * ia), a.dot(b) * (ia * ib));
        let cosine = 1.0 + ca + cb + cc;
        let solid_angle = angle(determinant, cosine) * 2.0;
        let is_above = volume.simd_gt(rounding * double_area);
        let is_finite = determinant.is_finite() & cosine.is_finite();
        SphericalTriangles {
            inverse: [ia, ib, ic],
            sides: [ca, cb, cc],
            determinant,
            area: double_area * 0.5,
            solid_angle,
            is_in_range: is_near & is_above & is_finite & is_in_range(solid_angle),
        }
    }

    /// Samples barycentric coordinates of points, with a density of one over the solid angle.
    #[inline(always)]
    pub fn sample(&self, [u, v]: Vec2x8<S>) -> [f64x8<S>; 3] {
        let ([ia, ib, ic], [ca, cb, cc]) = (self.inverse, self.sides);
        let none: f64x8<S> = 0.0.simd_into(u.token());
        // A point on the side from a to c, up to which there is a share `u`: the tangent of half its angle, over the sine of the side.
        let [cos, sin] = at_turn(u * self.solid_angle * (0.5 / TAU));
        let tangent = sin * (1.0 + cc) / (self.determinant * cos - (ca - cb * cc) * sin);
        let squared = tangent * tangent * (1.0 - cb * cb);
        let inverse = 1.0 / (1.0 + squared);
        let at_c = 2.0 * tangent * inverse;
        let at_a = (1.0 - squared) * inverse - at_c * cb;
        // From b to there, all heights over b alike.
        let most = 1.0 - (at_a * cc + at_c * ca);
        let height = v * most;
        let along = (v * (2.0 - height) / (2.0 - most)).max(0.0).sqrt();
        let at_b = 1.0 - height - (1.0 - most) * along;
        // The same point of the plane.
        let (a, b) = ((at_a * along * ia).max(none), (at_b * ib).max(none));
        let c = (at_c * along * ic).max(none);
        let inverse = 1.0 / (a + b + c);
        [a * inverse, b * inverse, c * inverse]
    }
}
