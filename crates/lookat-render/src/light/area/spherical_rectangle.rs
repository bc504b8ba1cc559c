//! Rectangles, sampled by the solid angle at which points see them (Ureña, Fajardo and King 2013; PBR 4th ed. 6.5.4).

use std::f64::consts::TAU;

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::DVec3;

use super::spherical_triangle::{NEAR, is_in_range};
use crate::frame::flipped;
use crate::number::{Vec2x8, Vec3x8};
use crate::surface::{ShapePoint, ShapePoints, Surfaces};
use crate::warp::{angle, at_turn};

/// A rectangle of two triangles.
pub(super) struct Rectangle {
    /// The corner where only the first triangle is.
    corner: DVec3,
    /// Along the shorter side and the longer one, of length one.
    axes: [DVec3; 2],
    lengths: [f64; 2],
    /// The normal on the side that emits.
    n: DVec3,
    /// The largest coordinate of the corners.
    magnitude: f64,
}

/// Corners may be off by this share of the sides.
const ROUNDING: f64 = 1e-6;

/// A rectangle as points see it: in the coordinates of its sides, the points at the origin.
pub(super) struct SphericalRectangles<S: Simd> {
    x: [f64x8<S>; 2],
    y: [f64x8<S>; 2],
    squared_height: f64x8<S>,
    /// The cosine and sine of the solid angle from the longitude of the origin, around the longer axis, to the first side.
    start: [f64x8<S>; 2],
    /// The cosines of the difference and of the sum of the latitudes of the shorter sides.
    latitudes: [f64x8<S>; 2],
    pub solid_angle: f64x8<S>,
    /// The points that sample the rectangle by solid angle. Points in its plane sample no light.
    pub is_in_range: mask64x8<S>,
}

impl Rectangle {
    /// The rectangle that two triangles are, if they are one; `emitting`: about its normal.
    pub fn new([first, second]: [[DVec3; 3]; 2], emitting: DVec3) -> Option<Self> {
        let is_alone = |corner: &usize| !second.contains(&first[*corner]);
        let at = (0..3).find(is_alone)?;
        let (corner, ends) = (first[at], [first[(at + 1) % 3], first[(at + 2) % 3]]);
        let opposite = second.into_iter().find(|corner| !first.contains(corner))?;
        let mut sides = ends.map(|end| end - corner);
        let are_shared = ends.iter().all(|end| second.contains(end));
        if sides[0].length_squared() > sides[1].length_squared() {
            sides.reverse();
        }
        let lengths = sides.map(DVec3::length);
        let axes = [sides[0] / lengths[0], sides[1] / lengths[1]];
        let is_right = axes[0].dot(axes[1]).abs() <= ROUNDING
            && (corner + sides[0] + sides[1] - opposite).length() <= ROUNDING * lengths[0];
        let n = axes[0].cross(axes[1]).normalize_or_zero();
        // Exactly perpendicular, as coordinate axes are.
        let axes = [axes[1].cross(n), axes[1]];
        let n = flipped(n, n.dot(emitting) < 0.0);
        let magnitude = first.iter().chain(&second).map(|p| p.abs().max_element()).fold(0.0, f64::max);
        (are_shared && is_right && emitting != DVec3::ZERO).then_some(Rectangle {
            corner,
            axes,
            lengths,
            n,
            magnitude,
        })
    }

    /// The points at shares of its sides, and the number of the triangle that each lies in.
    #[inline(always)]
    pub fn points<S: Simd>(&self, simd: S, [s, t]: Vec2x8<S>) -> (ShapePoints<S>, f64x8<S>) {
        let ([x, y], [width, height]) = (self.axes, self.lengths);
        let (x, y) = (Vec3x8::splat(simd, x * width), Vec3x8::splat(simd, y * height));
        let p = Vec3x8::splat(simd, self.corner) + x * s + y * t;
        let n = Vec3x8::splat(simd, self.n);
        let is_second = (s + t).simd_gt(1.0);
        let index = is_second.select(1.0.simd_into(simd), 0.0.simd_into(simd));
        (ShapePoint { p, magnitude: self.magnitude.simd_into(simd), n, ns: n, emitting: n }, index)
    }

    /// The rectangle as seen from points.
    #[inline(always)]
    pub fn seen_from<S: Simd>(&self, simd: S, at: &Surfaces<S>) -> SphericalRectangles<S> {
        let to = Vec3x8::splat(simd, self.corner) - at.p;
        let [x_axis, y_axis] = self.axes;
        let (x0, y0) = (to.dot(Vec3x8::splat(simd, x_axis)), to.dot(Vec3x8::splat(simd, y_axis)));
        let (x1, y1) = (x0 + self.lengths[0], y0 + self.lengths[1]);
        let h = to.dot(Vec3x8::splat(simd, self.n)).abs();
        let (xx0, xx1, yy0, yy1, hh) = (x0 * x0, x1 * x1, y0 * y0, y1 * y1, h * h);
        let (to00, to01) = ((xx0 + yy0 + hh).sqrt(), (xx0 + yy1 + hh).sqrt());
        let (to10, to11) = ((xx1 + yy0 + hh).sqrt(), (xx1 + yy1 + hh).sqrt());
        let product = y0 * y1;
        // Of the solid angle from the origin's longitude to each, times the same factor.
        let (c0, s0) = (hh * to00 * to01 + xx0 * product, h * x0 * (y1 * to00 - y0 * to01));
        let (c1, s1) = (hh * to10 * to11 + xx1 * product, h * x1 * (y1 * to10 - y0 * to11));
        let (sine, cosine) = (s1 * c0 - c1 * s0, c1 * c0 + s1 * s0);
        let turn = angle(sine, cosine);
        let solid_angle = turn.simd_lt(0.0).select(turn + TAU, turn);
        let (across, along) = (hh + xx0, ((hh + yy0) * (hh + yy1)).sqrt());
        let inverse = 1.0 / (across * along);
        let share = across * inverse;
        let [width, height] = self.lengths;
        let is_near = to.length_squared().simd_lt((width * width + height * height) * NEAR);
        let is_above = h.simd_gt(at.rounding(self.magnitude.simd_into(simd)));
        let is_finite = inverse.is_finite() & sine.is_finite() & cosine.is_finite();
        SphericalRectangles {
            x: [x0, x1],
            y: [y0, y1],
            squared_height: hh,
            start: [c0 * inverse, s0 * inverse],
            latitudes: [(hh + product) * share, (hh - product) * share],
            solid_angle,
            is_in_range: is_near & is_above & is_finite & is_in_range(solid_angle),
        }
    }
}

impl<S: Simd> SphericalRectangles<S> {
    /// Shares of the sides, whose points have a density of one over the solid angle.
    #[inline(always)]
    pub fn sample(&self, [u, v]: Vec2x8<S>) -> Vec2x8<S> {
        let ([x0, x1], [y0, y1], hh) = (self.x, self.y, self.squared_height);
        let [cos, sin] = at_turn(u * self.solid_angle * (1.0 / TAU));
        let [c0, s0] = self.start;
        let (cos, sin) = (c0 * cos - s0 * sin, s0 * cos + c0 * sin);
        let [difference, sum] = self.latitudes;
        let squared = ((cos - difference) * (cos + sum)).max(f64::MIN_POSITIVE);
        let x = ((hh / squared).sqrt() * sin).max(x0).min(x1);
        // Of the segment there, seen as an arc of latitudes whose sines are alike.
        let across = x * x + hh;
        let [to0, to1] = [(across + y0 * y0).sqrt(), (across + y1 * y1).sqrt()];
        let sine = y0 * to1 * (1.0 - v) + y1 * to0 * v;
        let length = to0 * to1;
        let cosine = ((length - sine) * (length + sine)).max(f64::MIN_POSITIVE);
        let y = ((across / cosine).sqrt() * sine).max(y0).min(y1);
        [(x - x0) / (x1 - x0), (y - y0) / (y1 - y0)]
    }
}
