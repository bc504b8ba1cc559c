//! Ray against triangle, watertight.

pub(crate) mod block;
pub(crate) mod filter;
pub(crate) mod parametric;
pub(crate) mod sheared;

use std::cmp::Ordering;

use glam::{DVec3, Vec3Swizzles};
use lookat_scene::Mesh;

use crate::bvh::within_box;
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

    /// Its name, in an instance or in the world.
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
        self.first.map(|at| sides[usize::from(at)] / sum)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::noise;

    fn hit(o: DVec3, d: DVec3, triangle: [DVec3; 3]) -> Option<(f64, [f64; 3])> {
        let (t, sides) = ShearedRay::new(&Ray::new(o, d)).intersect(&triangle)?;
        Some((t, sides.map(|side| side / sides.iter().sum::<f64>())))
    }

    #[test]
    fn finds_distance_and_weights() {
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let (t, weights) = hit(DVec3::new(0.25, 0.5, -3.0), DVec3::Z, triangle).unwrap();
        assert_eq!((t, weights), (3.0, [0.25, 0.25, 0.5]));
        assert!(hit(DVec3::new(0.6, 0.6, -3.0), DVec3::Z, triangle).is_none());
        // A ray in the plane of the triangle misses.
        assert!(hit(DVec3::new(-1.0, 0.2, 0.0), DVec3::X, triangle).is_none());
    }

    #[test]
    fn corners_in_any_order_give_the_same_distance() {
        let p = [DVec3::new(0.1, 0.2, 0.7), DVec3::new(1.3, -0.4, 0.9), DVec3::new(0.3, 1.7, 1.1)];
        let (o, d) = (DVec3::new(0.3, 0.4, -3.0), DVec3::new(0.07, 0.02, 1.0));
        let (corners, _) = sorted(p);
        let (t, weights) = hit(o, d, corners).unwrap();
        for [i, j, k] in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
            let (corners, first) = sorted([p[i], p[j], p[k]]);
            assert_eq!(hit(o, d, corners), Some((t, weights)));
            assert_eq!(first.map(|at| corners[usize::from(at)]), [p[i], p[j]]);
        }
    }

    /// An eye in the plane of two triangles, on their edge or beside it, in planes that are rounded: nothing is met. A little above
    /// the plane of an axis it meets what is below.
    #[test]
    fn rays_from_the_plane_of_a_triangle_miss_it() {
        for case in 0..20_000 {
            let vector = |k: f64| DVec3::new(noise(case, k), noise(case, k + 0.1), noise(case, k + 0.2));
            let (x, d) = (vector(1.1).normalize(), vector(5.1).normalize());
            let y = x.cross(vector(2.1)).normalize();
            let size = 10_f64.powi(case as i32 % 13 - 6);
            let corner = |u: f64, v: f64| (x * u + y * v) * size;
            let o = if case % 2 == 0 { DVec3::ZERO } else { corner(noise(case, 7.1), noise(case, 8.1)) };
            let square = [corner(-4.0, -3.0), corner(4.0, -5.0), corner(4.0, 3.0), corner(-5.0, 4.0)];
            for corners in [[square[0], square[1], square[2]], [square[0], square[2], square[3]]] {
                assert_eq!(hit(o, d, corners), None, "{case}");
            }
        }
        let floor = [DVec3::new(-30.0, 0.0, -20.0), DVec3::new(30.0, 0.0, -20.0), DVec3::new(0.0, 0.0, 50.0)];
        let down = DVec3::new(0.3, -1.0, 0.2).normalize();
        for height in [1e-300, 1e-30, 1e-15, 1.0] {
            let above = DVec3::new(0.1, height, 0.7);
            assert!(hit(above, down, floor).is_some() && hit(above, -down, floor).is_none(), "{height}");
        }
    }

    /// A seam on the side of the boxes of both triangles, whose vertices are far beyond the hit.
    #[test]
    fn rays_at_a_seam_between_boxes_never_pass() {
        for half in [1e2, 1e4, 1e6, 1e9] {
            let [a, b] = [-half, half].map(|z| DVec3::new(0.5, -1.0, z));
            let (left, right) = (DVec3::new(-half, -1.0, 0.0), DVec3::new(half, -1.0, 0.0));
            for case in 0..20_000 {
                let k = f64::from(case);
                let beside =
                    10_f64.powf(-17.0 + 12.0 * (k * 0.618).fract()) * if case % 2 == 0 { 1.0 } else { -1.0 };
                let o = DVec3::new((k * 0.37).sin(), 0.0, (k * 0.71).cos());
                let target = DVec3::new(0.5 + beside, -1.0, 2.0 + 48.0 * (k * 0.414).fract());
                let d = (target - o).normalize();
                let found = [[a, b, left], [a, right, b]].map(|triangle| hit(o, d, triangle));
                assert!(found.iter().any(Option::is_some), "{half} {case}");
            }
        }
    }

    #[test]
    fn rays_at_shared_edges_and_vertices_never_pass() {
        // Two triangles that share an edge, and rays aimed at it from every side.
        let corner = |k: f64| DVec3::new((k * 0.7).sin(), (k * 1.3).cos(), (k * 0.37).sin() * 0.5);
        for case in 0..20_000 {
            let k = f64::from(case) * 0.618;
            let [p, q] = [corner(k), corner(k + 5.0)];
            let across = (q - p).cross(corner(k + 9.0)).normalize();
            let (left, right) = (p + across + 0.3 * q, q - across * 2.0);
            let along = f64::from(case % 11) / 10.0;
            let (target, o) = (p + (q - p) * along, corner(k + 2.0) * 4.0 + DVec3::splat(3.0));
            let d = (target - o).normalize();
            // Only where the two lie on opposite sides of the edge as seen from the origin.
            let normal = (p - o).cross(q - o);
            if normal.dot(left - o) * normal.dot(right - o) >= 0.0 {
                continue;
            }
            // The ends of the edge are corners of the pair: a ray may pass beyond them by rounding.
            let inner = (0.05..0.95).contains(&along);
            let hits = hit(o, d, [p, q, left]).is_some() || hit(o, d, [q, p, right]).is_some();
            assert!(hits || !inner, "case {case}");
        }
    }
}
