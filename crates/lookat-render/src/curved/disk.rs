//! Disks.

use glam::{DVec2, DVec3};
use twofloat::TwoFloat;

use super::sweep::{Sweep, radial};
use crate::circle::at_angle;
use crate::parametric::Local;

/// A disk or ring in the plane z = 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Disk {
    radius: f64,
    inner_radius: f64,
    sweep: Sweep,
}

impl Disk {
    pub fn new(radius: f64, inner_radius: f64, sweep: Sweep) -> Self {
        Disk { radius, inner_radius, sweep }
    }

    /// The radius, if it is whole.
    pub fn whole(&self) -> Option<f64> {
        (self.inner_radius == 0.0 && self.sweep.is_whole()).then_some(self.radius)
    }

    /// The distance at which a line meets it, more than 0 and at most `t_max`. One in its plane does not.
    pub fn intersect(&self, o: DVec3, d: DVec3, t_max: f64) -> Option<f64> {
        let t = -o.z / d.z;
        if !(t > 0.0 && t <= t_max) {
            return None;
        }
        // The point at t, without what rounding of t and of far coordinates does to it.
        let near = DVec3::from([0, 1, 2].map(|i| (TwoFloat::new_mul(d[i], t) + o[i]).hi()));
        let p = (near - d * (near.z / d.z)).truncate();
        let r = p.length();
        let reaches = |radius: f64| match (r - radius).abs() > 1e-14 * radius {
            true => r > radius,
            false => exact_margin(o, d, radius) < 0.0,
        };
        let has = !reaches(self.radius) && (self.inner_radius == 0.0 || !self.is_in_hole(r, o, d));
        (has && self.sweep.has(p, DVec2::X)).then_some(t)
    }

    /// Whether a line that meets the plane at a distance `r` from the axis, about, goes through the hole.
    fn is_in_hole(&self, r: f64, o: DVec3, d: DVec3) -> bool {
        match (r - self.inner_radius).abs() > 1e-14 * self.inner_radius {
            true => r < self.inner_radius,
            false => exact_margin(o, d, self.inner_radius) > 0.0,
        }
    }

    pub fn parametric(&self, p: DVec3) -> Local {
        let angle = Sweep::angle(p.truncate(), DVec2::X);
        let width = self.radius - self.inner_radius;
        Local {
            uv: DVec2::new(angle / self.sweep.max, (self.radius - p.truncate().length()) / width),
            dpdu: DVec3::new(-p.y, p.x, 0.0) * self.sweep.max,
            dpdv: (radial(p) * -width).extend(0.0),
            gradient: DVec3::Z,
            bend: DVec3::ZERO,
        }
    }

    /// All points alike.
    pub fn sample(&self, u: DVec2) -> DVec3 {
        let (inner, outer) = (self.inner_radius * self.inner_radius, self.radius * self.radius);
        let r = (inner + (outer - inner) * u.y).sqrt();
        (at_angle(u.x * self.sweep.max) * r).extend(0.0)
    }

    pub fn area(&self) -> f64 {
        0.5 * self.sweep.max * (self.radius - self.inner_radius) * (self.radius + self.inner_radius)
    }
}

/// The squared radius minus the squared distance from the axis where a line meets the plane, times `d.z` squared; in
/// double-double numbers.
#[cold]
fn exact_margin(o: DVec3, d: DVec3, radius: f64) -> f64 {
    let minor = |i: usize| TwoFloat::new_mul(o[i], d.z) - TwoFloat::new_mul(o.z, d[i]);
    let (x, y) = (minor(0), minor(1));
    let square = TwoFloat::new_mul(radius, radius) * TwoFloat::new_mul(d.z, d.z);
    f64::from(square - x * x - y * y)
}
