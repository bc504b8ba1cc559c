//! Paraboloids.

use glam::{DVec2, DVec3};
use twofloat::TwoFloat;

use super::quadric::Profile;
use super::sweep::{Sweep, radial};
use crate::circle::at_angle;
use crate::parametric::Local;
use crate::warp::{linear, linear_pdf};

/// A parabola turned about the z axis; the middle of its height is at z = 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Paraboloid {
    pub profile: Profile,
    /// The squared distance from the axis for each length above the vertex.
    width: f64,
    /// The z of the vertex.
    vertex: f64,
    /// The part that there is.
    z_min: f64,
    z_max: f64,
    /// Where v is 0, which may be below the vertex.
    v_zero: f64,
    sweep: Sweep,
    /// The area that a unit of u and of height covers, at the lowest and the highest z.
    ends: [f64; 2],
}

impl Paraboloid {
    /// The form in units of `unit`, moved down by `middle`.
    pub fn new(form: &lookat_scene::Paraboloid, middle: f64, unit: f64, sweep: Sweep) -> Self {
        let (radius, top) = (form.radius / unit, form.z_max / unit);
        let vertex = -middle / unit;
        // 4 top² (x² + y²) = 4 top radius² (z - vertex).
        let square = TwoFloat::new_mul(radius, radius);
        let b = square * (4.0 * top);
        let z_max = (form.z_max - middle) / unit;
        let mut bowl = Paraboloid {
            profile: Profile {
                w: TwoFloat::new_mul(top, top) * 4.0,
                a: TwoFloat::from(0.0),
                b,
                c: b * -vertex,
                e: square * square,
                reach_squared: (radius * radius + z_max * z_max) * (1.0 + 1e-9),
            },
            width: radius * radius / top,
            vertex,
            z_min: (form.z_min.max(0.0) - middle) / unit,
            z_max,
            v_zero: (form.z_min - middle) / unit,
            sweep,
            ends: [0.0; 2],
        };
        bowl.ends = [bowl.area_at(bowl.z_min), bowl.area_at(bowl.z_max)];
        bowl
    }

    /// Whether what is left of the surface holds a point of it.
    pub fn has(&self, p: DVec3) -> bool {
        self.z_min <= p.z && p.z <= self.z_max && self.sweep.has(p.truncate(), DVec2::X)
    }

    /// The squared distance from the axis minus that of the parabola at this height.
    pub fn value(&self, p: DVec3) -> f64 {
        p.truncate().length_squared() - self.width * (p.z - self.vertex)
    }

    /// Half the gradient of that: outward and down.
    pub fn gradient(&self, p: DVec3) -> DVec3 {
        p.truncate().extend(-0.5 * self.width)
    }

    pub fn parametric(&self, p: DVec3) -> Local {
        let angle = Sweep::angle(p.truncate(), DVec2::X);
        let height = self.z_max - self.v_zero;
        // Infinitely steep at the vertex, where pbrt-v3 divides by 0.
        let r = p.truncate().length().max(1e-10 * self.width);
        let outward = 0.5 * self.width / r;
        Local {
            uv: DVec2::new(angle / self.sweep.max, (p.z - self.v_zero) / height),
            dpdu: DVec3::new(-p.y, p.x, 0.0) * self.sweep.max,
            dpdv: (radial(p) * outward).extend(1.0) * height,
            gradient: self.gradient(p),
            bend: DVec3::new(1.0, 1.0, 0.0),
        }
    }

    /// The area at a height for each unit of u and of height.
    fn area_at(&self, z: f64) -> f64 {
        let squared = (self.width * (z - self.vertex)).max(0.0);
        self.sweep.max * (squared + 0.25 * self.width * self.width).sqrt()
    }

    pub fn sample(&self, u: DVec2) -> DVec3 {
        let z = self.z_min + (self.z_max - self.z_min) * linear(u.y, self.ends);
        let r = (self.width * (z - self.vertex)).max(0.0).sqrt();
        (at_angle(u.x * self.sweep.max) * r).extend(z)
    }

    /// The inverse of the density by area of a sample at `p`.
    pub fn stretch(&self, p: DVec3) -> f64 {
        let height = self.z_max - self.z_min;
        let share = ((p.z - self.z_min) / height).clamp(0.0, 1.0);
        self.area_at(p.z) * height / linear_pdf(share, self.ends)
    }
}
