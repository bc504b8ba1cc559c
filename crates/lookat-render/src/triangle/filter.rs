//! Which triangles a ray may meet, in `f32`, before `f64` decides.

use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};

use super::Axis;
use super::block::{Block, Tolerance, UNIT};
use crate::number::{splat_f32, three};

/// Rays turned to run along z, as [`super::ShearedRay`]: one in all lanes, or eight of them side by side.
///
/// It tells what rays certainly miss, with any instructions: a corner is moved by less than 12 [`UNIT`]s of the coordinates that
/// it is computed from.
#[derive(Clone, Copy)]
pub(crate) struct Filter<S: Simd> {
    /// The longest of the direction last.
    pub axes: [Axis; 3],
    pub rays: Turned<S>,
    /// What the rounding of the rays does to corners.
    pub error: f32,
}

/// Rays along three axes.
#[derive(Clone, Copy)]
pub(crate) struct Turned<S: Simd> {
    /// How far they go along each of the first two axes while they go minus one along the last.
    shear: [f32x8<S>; 2],
    /// Where they pass zero along the last axis.
    offset: [f32x8<S>; 2],
    /// The origin along the last axis.
    start: f32x8<S>,
    /// The direction along it.
    along: f32x8<S>,
}

/// A triangle as a ray passes it.
pub(crate) struct Sides<S: Simd> {
    corners: [[f32x8<S>; 2]; 3],
    /// On which sides of its edges: in proportion to the areas between these and the ray.
    least: f32x8<S>,
    greatest: f32x8<S>,
}

impl<S: Simd> Turned<S> {
    /// Of origins and directions that have been rounded once.
    #[inline(always)]
    pub fn new(o: [f32x8<S>; 3], d: [f32x8<S>; 3]) -> Self {
        let inverse = -1.0 / d[2];
        let shear = [d[0] * inverse, d[1] * inverse];
        let offset = [shear[0].mul_add(o[2], o[0]), shear[1].mul_add(o[2], o[1])];
        Turned { shear, offset, start: o[2], along: d[2] }
    }

    /// One of the rays, in all lanes.
    #[inline(always)]
    pub fn one(&self, simd: S, lane: usize) -> Self {
        Turned {
            shear: [splat_f32(simd, self.shear[0][lane]), splat_f32(simd, self.shear[1][lane])],
            offset: [splat_f32(simd, self.offset[0][lane]), splat_f32(simd, self.offset[1][lane])],
            start: splat_f32(simd, self.start[lane]),
            along: splat_f32(simd, self.along[lane]),
        }
    }
}

impl<S: Simd> Filter<S> {
    /// Of rays along these axes, and the largest of their coordinates.
    #[inline(always)]
    pub fn new(axes: [Axis; 3], rays: Turned<S>, magnitude: f32) -> Self {
        Filter { axes, rays, error: 12.0 * UNIT * magnitude }
    }

    /// The size of the direction along the last axis.
    #[inline(always)]
    pub fn length(&self) -> f32x8<S> {
        self.rays.along.abs()
    }

    /// A triangle whose corners these are, along each axis.
    #[inline(always)]
    pub fn sides(&self, corner: impl Fn(usize, Axis) -> f32x8<S>) -> Sides<S> {
        let ([x, y, z], Turned { shear, offset, .. }) = (self.axes, &self.rays);
        let [a, b, c] = three!(at, {
            let z = corner(at, z);
            let (x, y) = (shear[0].mul_add(z, corner(at, x)), shear[1].mul_add(z, corner(at, y)));
            [x - offset[0], y - offset[1]]
        });
        let (u, v, w) = (cross(c, b), cross(a, c), cross(b, a));
        Sides { corners: [a, b, c], least: u.min(v).min(w), greatest: u.max(v).max(w) }
    }

    /// Between which distances along the last axis a triangle is.
    #[inline(always)]
    pub fn depths(&self, corner: impl Fn(usize, Axis) -> f32x8<S>) -> [f32x8<S>; 2] {
        let sign = splat_f32(self.rays.along.token(), 1.0).copysign(self.rays.along);
        let [a, b, c] = three!(at, (corner(at, self.axes[2]) - self.rays.start) * sign);
        [a.min(b).min(c), a.max(b).max(c)]
    }

    /// Which triangles of a block one ray, in all lanes, may meet before `t_max`, as bits; and some of those that it certainly
    /// meets. None of those that are `left_out`.
    #[inline(always)]
    pub fn meet(&self, simd: S, block: &Block, t_max: f64, left_out: u32) -> (u32, u32) {
        let corner = |at: usize, axis: Axis| f32x8::from_slice(simd, &block.corners[at][axis as usize]);
        let (tolerance, sides) = (block.tolerance(self.error), self.sides(corner));
        let may = !sides.pass(&tolerance).to_bitmask() as u32 & block.mask & !left_out;
        if may == 0 {
            return (0, 0);
        }
        // A product in f32 may overflow to infinity, which is a limit too.
        let end = (t_max * f64::from(self.length()[0])) as f32;
        let [front, back] = self.depths(corner);
        let farthest = end * (1.0 + 4.0 * UNIT) + tolerance.error;
        let is_out = front.simd_gt(farthest) | back.simd_lt(-tolerance.error);
        let may = may & !is_out.to_bitmask() as u32;
        if may == 0 {
            return (0, 0);
        }
        let is_between =
            front.simd_gt(tolerance.error) & back.simd_lt(end * (1.0 - 4.0 * UNIT) - 2.0 * tolerance.error);
        (may, may & (is_between & sides.are_one(&tolerance)).to_bitmask() as u32)
    }
}

impl<S: Simd> Sides<S> {
    /// Where the ray certainly passes one edge on the one side, and another edge on the other.
    #[inline(always)]
    pub fn pass(&self, tolerance: &Tolerance) -> mask32x8<S> {
        self.least.simd_lt(-tolerance.side) & self.greatest.simd_gt(tolerance.side)
    }

    /// Where it certainly passes all edges on the same side.
    #[inline(always)]
    fn are_one(&self, tolerance: &Tolerance) -> mask32x8<S> {
        let is_one_side = self.least.simd_gt(tolerance.side) | self.greatest.simd_lt(-tolerance.side);
        let [a, b, c] = three!(at, self.corners[at][0].abs().max(self.corners[at][1].abs()));
        // The tolerance holds near the ray.
        is_one_side & a.max(b).max(c).simd_le(tolerance.size)
    }
}

#[inline(always)]
fn cross<S: Simd>(p: [f32x8<S>; 2], q: [f32x8<S>; 2]) -> f32x8<S> {
    p[0].mul_sub(q[1], p[1] * q[0])
}

#[cfg(test)]
mod tests;
