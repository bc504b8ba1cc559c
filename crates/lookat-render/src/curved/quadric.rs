//! Rays against quadrics of revolution other than spheres: disks, paraboloids, cylinders, cones and hyperboloids, in object space.

use glam::{DVec2, DVec3};
use twofloat::TwoFloat;

use super::part::{Part, Seam, Sweep};
use super::profile::{Crossings, Profile};
use crate::number::V3;
use crate::parametric::Local;
use crate::real::Real;
use crate::warp::at_angle;
use crate::warp::{linear, linear_pdf};

/// A disk or ring in the plane z = 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Disk {
    radius: f64,
    inner_radius: f64,
    pub part: Part,
}

impl Disk {
    pub fn new(radius: f64, inner_radius: f64, sweep: Sweep) -> Self {
        Disk { radius, inner_radius, part: Part { sweep, ..Part::WHOLE } }
    }

    /// The radius, if it is whole.
    pub fn whole(&self) -> Option<f64> {
        (self.inner_radius == 0.0 && self.part.sweep.is_whole()).then_some(self.radius)
    }

    /// The outer and the inner radius.
    pub fn numbers(&self) -> [f64; 2] {
        [self.radius, self.inner_radius]
    }

    /// Where a line meets it: once, and never again if it leaves it. One in its plane does not.
    pub fn meet(&self, o: DVec3, d: DVec3) -> Option<Crossings> {
        let t = -o.z / d.z;
        if t.is_nan() || t <= 0.0 {
            return None;
        }
        // The point at t, without what rounding of t and of far coordinates does to it.
        let near = DVec3::from([0, 1, 2].map(|i| (TwoFloat::new_mul(d[i], t) + o[i]).hi()));
        let offset = -(near.z / d.z);
        let r = (near + d * offset).truncate().length();
        let reaches = |radius: f64| {
            let is_clear = (r - radius).abs() > 1e-14 * radius;
            if is_clear { r > radius } else { exact_margin(o, d, radius) < 0.0 }
        };
        let has = !reaches(self.radius) && (self.inner_radius == 0.0 || !self.is_in_hole(r, o, d));
        has.then_some(Crossings {
            d,
            near,
            offsets: [offset; 2],
            t: [t, f64::NAN],
            middle: f64::NEG_INFINITY,
        })
    }

    /// True if a line that meets the plane at a distance of about `r` from the axis goes through the hole.
    fn is_in_hole(&self, r: f64, o: DVec3, d: DVec3) -> bool {
        if (r - self.inner_radius).abs() > 1e-14 * self.inner_radius {
            r < self.inner_radius
        } else {
            exact_margin(o, d, self.inner_radius) > 0.0
        }
    }

    pub fn parametric(&self, p: DVec3) -> Local {
        let angle = Sweep::angle(p.truncate(), DVec2::X);
        let width = self.radius - self.inner_radius;
        Local {
            uv: DVec2::new(angle / self.part.sweep.max, (self.radius - p.truncate().length()) / width),
            dpdu: DVec3::new(-p.y, p.x, 0.0) * self.part.sweep.max,
            dpdv: (radial(p) * -width).extend(0.0),
            gradient: DVec3::Z,
            bend: DVec3::ZERO,
        }
    }

    /// All points alike.
    pub fn sample(&self, u: DVec2) -> DVec3 {
        let (inner, outer) = (self.inner_radius * self.inner_radius, self.radius * self.radius);
        let r = (inner + (outer - inner) * u.y).sqrt();
        (at_angle(u.x * self.part.sweep.max) * r).extend(0.0)
    }

    pub fn area(&self) -> f64 {
        0.5 * self.part.sweep.max * (self.radius - self.inner_radius) * (self.radius + self.inner_radius)
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

/// A parabola turned about the z axis; the middle of its height is at z = 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Paraboloid {
    pub profile: Profile,
    /// The squared distance from the axis for each length above the vertex.
    width: f64,
    /// The z of the vertex.
    vertex: f64,
    pub part: Part,
    /// The height at which v is 0, which may be below the vertex.
    v_zero: f64,
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
            part: Part { z_min: (form.z_min.max(0.0) - middle) / unit, z_max, seam: Seam::ALONG_X, sweep },
            v_zero: (form.z_min - middle) / unit,
            ends: [0.0; 2],
        };
        bowl.ends = [bowl.area_at(bowl.part.z_min), bowl.area_at(bowl.part.z_max)];
        bowl
    }

    /// The squared distance from the axis minus that of the parabola at this height.
    #[inline(always)]
    pub fn value<T: Real>(&self, p: V3<T>) -> T {
        p.x * p.x + p.y * p.y - (p.z - self.vertex) * self.width
    }

    /// Half the gradient of that: outward and down.
    #[inline(always)]
    pub fn gradient<T: Real>(&self, p: V3<T>) -> V3<T> {
        V3 { z: p.z.same(-0.5 * self.width), ..p }
    }

    pub fn parametric(&self, p: DVec3) -> Local {
        let angle = Sweep::angle(p.truncate(), DVec2::X);
        let height = self.part.z_max - self.v_zero;
        // Infinitely steep at the vertex, where pbrt-v3 divides by 0.
        let r = p.truncate().length().max(1e-10 * self.width);
        let outward = 0.5 * self.width / r;
        Local {
            uv: DVec2::new(angle / self.part.sweep.max, (p.z - self.v_zero) / height),
            dpdu: DVec3::new(-p.y, p.x, 0.0) * self.part.sweep.max,
            dpdv: (radial(p) * outward).extend(1.0) * height,
            gradient: self.gradient(V3::from(p)).into(),
            bend: DVec3::new(1.0, 1.0, 0.0),
        }
    }

    /// The area at a height for each unit of u and of height.
    fn area_at(&self, z: f64) -> f64 {
        let squared = (self.width * (z - self.vertex)).max(0.0);
        self.part.sweep.max * (squared + 0.25 * self.width * self.width).sqrt()
    }

    pub fn sample(&self, u: DVec2) -> DVec3 {
        let Part { z_min, z_max, sweep, .. } = self.part;
        let z = z_min + (z_max - z_min) * linear(u.y, self.ends);
        let r = (self.width * (z - self.vertex)).max(0.0).sqrt();
        (at_angle(u.x * sweep.max) * r).extend(z)
    }

    /// The inverse of the density by area of a sample at a height.
    pub fn stretch(&self, z: f64) -> f64 {
        let Part { z_min, z_max, .. } = self.part;
        let height = z_max - z_min;
        let share = ((z - z_min) / height).clamp(0.0, 1.0);
        self.area_at(z) * height / linear_pdf(share, self.ends)
    }
}

/// The segment; the middle of its height is at z = 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct TurnedSegment {
    pub profile: Profile,
    /// The end of the segment at which v is 0.
    p1: DVec3,
    /// The vector from there to the end at which v is 1.
    along: DVec3,
    pub part: Part,
    /// The area that a unit of u and v covers, where v is 0 and 1.
    ends: [f64; 2],
}

impl TurnedSegment {
    pub fn new([p1, p2]: [DVec3; 2], sweep: Sweep) -> Self {
        let along = p2 - p1;
        let slope = along.truncate() / along.z;
        // It may be on the axis.
        let end = if p1.truncate().length() < p2.truncate().length() { p1 } else { p2 };
        let mut segment = TurnedSegment {
            profile: profile(p1, p2),
            p1,
            along,
            part: Part {
                z_min: p1.z.min(p2.z),
                z_max: p1.z.max(p2.z),
                seam: Seam { middle: end.truncate() - slope * end.z, slope },
                sweep,
            },
            ends: [0.0; 2],
        };
        segment.ends = [segment.area_at(0.0), segment.area_at(1.0)];
        segment
    }

    /// The squared distance from the axis minus that of the line at this height; its sign is that of the side of pbrt-v3's
    /// normal.
    #[inline(always)]
    pub fn value<T: Real>(&self, p: V3<T>) -> T {
        let [x, y] = self.seam_at(p.z);
        let (r, at) = ((p.x * p.x + p.y * p.y).sqrt(), (x * x + y * y).sqrt());
        (r - at) * (r + at) * 1.0_f64.copysign(self.along.z)
    }

    /// Half the gradient of that.
    #[inline(always)]
    pub fn gradient<T: Real>(&self, p: V3<T>) -> V3<T> {
        let ([x, y], slope) = (self.seam_at(p.z), self.part.seam.slope);
        let side = 1.0_f64.copysign(self.along.z);
        V3 { x: p.x * side, y: p.y * side, z: -(x * slope.x + y * slope.y) * side }
    }

    /// As [`Seam::at`].
    #[inline(always)]
    fn seam_at<T: Real>(&self, z: T) -> [T; 2] {
        let Seam { middle, slope } = self.part.seam;
        [z * slope.x + middle.x, z * slope.y + middle.y]
    }

    pub fn parametric(&self, p: DVec3) -> Local {
        let Part { seam, sweep, .. } = self.part;
        let angle = Sweep::angle(p.truncate(), seam.at(p.z));
        let side = 1.0_f64.copysign(self.along.z);
        Local {
            uv: DVec2::new(angle / sweep.max, (p.z - self.p1.z) / self.along.z),
            dpdu: DVec3::new(-p.y, p.x, 0.0) * sweep.max,
            dpdv: at_angle(angle).rotate(self.along.truncate()).extend(self.along.z),
            gradient: self.gradient(V3::from(p)).into(),
            bend: DVec3::new(side, side, -side * seam.slope.length_squared()),
        }
    }

    /// The length of dpdu x dpdv.
    fn area_at(&self, v: f64) -> f64 {
        let at = self.p1.truncate() + self.along.truncate() * v;
        self.part.sweep.max * libm::hypot(at.length() * self.along.z, at.dot(self.along.truncate()))
    }

    /// Evenly on cylinders and cones, about so on others.
    pub fn sample(&self, u: DVec2) -> DVec3 {
        let p = self.p1 + self.along * linear(u.y, self.ends);
        at_angle(u.x * self.part.sweep.max).rotate(p.truncate()).extend(p.z)
    }

    /// The inverse of the density by area of a sample at a height.
    pub fn stretch(&self, z: f64) -> f64 {
        let v = ((z - self.p1.z) / self.along.z).clamp(0.0, 1.0);
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

/// The direction away from the axis at `p`, of length one; any on the axis.
pub(super) fn radial(p: DVec3) -> DVec2 {
    p.truncate().normalize_or(DVec2::X)
}
