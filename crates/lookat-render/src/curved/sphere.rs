//! Rays against spheres, by the point of the ray that is closest to the center.

use std::f64::consts::PI;

use glam::{DMat3, DVec2, DVec3};
use twofloat::TwoFloat;

use super::part::{Part, Sweep};
use super::profile::Crossings;
use super::quadric::radial;
use crate::parametric::Local;
use crate::warp::at_angle;

/// A sphere around the origin, or part of one.
#[derive(Debug, Clone)]
pub(crate) struct Sphere {
    pub radius: f64,
    /// The radius in the world, where the sphere is still one there.
    pub world_radius: Option<f64>,
    /// `None` for a whole sphere.
    cut: Option<Box<Cut>>,
}

/// The part of a sphere that there is.
#[derive(Debug, Clone, Copy)]
struct Cut {
    z_min: f64,
    z_max: f64,
    /// The angle from +z, where v is 0 and by how much it is more where v is 1, in radians.
    polar: [f64; 2],
    sweep: Sweep,
}

impl Sphere {
    pub(super) fn new(sphere: lookat_scene::Sphere, sweep: Sweep, world_from_own: &DMat3) -> Self {
        let lookat_scene::Sphere { radius, z_min, z_max } = sphere;
        let world_radius = uniform_scale(world_from_own).map(|scale| scale * radius);
        let is_whole = z_min <= -radius && z_max >= radius && sweep.is_whole();
        let cut = (!is_whole).then(|| {
            let [start, end] = [z_min, z_max].map(|z| libm::acos((z / radius).clamp(-1.0, 1.0)));
            Box::new(Cut { z_min, z_max, polar: [start, end - start], sweep })
        });
        Sphere { radius, world_radius, cut }
    }

    fn cut(&self) -> Cut {
        let whole =
            || Cut { z_min: -self.radius, z_max: self.radius, polar: [PI, -PI], sweep: Part::WHOLE.sweep };
        self.cut.as_deref().copied().unwrap_or_else(whole)
    }

    /// `None` of a whole sphere.
    pub(super) fn part(&self) -> Option<Part> {
        let Cut { z_min, z_max, sweep, .. } = *self.cut.as_deref()?;
        // Rounding is not to cut off a pole.
        let z_min = if z_min > -self.radius { z_min } else { f64::NEG_INFINITY };
        let z_max = if z_max < self.radius { z_max } else { f64::INFINITY };
        Some(Part { z_min, z_max, sweep, ..Part::WHOLE })
    }

    /// True for a whole sphere.
    #[inline(always)]
    pub fn is_whole(&self) -> bool {
        self.cut.is_none()
    }

    /// Where a line meets the whole sphere.
    #[inline]
    pub(super) fn meet(&self, o: DVec3, d: DVec3) -> Option<Crossings> {
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
        let Foot { k, correction, near, .. } = foot;
        let half = (squared / dd).sqrt();
        let offsets = [-half, half];
        // Added from the smallest to the largest.
        let t = offsets.map(|offset| k + (correction + offset));
        Some(Crossings { d, near, offsets, t, middle: k + correction })
    }

    pub fn parametric(&self, p: DVec3) -> Local {
        let angle = Sweep::angle(p.truncate(), DVec2::X);
        let Cut { polar: [start, span], sweep, .. } = self.cut();
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
        let Cut { z_min, z_max, sweep, .. } = self.cut();
        let z = z_min + (z_max - z_min) * u.x;
        let r = ((self.radius - z) * (self.radius + z)).max(0.0).sqrt();
        (at_angle(sweep.max * u.y) * r).extend(z)
    }

    /// The area of the part that there is.
    pub fn area(&self) -> f64 {
        let Cut { z_min, z_max, sweep, .. } = self.cut();
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
