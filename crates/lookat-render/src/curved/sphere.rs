//! Rays against spheres, one ray or eight, by the point of the ray that is closest to the center.

use std::f64::consts::{PI, TAU};

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::{DMat3, DVec2, DVec3};
use twofloat::TwoFloat;

use super::quadric::{Sweep, radial};
use super::{AT_ORIGIN, Curved};
use crate::number::Vec3x8;
use crate::parametric::Local;
use crate::warp::at_angle;

/// A sphere around the origin, or part of one.
#[derive(Debug, Clone)]
pub(crate) struct Sphere {
    pub radius: f64,
    /// The radius in the world, where the sphere is still one there.
    pub world_radius: Option<f64>,
    /// `None` for a whole sphere.
    part: Option<Box<Part>>,
}

/// The part of a sphere that there is.
#[derive(Debug, Clone, Copy)]
struct Part {
    z_min: f64,
    z_max: f64,
    /// The angle from +z, where v is 0 and by how much it is more where v is 1, in radians.
    polar: [f64; 2],
    sweep: Sweep,
}

impl Sphere {
    pub fn new(sphere: lookat_scene::Sphere, sweep: Sweep, world_from_own: &DMat3) -> Self {
        let lookat_scene::Sphere { radius, z_min, z_max } = sphere;
        let world_radius = uniform_scale(world_from_own).map(|scale| scale * radius);
        let is_whole = z_min <= -radius && z_max >= radius && sweep.is_whole();
        let part = (!is_whole).then(|| {
            let [start, end] = [z_min, z_max].map(|z| libm::acos((z / radius).clamp(-1.0, 1.0)));
            Box::new(Part { z_min, z_max, polar: [start, end - start], sweep })
        });
        Sphere { radius, world_radius, part }
    }

    fn part(&self) -> Part {
        let whole =
            || Part { z_min: -self.radius, z_max: self.radius, polar: [PI, -PI], sweep: Sweep::new(TAU) };
        self.part.as_deref().copied().unwrap_or_else(whole)
    }

    /// The nearest distance at which the ray meets the sphere, more than 0 and at most `t_max`. A ray that leaves the
    /// sphere meets it again only on its far side.
    #[inline]
    pub fn intersect(&self, o: DVec3, d: DVec3, t_max: f64, leaving: bool) -> Option<f64> {
        let dd = d.length_squared();
        let foot = Foot::new(o, d, dd);
        let radius = self.radius;
        let mut squared = (radius - foot.distance) * (radius + foot.distance);
        // Where rounding could turn a hit into a miss.
        if (radius - foot.distance).abs() <= 8.0 * f64::EPSILON * o.abs().max_element() {
            squared = exact_margin(o, d, radius) / dd;
        }
        if squared < 0.0 {
            return None;
        }
        let half = (squared / dd).sqrt();
        let middle = foot.k + foot.correction;
        // Added from the smallest to the largest.
        let roots = [-half, half].map(|offset| (foot.k + (foot.correction + offset), offset));
        let first = usize::from(leaving);
        if leaving && middle <= 0.0 {
            return None;
        }
        let counts = |&(t, offset): &(f64, f64)| t > 0.0 && t <= t_max && self.has(foot.near + d * offset);
        roots[first..].iter().find(|root| counts(root)).map(|(t, _)| *t)
    }

    /// True for a whole sphere.
    pub fn is_whole(&self) -> bool {
        self.part.is_none()
    }

    /// True if the partial sphere contains a point of the whole sphere.
    pub fn has(&self, p: DVec3) -> bool {
        self.part.as_deref().is_none_or(|Part { z_min, z_max, sweep, .. }| {
            let is_outside =
                (*z_min > -self.radius && p.z < *z_min) || (*z_max < self.radius && p.z > *z_max);
            !is_outside && sweep.has(p.truncate(), DVec2::X)
        })
    }

    pub fn parametric(&self, p: DVec3) -> Local {
        let angle = Sweep::angle(p.truncate(), DVec2::X);
        let Part { polar: [start, span], sweep, .. } = self.part();
        // Exact also next to the poles, where the cosine has few digits.
        let r = p.truncate().length();
        let theta = libm::atan2(r, p.z);
        Local {
            uv: DVec2::new(angle / sweep.max, (theta - start) / span),
            dpdu: DVec3::new(-p.y, p.x, 0.0) * sweep.max,
            dpdv: (radial(p) * p.z).extend(-r) * span,
            gradient: p,
            bend: DVec3::ONE,
        }
    }

    /// A point of the part that there is, all alike.
    pub fn sample(&self, u: DVec2) -> DVec3 {
        let Part { z_min, z_max, sweep, .. } = self.part();
        let z = z_min + (z_max - z_min) * u.x;
        let r = ((self.radius - z) * (self.radius + z)).max(0.0).sqrt();
        (at_angle(sweep.max * u.y) * r).extend(z)
    }

    /// The area of the part that there is.
    pub fn area(&self) -> f64 {
        let Part { z_min, z_max, sweep, .. } = self.part();
        (z_max - z_min) * self.radius * sweep.max
    }
}

/// The closest approach of a ray to the origin: no digits cancel, whatever the distance (after Haines et al., Ray Tracing
/// Gems 7, 2019; see docs/conventions.md).
struct Foot {
    /// The distance along the ray in lengths of `d`, and its correction.
    k: f64,
    correction: f64,
    near: DVec3,
    /// From the origin.
    distance: f64,
}

impl Foot {
    fn new(o: DVec3, d: DVec3, dd: f64) -> Foot {
        let k = -o.dot(d) / dd;
        let near = o + d * k;
        let correction = -near.dot(d) / dd;
        let near = near + d * correction;
        Foot { k, correction, near, distance: near.length() }
    }
}

/// The squared radius minus the squared distance of the ray, times the squared length of `d`; in double-double numbers.
#[cold]
fn exact_margin(o: DVec3, d: DVec3, radius: f64) -> f64 {
    let minor = |a: usize, b: usize| TwoFloat::new_mul(o[a], d[b]) - TwoFloat::new_mul(o[b], d[a]);
    let moment = [minor(1, 2), minor(2, 0), minor(0, 1)];
    let squares = moment.iter().fold(TwoFloat::from(0.0), |sum, x| sum + *x * *x);
    let dd = d.to_array().iter().fold(TwoFloat::from(0.0), |sum, x| sum + TwoFloat::new_mul(*x, *x));
    f64::from(TwoFloat::new_mul(radius, radius) * dd - squares)
}

/// The factor of a matrix that scales all directions alike, within rounding.
fn uniform_scale(m: &DMat3) -> Option<f64> {
    let scale = m.x_axis.length();
    let product = m.transpose() * *m;
    let error = (product * (1.0 / (scale * scale)) - DMat3::IDENTITY).to_cols_array();
    error.iter().all(|x| x.abs() < 1e-9).then_some(scale)
}

/// Possible hits of rays on a sphere.
pub(crate) struct Meetings<S: Simd> {
    pub met: mask64x8<S>,
    pub t: f64x8<S>,
    /// The rays that must be tested one by one.
    pub doubtful: mask64x8<S>,
}

/// The hits of eight rays on whole spheres of these radii around the origins, with the bits of [`Sphere::intersect`]. Also returns a mask of
/// doubtful hits.
#[inline(always)]
pub(crate) fn meet_whole<S: Simd>(
    radius: f64x8<S>,
    (o, d): (Vec3x8<S>, Vec3x8<S>),
    t_max: f64x8<S>,
    leaving: mask64x8<S>,
    active: mask64x8<S>,
) -> Meetings<S> {
    let dd = d.length_squared();
    let k = -o.dot(d) / dd;
    let near = o + d * k;
    let correction = -near.dot(d) / dd;
    let near = near + d * correction;
    let distance = near.length_squared().sqrt();
    let squared = (radius - distance) * (radius + distance);
    let doubtful = (radius - distance).abs().simd_le(o.magnitude() * (8.0 * f64::EPSILON)) & active;
    let met = active & !squared.simd_lt(0.0);
    if !(met | doubtful).any_true() {
        return Meetings { met, t: k, doubtful };
    }
    let half = (squared / dd).sqrt();
    let middle = k + correction;
    let (first, second) = (k + (correction - half), k + (correction + half));
    let is_first = first.simd_gt(0.0) & first.simd_le(t_max) & !leaving;
    let is_second = second.simd_gt(0.0) & second.simd_le(t_max) & !(leaving & middle.simd_le(0.0));
    let met = met & (is_first | is_second);
    let t = is_first.select(first, second);
    let is_at_origin = met & !leaving & (t * t * dd).simd_le(AT_ORIGIN * radius * radius);
    Meetings { met, t, doubtful: doubtful | is_at_origin }
}

impl Sphere {
    /// As [`meet_whole`]. All hits of partial spheres are doubtful.
    #[inline(always)]
    pub fn meet<S: Simd>(
        &self,
        ray: (Vec3x8<S>, Vec3x8<S>),
        t_max: f64x8<S>,
        leaving: mask64x8<S>,
        active: mask64x8<S>,
    ) -> Meetings<S> {
        let radius = self.radius.simd_into(t_max.token());
        let Meetings { met, t, doubtful } = meet_whole(radius, ray, t_max, leaving, active);
        Meetings { met, t, doubtful: if self.is_whole() { doubtful } else { met | doubtful } }
    }
}

impl Curved {
    /// The points of a sphere nearest to some that are near it, and the normals there; as [`Curved::project`], to the bit.
    #[inline(always)]
    pub fn on_sphere<S: Simd>(&self, p: Vec3x8<S>) -> (Vec3x8<S>, Vec3x8<S>) {
        let simd = p.x.token();
        let radius: f64x8<S> = self.as_sphere().map_or(0.0, |sphere| sphere.radius).simd_into(simd);
        let center = Vec3x8::splat(simd, self.center);
        let own = (p - center).by(&self.own_from_world).normalize_or(DVec3::Z) * radius;
        let normal = own.by(&self.own_from_world.transpose());
        (center + own.by(&self.world_from_own()), normal.normalize_or(DVec3::Z))
    }
}
