//! Rays against triangles, watertight (Woop, Benthin and Wald 2013). Blocks of eight triangles are tested in `f32` before `f64`
//! decides.

pub(crate) mod sheared;
#[cfg(test)]
mod tests;
pub(crate) mod uv;

use std::cmp::Ordering;

use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use glam::{DVec3, Vec3Swizzles};
use lookat_scene::Mesh;

use crate::bvh::{WIDTH, within_box};
use crate::number::{splat_f32, three};
use crate::ray::{ElementId, Ray};

/// An axis of space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Axis {
    X,
    Y,
    Z,
}

impl Axis {
    /// All in cyclic order, with each of them last.
    pub const ORDERS: [[Axis; 3]; 3] =
        [[Axis::Y, Axis::Z, Axis::X], [Axis::Z, Axis::X, Axis::Y], [Axis::X, Axis::Y, Axis::Z]];

    /// All three, in cyclic order, the longest of a vector last. Without branches: rays come from everywhere.
    #[inline(always)]
    pub fn longest_last(v: DVec3) -> [Axis; 3] {
        let size = v.abs();
        let is_not_x = usize::from((size.x < size.y) | (size.x < size.z));
        let is_not_y = usize::from(size.y < size.z);
        Axis::ORDERS[is_not_x + (is_not_x & is_not_y)]
    }

    #[inline(always)]
    pub fn of<T: Copy>(self, v: &[T; 3]) -> T {
        v[self as usize]
    }
}

/// A triangle of a mesh.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Triangle {
    /// Sorted.
    pub corners: [DVec3; 3],
    pub primitive: u32,
    pub index: u32,
    /// The places of the first two vertices.
    first: [u8; 2],
}

impl Triangle {
    /// Triangle `index` of the mesh that a primitive is, relative to `origin`.
    pub fn new(mesh: &Mesh, index: usize, primitive: u32, origin: DVec3) -> Self {
        let (corners, first) = sorted(corners(mesh, index, origin));
        Triangle { corners, primitive, index: index as u32, first }
    }

    /// A triangle that belongs to nothing.
    #[cfg(test)]
    pub fn of_corners(corners: [DVec3; 3]) -> Self {
        Triangle { corners, primitive: 0, index: 0, first: [0, 1] }
    }

    /// The identity of the triangle in an instance or in the world.
    #[inline(always)]
    pub fn element(&self, instance: u32) -> ElementId {
        ElementId { instance, primitive: self.primitive, index: self.index }
    }

    /// The corners, as the mesh has them.
    #[inline]
    pub fn in_order(&self) -> [DVec3; 3] {
        let [first, second] = self.first.map(usize::from);
        [self.corners[first], self.corners[second], self.corners[3 - first - second]]
    }

    /// The weights of its first two vertices, from what is in proportion to those of its corners.
    #[inline(always)]
    pub fn barycentric(&self, sides: [f64; 3]) -> [f64; 2] {
        let sum = sides[0] + sides[1] + sides[2];
        self.first_two(|corner| sides[corner] / sum)
    }

    /// The value of each of its first two vertices, from those of its corners.
    #[inline(always)]
    pub fn first_two(&self, of_corner: impl Fn(usize) -> f64) -> [f64; 2] {
        self.first.map(|corner| of_corner(usize::from(corner) % 3))
    }
}

/// A ray turned so that it runs along +z from the origin: what all triangles share.
///
/// Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, in `f64`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ShearedRay {
    o: DVec3,
    /// The origin along each of `axes`.
    turned: [f64; 3],
    /// One over the direction.
    inverse: DVec3,
    /// The longest axis of the direction last.
    axes: [Axis; 3],
    shear: DVec3,
}

impl ShearedRay {
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        let axes = Axis::longest_last(ray.d);
        let [x, y, z] = axes.map(|axis| axis.of(ray.d.as_ref()));
        ShearedRay {
            o: ray.o,
            turned: axes.map(|axis| axis.of(ray.o.as_ref())),
            inverse: ray.d.recip(),
            axes,
            shear: DVec3::new(x / z, y / z, 1.0 / z),
        }
    }

    /// Distance, more than 0, and in proportion to what the corners weigh, where the ray crosses the triangle. Edges and
    /// vertices belong to the triangle, so that neighbors leave no gap.
    #[inline(always)]
    pub fn intersect(&self, triangle: &[DVec3; 3]) -> Option<(f64, [f64; 3])> {
        let o = self.turned;
        let sheared = |p: &DVec3| {
            let [x, y, z] = self.axes.map(|axis| axis.of(p.as_ref()));
            let (x, y, z) = (x - o[0], y - o[1], z - o[2]);
            (x - self.shear.x * z, y - self.shear.y * z, z)
        };
        // Compilers do not always inline what `map` calls.
        let (a, b, c) = (sheared(&triangle[0]), sheared(&triangle[1]), sheared(&triangle[2]));
        // Twice the areas of the triangles between the origin and each edge: they tell the side of the edge.
        let mut u = c.0 * b.1 - c.1 * b.0;
        let mut v = a.0 * c.1 - a.1 * c.0;
        let mut w = b.0 * a.1 - b.1 * a.0;
        if u == 0.0 || v == 0.0 || w == 0.0 {
            u = side(c, b);
            v = side(a, c);
            w = side(b, a);
        }
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let det = u + v + w;
        if det == 0.0 {
            return None;
        }
        let Extent { low, high, size } = Extent::new(triangle);
        let mut volume = u * a.2 + v * b.2 + w * c.2;
        let depth = a.2.abs().max(b.2.abs()).max(c.2.abs()) + size;
        if volume.abs() <= depth * depth * (DOUBT * size) {
            volume = volume_from(self.o, triangle, DVec3::ZERO);
        }
        let t = volume * self.shear.z / det;
        if t <= 0.0 {
            return None;
        }
        let t = within_box(self.o, self.inverse, low, high, t)?;
        (t > 0.0).then_some((t, [u, v, w]))
    }
}

/// A box around a triangle: wider than it by what rounding does to the place of an edge between far vertices, so that a
/// ray that the test of an edge lets in is not kept out by the box.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Extent {
    pub low: DVec3,
    pub high: DVec3,
    /// The longest side.
    pub size: f64,
}

impl Extent {
    #[inline(always)]
    pub fn new([p, q, r]: &[DVec3; 3]) -> Self {
        let (low, high) = (p.min(*q).min(*r), p.max(*q).max(*r));
        let size = (high - low).max_element();
        let rounding = DVec3::splat(4.0 * f64::EPSILON * size);
        Extent { low: low - rounding, high: high + rounding, size }
    }
}

/// The volume between a ray's origin and a triangle is in doubt below this share of the triangle's size times its
/// squared distance: more than rounding takes.
const DOUBT: f64 = 1024.0 * f64::EPSILON;

/// A plane holds a point if moving each coordinate by this share of itself can bring the point into it: what rounding of
/// the corners, of transformations and of the computation takes.
const IN_PLANE: f64 = 16.0 * f64::EPSILON;

/// Six times the volume of the tetrahedron between a point and a triangle, with the sign of the side that the point is on;
/// 0 where the plane of the triangle holds the point. `spread`: what the point was computed from, along each axis.
#[cold]
#[inline(never)]
fn volume_from(point: DVec3, corners: &[DVec3; 3], spread: DVec3) -> f64 {
    let [p, q, r] = corners.map(|corner| corner - point);
    let (e, f) = (corners[1] - corners[0], corners[2] - corners[0]);
    let (size, [e_size, f_size]) = (p.abs().max(q.abs()).max(r.abs()) + spread, [e.abs(), f.abs()]);
    // The normal, and the sum of its terms: along an axis of the plane both are exactly zero.
    let n = e.cross(f);
    let n_size = e_size.yzx() * f_size.zxy() + e_size.zxy() * f_size.yzx();
    let volume = -n.dot(p);
    if volume.abs() <= IN_PLANE * n_size.dot(size) { 0.0 } else { volume }
}

/// True if the plane of a triangle contains the point light at the end of a shadow ray.
pub(crate) fn holds_end(ray: &Ray, corners: &[DVec3; 3]) -> bool {
    volume_from(ray.end(), corners, (ray.d * ray.t_max).abs()) == 0.0
}

/// The corners of a triangle relative to the origin.
#[inline(always)]
pub(crate) fn corners(mesh: &Mesh, index: usize, origin: DVec3) -> [DVec3; 3] {
    mesh.triangle(index).map(|vertex| DVec3::from(mesh.positions()[vertex]) - origin)
}

/// Sorts the corners of a triangle, and tells where the first two went. Sums then round alike for all triangles with the
/// same corners, so that their distances are the same, whatever their winding.
pub(crate) fn sorted(corners: [DVec3; 3]) -> ([DVec3; 3], [u8; 2]) {
    let mut order = [0, 1, 2];
    order.sort_by(|i, j| {
        let (p, q): (DVec3, DVec3) = (corners[*i], corners[*j]);
        p.to_array().partial_cmp(&q.to_array()).unwrap_or(Ordering::Equal)
    });
    let place = |corner| order.iter().position(|i| *i == corner).unwrap_or(0) as u8;
    (order.map(|i| corners[i]), [place(0), place(1)])
}

/// The sign of `p.0 * q.1 - p.1 * q.0` where the rounded products are equal: by what rounding took from them.
#[cold]
fn side(p: (f64, f64, f64), q: (f64, f64, f64)) -> f64 {
    let (left, right) = (p.0 * q.1, p.1 * q.0);
    if left != right {
        return left - right;
    }
    p.0.mul_add(q.1, -left) - p.1.mul_add(q.0, -right)
}

/// The corners of up to eight triangles in `f32`, and how far these are to be trusted.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Block {
    /// The coordinates by corner, axis and triangle.
    pub corners: [[[f32; WIDTH]; 3]; 3],
    /// The rounding error of the corners.
    error: f32,
    /// Twice the longest side of the box of any of the triangles, or more.
    size: f32,
    /// A bit for each triangle.
    pub mask: u32,
    /// The bits of the triangles without holes: see [`Block::find_solid`].
    pub solid: u32,
    /// The place of the first triangle; those of the others follow.
    first: u32,
}

impl Block {
    /// A block of one to eight triangles with finite corners. `first`: the index of the first triangle in its group.
    pub fn new(triangles: &[Triangle], first: usize) -> Self {
        debug_assert!((1..=WIDTH).contains(&triangles.len()));
        debug_assert!(triangles.iter().flat_map(|triangle| triangle.corners).all(|p| p.is_finite()));
        let (mut magnitude, mut extent) = (0.0, LEAST_SIZE);
        let mut corners = [[[0.0; WIDTH]; 3]; 3];
        for (lane, triangle) in triangles.iter().enumerate() {
            for (corner, p) in triangle.corners.iter().enumerate() {
                for axis in 0..3 {
                    corners[corner][axis][lane] = p[axis] as f32;
                }
                magnitude = p.abs().max_element().max(magnitude);
            }
            let [p, q, r] = &triangle.corners;
            let sides = p.max(*q).max(*r) - p.min(*q).min(*r);
            extent = sides.max_element().max(extent);
        }
        let is_safe = extent < MOST_SIZE && magnitude < f64::from(MOST_MAGNITUDE);
        let mask = (1 << triangles.len()) - 1;
        Block {
            corners,
            error: if is_safe { 12.0 * UNIT * magnitude as f32 + f32::MIN_POSITIVE } else { f32::INFINITY },
            size: 2.0 * extent as f32,
            mask,
            solid: mask,
            first: first as u32,
        }
    }

    /// Finds the triangles without holes, given all triangles of the group. `has_holes`: true for triangles that may have holes.
    pub fn find_solid(&mut self, triangles: &[Triangle], has_holes: impl Fn(&Triangle) -> bool) {
        let own = &triangles[self.first as usize..];
        let bit = |lane: usize| u32::from(!has_holes(&own[lane])) << lane;
        self.solid = (0..self.mask.count_ones() as usize).fold(0, |solid, lane| solid | bit(lane));
    }

    /// The least and the greatest coordinates of the triangles along each axis, wider by what rounding has taken.
    #[inline(always)]
    pub fn boxes<S: Simd>(&self, simd: S) -> [[f32x8<S>; 3]; 2] {
        let mut boxes = [[splat_f32(simd, 0.0); 3]; 2];
        let [a, b, c] = &self.corners;
        for axis in 0..3 {
            let (a, b): (f32x8<S>, f32x8<S>) = (a[axis].simd_into(simd), b[axis].simd_into(simd));
            let c: f32x8<S> = c[axis].simd_into(simd);
            boxes[0][axis] = a.min(b).min(c) - self.error;
            boxes[1][axis] = a.max(b).max(c) + self.error;
        }
        boxes
    }

    /// The tolerance for rays with a rounding error of `error`.
    #[inline(always)]
    pub fn tolerance(&self, error: f32) -> Tolerance {
        let error = self.error + error;
        let size = self.size + 2.0 * error;
        Tolerance { error, size, side: 4.0 * size * (error + UNIT * size) }
    }

    /// The place of a triangle.
    #[inline(always)]
    pub fn place(&self, lane: u32) -> u32 {
        self.first + lane
    }

    /// The bit of the triangle at a place, if it is here.
    #[inline(always)]
    pub fn bit_of(&self, place: u32) -> u32 {
        let lane = place.wrapping_sub(self.first);
        u32::from(lane < WIDTH as u32) << (lane % WIDTH as u32)
    }
}

/// The tolerance for rounding of triangles, in a space where the ray runs along z from the origin.
///
/// Corners and origin are rounded, and their difference, and its product with the shear: a corner moves by less than
/// `error`. Where the ray passes the box of a triangle, its corners are not farther from it than `size`. The cross
/// product of two of them then moves by less than `side`. Where products overflow or vanish, nothing is known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tolerance {
    pub error: f32,
    pub size: f32,
    pub side: f32,
}

/// The rounding of one operation, relative to its result.
pub(crate) const UNIT: f32 = f32::EPSILON / 2.0;

/// Products of smaller numbers vanish in `f32`.
const LEAST_SIZE: f64 = 1e-15;
/// Products of larger ones overflow.
const MOST_SIZE: f64 = 1e17;
/// Coordinates that may be rounded by more than that.
pub(crate) const MOST_MAGNITUDE: f32 = 1e23;

/// Rays turned to run along z, as [`ShearedRay`]: one in all lanes, or eight of them side by side.
///
/// It tells what rays certainly miss, with any instructions: a corner is moved by less than 12 [`UNIT`]s of the coordinates that
/// it is computed from.
#[derive(Clone, Copy)]
pub(crate) struct Filter<S: Simd> {
    /// The longest of the direction last.
    pub axes: [Axis; 3],
    pub rays: Turned<S>,
    /// The error of corners that the rounding of the rays causes.
    pub error: f32,
}

/// Rays along three axes.
#[derive(Clone, Copy)]
pub(crate) struct Turned<S: Simd> {
    /// The shear: the step along each of the first two axes for a step of -1 along the last.
    pub shear: [f32x8<S>; 2],
    /// The coordinates of the rays where the last coordinate is zero.
    pub offset: [f32x8<S>; 2],
    /// The origin along the last axis.
    pub start: f32x8<S>,
    /// The direction along it.
    pub along: f32x8<S>,
}

/// Triangles of a block that one ray, in all lanes, may hit.
pub(crate) struct BlockHits<S: Simd> {
    /// The bits of the triangles that the ray may hit before its end.
    pub may: u32,
    /// The bits of the triangles that the ray certainly hits, if it is long enough.
    pub certain: u32,
    /// The least and the greatest depths of the triangles along the last axis, as rounded.
    pub depths: [f32x8<S>; 2],
    /// The largest error of these depths.
    pub error: f32,
}

/// A triangle as a ray passes it.
pub(crate) struct Sides<S: Simd> {
    corners: [[f32x8<S>; 2]; 3],
    /// On which sides of its edges: in proportion to the areas between these and the ray.
    least: f32x8<S>,
    greatest: f32x8<S>,
}

impl<S: Simd> Turned<S> {
    /// Prepares rays whose origins and directions were rounded once to `f32`.
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
    /// A filter for rays in this order of axes. `magnitude`: the largest coordinate of their origins.
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

    /// The triangles of a block that one ray, in all lanes, may hit before `end`, a depth along the last axis with an error of up to 6
    /// [`UNIT`]s. The triangles in `left_out` do not count. `EARLY`: stop where the sides tell that all are missed; without it, all
    /// triangles take the same way through the code.
    #[inline(always)]
    pub fn meet<const EARLY: bool>(
        &self,
        simd: S,
        block: &Block,
        end: f32,
        left_out: u32,
    ) -> Option<BlockHits<S>> {
        let corner = |at: usize, axis: Axis| f32x8::from_slice(simd, &block.corners[at][axis as usize]);
        let (tolerance, sides) = (block.tolerance(self.error), self.sides(corner));
        let is_missed = sides.pass(&tolerance);
        let left = block.mask & !left_out;
        if EARLY && !is_missed.to_bitmask() as u32 & left == 0 {
            return None;
        }
        let depths = self.depths(corner);
        let [front, back] = depths;
        let error = tolerance.error;
        let is_out = is_missed | front.simd_gt(end * (1.0 + 8.0 * UNIT) + error) | back.simd_lt(-error);
        let may = !is_out.to_bitmask() as u32 & left;
        if may == 0 {
            return None;
        }
        let certain = may & (front.simd_gt(error) & sides.are_one(&tolerance)).to_bitmask() as u32;
        Some(BlockHits { may, certain, depths, error })
    }
}

impl<S: Simd> BlockHits<S> {
    /// The triangles that the ray certainly hits before `end`.
    #[inline(always)]
    pub fn certain_before(&self, end: f32) -> u32 {
        let [_, back] = self.depths;
        let is_before = back.simd_lt(end * (1.0 - 12.0 * UNIT) - 2.0 * self.error);
        self.certain & is_before.to_bitmask() as u32
    }
}

impl<S: Simd> Sides<S> {
    /// The lanes where the ray certainly passes two edges on opposite sides.
    #[inline(always)]
    pub fn pass(&self, tolerance: &Tolerance) -> mask32x8<S> {
        self.least.simd_lt(-tolerance.side) & self.greatest.simd_gt(tolerance.side)
    }

    /// The lanes where the ray certainly passes all edges on the same side.
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
