//! A segment turned about the z axis: cylinders, cones and hyperboloids.

use glam::{DVec2, DVec3};
use twofloat::TwoFloat;

use super::quadric::Profile;
use super::sweep::Sweep;
use crate::circle::at_angle;
use crate::parametric::Local;
use crate::warp::{linear, linear_pdf};

/// The segment; the middle of its height is at z = 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct TurnedSegment {
    pub profile: Profile,
    /// Where v is 0.
    p1: DVec3,
    /// From there to where v is 1.
    along: DVec3,
    /// Where the segment's line meets z = 0, and how far it goes sideways for each length upward.
    middle: DVec2,
    slope: DVec2,
    z_min: f64,
    z_max: f64,
    sweep: Sweep,
    /// The area that a unit of u and v covers, where v is 0 and 1.
    ends: [f64; 2],
}

impl TurnedSegment {
    pub fn new([p1, p2]: [DVec3; 2], sweep: Sweep) -> Self {
        let along = p2 - p1;
        let slope = along.truncate() / along.z;
        let mut segment = TurnedSegment {
            profile: profile(p1, p2),
            p1,
            along,
            // From the end that is closer to the axis, which may be on it.
            middle: if p1.truncate().length() < p2.truncate().length() {
                p1.truncate() - slope * p1.z
            } else {
                p2.truncate() - slope * p2.z
            },
            slope,
            z_min: p1.z.min(p2.z),
            z_max: p1.z.max(p2.z),
            sweep,
            ends: [0.0; 2],
        };
        segment.ends = [segment.area_at(0.0), segment.area_at(1.0)];
        segment
    }

    /// The point of the segment's line at a height, without z.
    fn start(&self, z: f64) -> DVec2 {
        self.middle + self.slope * z
    }

    /// Whether what is left of the surface holds a point of it.
    pub fn has(&self, p: DVec3) -> bool {
        self.z_min <= p.z && p.z <= self.z_max && self.sweep.has(p.truncate(), self.start(p.z))
    }

    /// The squared distance from the axis minus that of the line at this height; its sign is that of the side of pbrt-v3's
    /// normal.
    pub fn value(&self, p: DVec3) -> f64 {
        let (r, at) = (p.truncate().length(), self.start(p.z).length());
        (r - at) * (r + at) * 1.0_f64.copysign(self.along.z)
    }

    /// Half the gradient of that.
    pub fn gradient(&self, p: DVec3) -> DVec3 {
        let outward = p.truncate().extend(-self.start(p.z).dot(self.slope));
        outward * 1.0_f64.copysign(self.along.z)
    }

    pub fn parametric(&self, p: DVec3) -> Local {
        let angle = Sweep::angle(p.truncate(), self.start(p.z));
        let side = 1.0_f64.copysign(self.along.z);
        Local {
            uv: DVec2::new(angle / self.sweep.max, (p.z - self.p1.z) / self.along.z),
            dpdu: DVec3::new(-p.y, p.x, 0.0) * self.sweep.max,
            dpdv: at_angle(angle).rotate(self.along.truncate()).extend(self.along.z),
            gradient: self.gradient(p),
            bend: DVec3::new(side, side, -side * self.slope.length_squared()),
        }
    }

    /// The length of dpdu x dpdv.
    fn area_at(&self, v: f64) -> f64 {
        let at = self.p1.truncate() + self.along.truncate() * v;
        self.sweep.max * libm::hypot(at.length() * self.along.z, at.dot(self.along.truncate()))
    }

    /// Evenly on cylinders and cones, about so on others.
    pub fn sample(&self, u: DVec2) -> DVec3 {
        let p = self.p1 + self.along * linear(u.y, self.ends);
        at_angle(u.x * self.sweep.max).rotate(p.truncate()).extend(p.z)
    }

    /// The inverse of the density by area of a sample at `p`.
    pub fn stretch(&self, p: DVec3) -> f64 {
        let v = ((p.z - self.p1.z) / self.along.z).clamp(0.0, 1.0);
        self.area_at(v) / linear_pdf(v, self.ends)
    }
}

/// w (x² + y²) = |h m + z l|², where l is the way from one end to the other without its height h, and m the middle.
fn profile(p1: DVec3, p2: DVec3) -> Profile {
    let way = [0, 1, 2].map(|i| TwoFloat::new_sub(p2[i], p1[i]));
    // Where the line is at z = 0, times h.
    let middle = [0, 1].map(|i| way[2] * p1[i] - way[i] * p1.z);
    let dot = |a: [TwoFloat; 2], b: [TwoFloat; 2]| a[0] * b[0] + a[1] * b[1];
    let level = [way[0], way[1]];
    // m x l, which is the same for all points of the line.
    let twist = TwoFloat::new_mul(p1.x, p2.y) - TwoFloat::new_mul(p1.y, p2.x);
    Profile {
        w: way[2] * way[2],
        a: dot(level, level),
        b: dot(middle, level) * 2.0,
        c: dot(middle, middle),
        e: -(twist * twist),
        reach_squared: p1.length_squared().max(p2.length_squared()) * (1.0 + 1e-9),
    }
}
