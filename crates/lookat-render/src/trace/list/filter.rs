//! What rays may hit in a small world: tests in `f32`, sixteen rays side by side.

use fearless_simd::{Simd, f32x16, f64x8, mask32x16, prelude::*};
use glam::{DVec3, Vec3Swizzles};

use super::{Element, ListedShape, ROOM};
use crate::columns::MOST as MOST_RAYS;
use crate::curved::Curved;
use crate::number::{LANES, V3, Vec3x8, power_of_two};
use crate::ray::NEAR_END;
use crate::trace::rays::{RayColumns, Rays};
use crate::triangle::{Triangle, UNIT};

/// The rays that are tested side by side.
const WIDE: usize = 2 * LANES;

/// The elements of a small world in `f32`.
pub(super) struct ListFilter {
    /// The middle of a box around all elements.
    center: DVec3,
    /// A power of two by which positions are scaled, so that no element is farther than 1 from the center.
    scale: f64,
    /// The triangles and the other elements, with their numbers.
    triangles: Vec<(usize, PluckerTriangle)>,
    spheres: Vec<(usize, BoundingSphere)>,
}

/// A triangle by the Plücker coordinates of its edges.
///
/// The reciprocal product of a ray and an edge tells the side on which they pass each other. With u for the rounding of one operation, a
/// product is off by less than 10 u times the sizes of its factors, and 16 u are allowed for. Factors count as at least 2^-26 times the
/// distances and lengths that they are computed from: 2^-46 of these in a product, more than what `f64` rounds. The moment of an edge is that of its
/// vector, which does not cancel where the edge is short.
struct PluckerTriangle {
    edges: [Edge; 3],
    /// Not of length one.
    normal: [f32; 3],
    /// The product of the normal and any point of the plane.
    offset: f32,
    /// The error of the sides for each unit of the ray's direction and of its moment.
    side_error: [f32; 2],
    /// The error of the product of the normal and the way from the origin of a ray to the plane: what is the same for all rays, and what each unit of
    /// the origin adds.
    volume_error: [f32; 2],
    /// What a side must be more than, besides its error, for a hit to be certain: 0, or infinite if there may be holes.
    least_side: f32,
}

#[derive(Clone, Copy, Default)]
struct Edge {
    along: [f32; 3],
    moment: [f32; 3],
}

/// A sphere around a curved shape.
struct BoundingSphere {
    center: [f32; 3],
    radius: f32,
}

/// Rays as lines, relative to the center and scaled.
struct Lines<S: Simd> {
    o: V3<f32x16<S>>,
    d: V3<f32x16<S>>,
    /// o x d.
    moment: V3<f32x16<S>>,
    /// The largest coordinates of the three.
    o_size: f32x16<S>,
    d_size: f32x16<S>,
    moment_size: f32x16<S>,
    /// The ends of the rays.
    t_max: f32x16<S>,
    /// The number of the element that each leaves.
    leaving: f32x16<S>,
    active: mask32x16<S>,
    /// The place of the first one among all rays.
    first: usize,
}

/// Where rays may hit an element: at distances that are ratios of two numbers, both with bounds of their errors.
struct DistanceBounds<S: Simd> {
    /// The rays that may hit the element, and those that certainly do, as far as the distance is not concerned.
    may: mask32x16<S>,
    is_certain: mask32x16<S>,
    numerator: f32x16<S>,
    /// Not negative.
    denominator: f32x16<S>,
    numerator_error: f32x16<S>,
    denominator_error: f32x16<S>,
}

impl<S: Simd> DistanceBounds<S> {
    /// The least and the greatest numerator.
    #[inline(always)]
    fn numerators(&self) -> [f32x16<S>; 2] {
        [self.numerator - self.numerator_error, self.numerator + self.numerator_error]
    }

    /// The rays that may hit the element before their ends.
    #[inline(always)]
    fn may_be_before(&self, end: f32x16<S>) -> mask32x16<S> {
        let [least, most] = self.numerators();
        let is_beyond = least.simd_gt(end * (self.denominator + self.denominator_error));
        self.may & !(is_beyond | self.is_behind(most))
    }

    /// The rays that would hit the element before they start. `most`: the greatest numerator.
    #[inline(always)]
    fn is_behind(&self, most: f32x16<S>) -> mask32x16<S> {
        // A ray that is nearly in the plane may pass it in either direction.
        most.simd_lt(0.0) & self.denominator.simd_gt(self.denominator_error)
    }

    /// The rays that certainly hit the element before their ends.
    #[inline(always)]
    fn is_before(&self, end: f32x16<S>) -> mask32x16<S> {
        let [least, most] = self.numerators();
        let is_near = most.simd_lt(end * (self.denominator - self.denominator_error));
        self.is_certain & is_near & least.simd_gt(0.0)
    }

    /// The least distances where rays may hit the element, infinite for rays that miss it; and the greatest ones where they certainly do, infinite for
    /// others.
    #[inline(always)]
    fn distances(&self) -> [f32x16<S>; 2] {
        let simd = self.may.token();
        let (zero, infinity) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, f32::INFINITY));
        let [least, most] = self.numerators();
        let inverse = 1.0 / self.denominator;
        // 1 / (1 + e) is not less than 1 - e, and up to 1/2, 1 / (1 - e) is not more than 1 + 2 e. As e is 16 u or more, and half of it at least is to
        // spare, what these operations round is covered.
        let error = self.denominator_error * inverse;
        let is_ahead = least.simd_gt(0.0);
        let (near, far) = (least * inverse * (1.0 - error), most * inverse * (1.0 + error * 2.0));
        let is_certain = self.is_certain & is_ahead & error.simd_lt(0.5);
        let near = is_ahead.select(near, zero);
        [(self.may & !self.is_behind(most)).select(near, infinity), is_certain.select(far, infinity)]
    }
}

/// Scaled distances of origins beyond this, and directions of other lengths than about one, have no bounds.
const FARTHEST: f64 = 1e6;
/// More than what numbers lose that vanish in `f32`.
const VANISHING: f32 = 1e-30;
/// See [`PluckerTriangle`].
const LEAST_FACTOR: f64 = 1.0 / (1 << 26) as f64;

impl ListFilter {
    /// `None` of no elements, of a single point, and where elements are too small for their distance from the origin.
    pub fn new(elements: &[Element]) -> Option<Self> {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for element in elements {
            let (own_low, own_high) = match element.shape {
                ListedShape::Triangle(boxed) => {
                    let [p, q, r] = boxed.triangle.corners;
                    (p.min(q).min(r), p.max(q).max(r))
                }
                ListedShape::Curved(curved) => {
                    (curved.center - curved.half_extent(), curved.center + curved.half_extent())
                }
            };
            (low, high) = (low.min(own_low), high.max(own_high));
        }
        let center = low + (high - low) * 0.5;
        let diagonal = (high - low).length();
        if !(diagonal > 0.0 && diagonal < f64::INFINITY) {
            return None;
        }
        let scale = power_of_two(0.5 / diagonal);
        let is_safe = scale.is_normal() && center.abs().max_element() * scale < FARTHEST;
        let placed = |p| (p - center) * scale;
        let (mut triangles, mut spheres) = (Vec::new(), Vec::new());
        for (number, element) in elements.iter().enumerate() {
            match element.shape {
                ListedShape::Triangle(boxed) => {
                    triangles
                        .push((number, PluckerTriangle::new(boxed.triangle, placed, element.is_cut_out)));
                }
                ListedShape::Curved(curved) => {
                    spheres.push((number, BoundingSphere::new(curved, placed, scale)))
                }
            }
        }
        is_safe.then_some(ListFilter { center, scale, triangles, spheres })
    }

    /// Removes the rays that certainly miss an element from those in `may`, bits for each element. With `ANY`, returns the rays that certainly hit one
    /// before their ends; else the rays that certainly hit another element before are removed, too.
    #[inline(always)]
    pub fn test<S: Simd, const ANY: bool>(
        &self,
        simd: S,
        rays: &RayColumns,
        active: u64,
        may: &mut [u64; ROOM],
    ) -> u64 {
        let (mut blocked, mut least) = (0, [[0.0; WIDE]; ROOM]);
        for first in (0..MOST_RAYS).step_by(WIDE).filter(|first| active >> first & 0xffff != 0) {
            let eights = [rays.eight(simd, first), rays.eight(simd, first + LANES)];
            let lines = Lines::new(self, first, eights, active);
            let mut certain = CertainHits { nearest: lines.t_max, is_blocked: mask32x16::splat(simd, false) };
            for (number, triangle) in &self.triangles {
                let at = *number % ROOM;
                certain.add::<ANY>(&lines, triangle.bounds(&lines, at as f32), &mut may[at], &mut least[at]);
            }
            for (number, sphere) in &self.spheres {
                let at = *number % ROOM;
                certain.add::<ANY>(&lines, Some(sphere.bounds(&lines)), &mut may[at], &mut least[at]);
            }
            if ANY {
                blocked |= certain.is_blocked.to_bitmask() << first;
                continue;
            }
            let count = self.triangles.len() + self.spheres.len();
            for (may, least) in may.iter_mut().zip(&least).take(count) {
                // A distance that is not a number tells nothing.
                let is_beyond = f32x16::from_slice(simd, least).simd_ge(certain.nearest);
                *may &= !(is_beyond.to_bitmask() << first);
            }
        }
        blocked & active
    }
}

/// What sixteen rays certainly hit.
struct CertainHits<S: Simd> {
    /// A distance that their nearest hits are not beyond.
    nearest: f32x16<S>,
    /// The rays that hit anything before their ends, if `ANY` hit will do.
    is_blocked: mask32x16<S>,
}

impl<S: Simd> CertainHits<S> {
    /// Adds an element. If `ANY` hit will do, the rays that miss it are removed from `may`, bits of all rays for which it counts. Else `least`
    /// receives the least distances where rays may hit it.
    #[inline(always)]
    fn add<const ANY: bool>(
        &mut self,
        lines: &Lines<S>,
        bounds: Option<DistanceBounds<S>>,
        may: &mut u64,
        least: &mut [f32; WIDE],
    ) {
        let first = lines.first;
        let others = !(0xffff << first);
        match bounds {
            None if ANY => *may &= others,
            None => *least = [f32::INFINITY; WIDE],
            Some(bounds) if ANY => {
                let own = mask32x16::from_bitmask(lines.t_max.token(), *may >> first & 0xffff);
                self.is_blocked |= own & bounds.is_before(lines.t_max * BEFORE_END);
                *may &= others | bounds.may_be_before(lines.t_max).to_bitmask() << first;
            }
            Some(bounds) => {
                let [near, far] = bounds.distances();
                self.nearest = self.nearest.min(far);
                near.store_slice(least);
            }
        }
    }
}

/// The share of its way on which what a ray certainly hits is not its end. That ends are moved away by 4 u does not matter: denominators are known to
/// 16 u at best.
const BEFORE_END: f32 = NEAR_END as f32;

impl<S: Simd> Lines<S> {
    #[inline(always)]
    fn new(filter: &ListFilter, first: usize, rays: [Rays<S>; 2], active: u64) -> Self {
        let [low, high] = [Line::new(filter, &rays[0]), Line::new(filter, &rays[1])];
        Lines {
            o: both3(low.o, high.o),
            d: both3(low.d, high.d),
            moment: both3(low.moment, high.moment),
            o_size: both(low.o_size, high.o_size),
            d_size: both(low.d_size, high.d_size),
            moment_size: both(low.moment_size, high.moment_size),
            t_max: both(low.t_max, high.t_max),
            leaving: both(low.leaving, high.leaving),
            active: mask32x16::from_bitmask(rays[0].t_max.token(), active >> first & 0xffff),
            first,
        }
    }

    /// The reciprocal products of the rays and an edge.
    #[inline(always)]
    fn side(&self, edge: &Edge) -> f32x16<S> {
        let (simd, [x, y, z]) = (self.t_max.token(), edge.along);
        let V3 { x: m_x, y: m_y, z: m_z } = self.moment;
        let of_direction = dot(&self.d, &edge.moment);
        let of_z = m_z.mul_add(f32x16::splat(simd, z), of_direction);
        m_x.mul_add(f32x16::splat(simd, x), m_y.mul_add(f32x16::splat(simd, y), of_z))
    }
}

/// Sixteen numbers, rounded to `f32`.
#[inline(always)]
fn both<S: Simd>(low: f64x8<S>, high: f64x8<S>) -> f32x16<S> {
    low.token().narrow_f64x8(low, high)
}

#[inline(always)]
fn both3<S: Simd>(low: Vec3x8<S>, high: Vec3x8<S>) -> V3<f32x16<S>> {
    V3 { x: both(low.x, high.x), y: both(low.y, high.y), z: both(low.z, high.z) }
}

/// Half of [`Lines`], in `f64`.
struct Line<S: Simd> {
    o: Vec3x8<S>,
    d: Vec3x8<S>,
    moment: Vec3x8<S>,
    o_size: f64x8<S>,
    d_size: f64x8<S>,
    moment_size: f64x8<S>,
    t_max: f64x8<S>,
    leaving: f64x8<S>,
}

impl<S: Simd> Line<S> {
    #[inline(always)]
    fn new(filter: &ListFilter, rays: &Rays<S>) -> Self {
        let (simd, d, leaving) = (rays.t_max.token(), rays.d, rays.leaving);
        let o = (rays.o - Vec3x8::splat(simd, filter.center)) * f64x8::splat(simd, filter.scale);
        let moment = o.cross(d);
        let (o_size, d_size) = (o.magnitude(), d.magnitude());
        let moment_size = moment.magnitude() + (o_size + 1.0) * d_size * LEAST_FACTOR;
        // Rays that are out of range get bounds that tell nothing.
        let is_safe = o_size.simd_lt(FARTHEST) & d_size.simd_gt(0.25) & d_size.simd_lt(4.0);
        let moment_size = is_safe.select(moment_size, f64x8::splat(simd, f64::INFINITY));
        let t_max = rays.t_max * (filter.scale * (1.0 + f64::from(4.0 * UNIT)));
        Line { o, d, moment, o_size, d_size, moment_size, t_max, leaving }
    }
}

/// The sum of products with numbers that are the same for all rays.
#[inline(always)]
fn dot<S: Simd>(v: &V3<f32x16<S>>, [x, y, z]: &[f32; 3]) -> f32x16<S> {
    let simd = v.x.token();
    v.x.mul_add(f32x16::splat(simd, *x), v.y.mul_add(f32x16::splat(simd, *y), v.z * *z))
}

impl PluckerTriangle {
    /// `placed`: brings points to the space of the filter.
    fn new(triangle: &Triangle, placed: impl Fn(DVec3) -> DVec3, is_cut_out: bool) -> Self {
        let corners = triangle.corners.map(placed);
        let edges = [[1, 2], [2, 0], [0, 1]].map(|[from, to]| (corners[from], corners[to]));
        let (e, f) = (corners[1] - corners[0], corners[2] - corners[0]);
        let normal = e.cross(f);
        let sum = |v: DVec3| v.abs().element_sum();
        let most = |of: &dyn Fn(&(DVec3, DVec3)) -> f64| edges.iter().map(of).fold(0.0, f64::max);
        let along = most(&|(p, q)| sum(q - p));
        let moment = most(&|(p, q)| sum(p.cross(*q - *p))) + along * LEAST_FACTOR;
        // The terms of the normal, which may cancel.
        let terms = (e.abs().yzx() * f.abs().zxy() + e.abs().zxy() * f.abs().yzx()).element_sum();
        let offset = normal.dot(corners[0]);
        let unit = f64::from(16.0 * UNIT);
        let f32s = |v: DVec3| v.as_vec3().to_array();
        PluckerTriangle {
            edges: edges.map(|(p, q)| Edge { along: f32s(q - p), moment: f32s(p.cross(q - p)) }),
            normal: f32s(normal),
            offset: offset as f32,
            side_error: [moment * unit, along * unit].map(|x| x as f32 + VANISHING),
            volume_error: [(offset.abs() + terms) * unit, terms * unit].map(|x| x as f32 + VANISHING),
            least_side: if is_cut_out { f32::INFINITY } else { 0.0 },
        }
    }

    /// Where rays may hit the triangle. `number`: that of the element. `None` where all miss it.
    #[inline(always)]
    fn bounds<S: Simd>(&self, lines: &Lines<S>, number: f32) -> Option<DistanceBounds<S>> {
        let [a, b, c] = &self.edges;
        let (u, v, w) = (lines.side(a), lines.side(b), lines.side(c));
        let error = lines.d_size * self.side_error[0] + lines.moment_size * self.side_error[1];
        let certain = error + self.least_side;
        let (least, most) = (u.min(v).min(w), u.max(v).max(w));
        let is_outside = least.simd_lt(-error) & most.simd_gt(error);
        let is_inside = least.simd_gt(certain) | most.simd_lt(-certain);
        let may = lines.active & !(is_outside | lines.leaving.simd_eq(number));
        if !may.any_true() {
            return None;
        }
        let det = u + v + w;
        let volume = self.offset - dot(&lines.o, &self.normal);
        Some(DistanceBounds {
            may,
            is_certain: may & is_inside,
            numerator: det.simd_lt(0.0).select(-volume, volume),
            denominator: det.abs(),
            numerator_error: lines.o_size * self.volume_error[1] + self.volume_error[0],
            denominator_error: error * 3.0,
        })
    }
}

impl BoundingSphere {
    fn new(curved: &Curved, placed: impl Fn(DVec3) -> DVec3, scale: f64) -> Self {
        let radius = curved.bounding_radius() * scale;
        BoundingSphere {
            center: placed(curved.center).as_vec3().to_array(),
            radius: (radius * (1.0 + 1e-6)) as f32,
        }
    }

    /// Where rays may be in the sphere.
    #[inline(always)]
    fn bounds<S: Simd>(&self, lines: &Lines<S>) -> DistanceBounds<S> {
        let [x, y, z] = self.center;
        let (o, d, m) = (&lines.o, &lines.d, &lines.moment);
        // The vector from the center to the nearest point of the line, turned by a right angle.
        let away = [m.x - (d.z * y - d.y * z), m.y - (d.x * z - d.z * x), m.z - (d.y * x - d.x * y)];
        let distance_squared = away[0] * away[0] + away[1] * away[1] + away[2] * away[2];
        // Centers are not farther than 1 from the origin.
        let error = (lines.moment_size + lines.d_size * 2.0) * (16.0 * UNIT) + VANISHING;
        let length_squared = d.x * d.x + d.y * d.y + d.z * d.z;
        let half = length_squared.sqrt() * (self.radius * (1.0 + 8.0 * UNIT)) + error * 2.0;
        let may = lines.active & !distance_squared.simd_gt(half * half * (1.0 + 16.0 * UNIT));
        DistanceBounds {
            may,
            is_certain: may & !may,
            numerator: dot(d, &self.center) - (d.x * o.x + d.y * o.y + d.z * o.z),
            denominator: length_squared,
            numerator_error: half + (lines.o_size + 1.0) * lines.d_size * (32.0 * UNIT),
            denominator_error: length_squared * (16.0 * UNIT),
        }
    }
}
