//! Intersects eight rays with a triangle.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::DVec3;

use super::{Axis, DOUBT, Extent, ShearedRay, Triangle};
use crate::bvh::BoxRays;
use crate::number::{LANES, Vec3x8, three};
use crate::ray::Ray;

/// A triangle for each of eight rays.
pub(crate) trait TrianglePerRay<S: Simd> {
    /// The corners, in a permutation of the axes.
    fn turned(&self, simd: S, turn: &Turn<S>) -> [Vec3x8<S>; 3];

    /// The corners of [`Extent`], and its size.
    fn extent(&self, simd: S) -> ([Vec3x8<S>; 2], f64x8<S>);

    /// The triangle of one ray.
    fn of_lane(&self, lane: usize) -> [DVec3; 3];
}

/// The same triangle for all rays, with the box that its hits lie in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoxedTriangle<'s> {
    pub triangle: &'s Triangle,
    extent: Extent,
}

impl<'s> BoxedTriangle<'s> {
    pub fn new(triangle: &'s Triangle) -> Self {
        BoxedTriangle { triangle, extent: Extent::new(&triangle.corners) }
    }
}

impl<S: Simd> TrianglePerRay<S> for BoxedTriangle<'_> {
    #[inline(always)]
    fn turned(&self, simd: S, turn: &Turn<S>) -> [Vec3x8<S>; 3] {
        three!(at, turn.turned_point(simd, &self.triangle.corners[at]))
    }

    #[inline(always)]
    fn extent(&self, simd: S) -> ([Vec3x8<S>; 2], f64x8<S>) {
        let Extent { low, high, size } = self.extent;
        ([Vec3x8::splat(simd, low), Vec3x8::splat(simd, high)], size.simd_into(simd))
    }

    fn of_lane(&self, _: usize) -> [DVec3; 3] {
        self.triangle.corners
    }
}

/// A different triangle for each ray.
impl<S: Simd> TrianglePerRay<S> for [Vec3x8<S>; 3] {
    #[inline(always)]
    fn turned(&self, _: S, turn: &Turn<S>) -> [Vec3x8<S>; 3] {
        three!(at, turn.turned(self[at]))
    }

    #[inline(always)]
    fn extent(&self, _: S) -> ([Vec3x8<S>; 2], f64x8<S>) {
        let [p, q, r] = self;
        let low = p.min(*q).min(*r);
        let high = p.max(*q).max(*r);
        let sides = high - low;
        let size = sides.x.max(sides.y).max(sides.z);
        let rounding = size * (4.0 * f64::EPSILON);
        let rounding = Vec3x8 { x: rounding, y: rounding, z: rounding };
        ([low - rounding, high + rounding], size)
    }

    fn of_lane(&self, lane: usize) -> [DVec3; 3] {
        self.map(|corner| corner.lane(lane))
    }
}

/// Eight rays, prepared like [`ShearedRay`].
#[derive(Clone, Copy)]
pub(crate) struct ShearedRays<S: Simd> {
    o: Vec3x8<S>,
    d: Vec3x8<S>,
    turned: Vec3x8<S>,
    shear: Vec3x8<S>,
    boxed: BoxRays<S>,
    turn: Turn<S>,
}

/// The permutation of axes of each ray: see [`Axis::longest_last`].
#[derive(Clone, Copy)]
pub(crate) enum Turn<S: Simd> {
    /// All in one way.
    Alike([Axis; 3]),
    /// The rays whose longest axis is not x, and those whose z is longer than y.
    Mixed { is_not_x: mask64x8<S>, is_not_y: mask64x8<S> },
}

impl<S: Simd> Turn<S> {
    #[inline(always)]
    fn new(d: Vec3x8<S>, active: mask64x8<S>) -> Self {
        let [x, y, z] = [d.x.abs(), d.y.abs(), d.z.abs()];
        let (is_not_x, is_not_y) = (x.simd_lt(y) | x.simd_lt(z), y.simd_lt(z));
        let bits = active.to_bitmask();
        let Some(lane) = (bits != 0).then(|| bits.trailing_zeros() as usize) else {
            return Turn::Alike([Axis::X, Axis::Y, Axis::Z]);
        };
        let (not_x, not_y) = (is_not_x.to_bitmask(), is_not_y.to_bitmask());
        let is_alike = |mask: u64| mask & bits == 0 || mask & bits == bits;
        if is_alike(not_x) && (not_x & bits == 0 || is_alike(not_y)) {
            return Turn::Alike(Axis::longest_last(d.lane(lane)));
        }
        Turn::Mixed { is_not_x, is_not_y }
    }

    #[inline(always)]
    fn turned(&self, v: Vec3x8<S>) -> Vec3x8<S> {
        match self {
            Turn::Alike(axes) => {
                let (all, [x, y, z]) = ([v.x, v.y, v.z], axes);
                Vec3x8 { x: x.of(&all), y: y.of(&all), z: z.of(&all) }
            }
            Turn::Mixed { is_not_x, is_not_y } => Vec3x8 {
                x: is_not_x.select(is_not_y.select(v.x, v.z), v.y),
                y: is_not_x.select(is_not_y.select(v.y, v.x), v.z),
                z: is_not_x.select(is_not_y.select(v.z, v.y), v.x),
            },
        }
    }

    #[inline(always)]
    fn turned_point(&self, simd: S, p: &DVec3) -> Vec3x8<S> {
        match self {
            Turn::Alike(axes) => {
                let (p, [x, y, z]) = (p.as_ref(), axes);
                Vec3x8::splat(simd, DVec3::new(x.of(p), y.of(p), z.of(p)))
            }
            Turn::Mixed { .. } => self.turned(Vec3x8::splat(simd, *p)),
        }
    }
}

impl<S: Simd> ShearedRays<S> {
    #[inline(always)]
    pub fn new(o: Vec3x8<S>, d: Vec3x8<S>, active: mask64x8<S>) -> Self {
        let turn = Turn::new(d, active);
        let Vec3x8 { x, y, z } = turn.turned(d);
        ShearedRays {
            o,
            d,
            turned: turn.turned(o),
            shear: Vec3x8 { x: x / z, y: y / z, z: 1.0 / z },
            boxed: BoxRays::new(o, d),
            turn,
        }
    }

    /// The rays that hit their triangles, the distances, and the unnormalized weights of the corners, with the bits of
    /// [`ShearedRay::intersect`].
    #[inline(always)]
    pub fn intersect(
        &self,
        simd: S,
        triangle: &impl TrianglePerRay<S>,
        active: mask64x8<S>,
    ) -> (mask64x8<S>, f64x8<S>, [f64x8<S>; 3]) {
        let [a, b, c] = triangle.turned(simd, &self.turn);
        let (a, b, c) = (self.sheared(a), self.sheared(b), self.sheared(c));
        let u = c.x * b.y - c.y * b.x;
        let v = a.x * c.y - a.y * c.x;
        let w = b.x * a.y - b.y * a.x;
        let zero = (u.simd_eq(0.0) | v.simd_eq(0.0) | w.simd_eq(0.0)) & active;
        if zero.any_true() {
            return self.one_by_one(simd, triangle, active);
        }
        let below = u.simd_lt(0.0) | v.simd_lt(0.0) | w.simd_lt(0.0);
        let above = u.simd_gt(0.0) | v.simd_gt(0.0) | w.simd_gt(0.0);
        let mut met = active & !(below & above);
        if !met.any_true() {
            return (met, u, [u, v, w]);
        }
        let (corners, size) = triangle.extent(simd);
        let det = u + v + w;
        let volume = u * a.z + v * b.z + w * c.z;
        let depth = a.z.abs().max(b.z.abs()).max(c.z.abs()) + size;
        let doubtful = met & volume.abs().simd_le(depth * depth * (size * DOUBT));
        if doubtful.any_true() {
            return self.one_by_one(simd, triangle, active);
        }
        let t = volume * self.shear.z / det;
        met &= det.simd_ne(0.0) & t.simd_gt(0.0);
        let (near, far) = self.boxed.ends(simd, corners);
        met &= near.simd_le(far);
        let t = t.simd_lt(near).select(near, t);
        let t = t.simd_gt(far).select(far, t);
        (met & t.simd_gt(0.0), t, [u, v, w])
    }

    #[inline(always)]
    fn sheared(&self, turned: Vec3x8<S>) -> Vec3x8<S> {
        let p = turned - self.turned;
        Vec3x8 { x: p.x - self.shear.x * p.z, y: p.y - self.shear.y * p.z, z: p.z }
    }

    /// Intersects one ray after the other. For rays that pass exactly at an edge or start in the plane.
    #[cold]
    #[inline(never)]
    fn one_by_one(
        &self,
        simd: S,
        triangle: &impl TrianglePerRay<S>,
        active: mask64x8<S>,
    ) -> (mask64x8<S>, f64x8<S>, [f64x8<S>; 3]) {
        let zero: f64x8<S> = 0.0.simd_into(simd);
        let (mut met, mut t, mut sides) = (0, zero, [zero; 3]);
        for lane in 0..LANES {
            let ray = Ray::new(self.o.lane(lane), self.d.lane(lane));
            let is_active = active.to_bitmask() >> lane & 1 == 1;
            if let Some(hit) = ShearedRay::new(&ray).intersect(&triangle.of_lane(lane)).filter(|_| is_active)
            {
                met |= 1 << lane;
                t[lane] = hit.0;
                for (side, found) in sides.iter_mut().zip(hit.1) {
                    side[lane] = found;
                }
            }
        }
        (mask64x8::from_bitmask(simd, met), t, sides)
    }
}

impl Triangle {
    /// The weights of its vertices, as the mesh has them, from what is in proportion to those of its corners.
    #[inline(always)]
    pub fn weights<S: Simd>(&self, sides: [f64x8<S>; 3]) -> [f64x8<S>; 3] {
        let sum = sides[0] + sides[1] + sides[2];
        let [first, second] = self.first.map(usize::from);
        let (b0, b1) = (sides[first] / sum, sides[second] / sum);
        [b0, b1, 1.0 - b0 - b1]
    }
}
