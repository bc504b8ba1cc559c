//! Rays against quadrics of revolution other than spheres: disks, paraboloids, cylinders, cones and hyperboloids, in object space.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use twofloat::TwoFloat;

use crate::parametric::Local;
use crate::warp::at_angle;
use crate::warp::{linear, linear_pdf};

/// The surface w (x² + y²) = a z² + b z + c, not cut.
#[derive(Debug, Clone, Copy)]
pub(super) struct Profile {
    pub w: TwoFloat,
    pub a: TwoFloat,
    pub b: TwoFloat,
    pub c: TwoFloat,
    /// (b² / 4 - a c) / w, which loses its digits if it is computed so.
    pub e: TwoFloat,
    /// Nothing of the form is farther from the origin, squared.
    pub reach_squared: f64,
}

/// The two places where a line meets a quadric.
pub(super) struct Crossings {
    d: DVec3,
    /// A distance along the line, in lengths of `d`, and the point there, which is near the form.
    k: f64,
    near: DVec3,
    /// From there to both places, in order. Infinite where there is only one.
    offsets: [f64; 2],
    /// The offset to the middle between both points.
    middle: f64,
}

/// Half the discriminant and the other terms of the quadratic equation alpha t² + 2 beta t + gamma = 0.
struct Equation {
    alpha: f64,
    beta: f64,
    gamma: f64,
    /// (beta² - alpha gamma) / w.
    margin: f64,
}

/// The least discriminant relative to its terms. Below it too many digits are lost, and all terms are computed in
/// double-double arithmetic.
const DOUBT: f64 = 1e-4;

impl Profile {
    /// `None` where the line misses, or lies in the surface.
    pub fn meet(&self, o: DVec3, d: DVec3) -> Option<Crossings> {
        let dd = d.length_squared();
        let k = -o.dot(d) / dd;
        // Exact enough at any distance: the square of the rounding error of `f64`.
        let near_wide = [0, 1, 2].map(|i| TwoFloat::new_mul(d[i], k) + o[i]);
        let near = DVec3::from(near_wide.map(|x| x.hi()));
        let beside = near.dot(d);
        if near.length_squared() - beside * beside / dd > self.reach_squared {
            return None;
        }
        let equation = self.plain(near, d).unwrap_or_else(|| self.wide(near_wide, d));
        let Equation { alpha, beta, gamma, margin } = equation;
        if margin < 0.0 {
            return None;
        }
        let root = (self.w.hi() * margin).sqrt();
        let q = -(beta + root.copysign(beta));
        let offsets = match (q == 0.0, alpha == 0.0) {
            (true, true) => return None,
            // It touches just here.
            (true, false) => [0.0; 2],
            _ => [q / alpha, gamma / q],
        };
        let offsets = [offsets[0].min(offsets[1]), offsets[0].max(offsets[1])];
        Some(Crossings { d, k, near, offsets, middle: -beta / alpha })
    }

    /// In `f64`, where that is safe. The discriminant comes from the moment of the line, n x d, whose products do not
    /// grow with the distance along it.
    fn plain(&self, n: DVec3, d: DVec3) -> Option<Equation> {
        let [w, a, b, c, e] = [self.w, self.a, self.b, self.c, self.e].map(|x| x.hi());
        let minor =
            |i: usize, j: usize| (n[i] * d[j] - n[j] * d[i], (n[i] * d[j]).abs() + (n[j] * d[i]).abs());
        let ((xy, xy_size), (xz, xz_size), (yz, yz_size)) = (minor(0, 1), minor(0, 2), minor(1, 2));
        let across = d.x * d.x + d.y * d.y;
        let along = d.z * d.z;
        let margin =
            a * (xz * xz + yz * yz) - w * xy * xy - b * (d.x * xz + d.y * yz) + c * across + e * along;
        let size = a * (xz_size * xz_size + yz_size * yz_size)
            + w * xy_size * xy_size
            + (b * d.x).abs() * xz_size
            + (b * d.y).abs() * yz_size
            + c.abs() * across
            + e.abs() * along;
        let equation = Equation {
            alpha: w * across - a * along,
            beta: w * (n.x * d.x + n.y * d.y) - (a * n.z + 0.5 * b) * d.z,
            gamma: w * (n.x * n.x + n.y * n.y) - (a * n.z + b) * n.z - c,
            margin,
        };
        (margin.abs() > DOUBT * size).then_some(equation)
    }

    /// The equation in double-double arithmetic.
    #[cold]
    fn wide(&self, n: [TwoFloat; 3], d: DVec3) -> Equation {
        let Profile { w, a, b, c, e, .. } = *self;
        let minor = |i: usize, j: usize| n[i] * d[j] - n[j] * d[i];
        let (xy, xz, yz) = (minor(0, 1), minor(0, 2), minor(1, 2));
        let across = TwoFloat::new_mul(d.x, d.x) + TwoFloat::new_mul(d.y, d.y);
        let along = TwoFloat::new_mul(d.z, d.z);
        let margin =
            a * (xz * xz + yz * yz) - w * (xy * xy) - b * (xz * d.x + yz * d.y) + c * across + e * along;
        Equation {
            alpha: (w * across - a * along).hi(),
            beta: (w * (n[0] * d.x + n[1] * d.y) - (a * n[2] + b * 0.5) * d.z).hi(),
            gamma: (w * (n[0] * n[0] + n[1] * n[1]) - (a * n[2] + b) * n[2] - c).hi(),
            margin: margin.hi(),
        }
    }
}

impl Crossings {
    /// The distance of the middle between both places.
    pub fn middle(&self) -> f64 {
        self.k + self.middle
    }

    /// The distance of the first place that `has` holds, more than 0 and at most `t_max`. The one at which the ray starts
    /// does not count if it is `leaving`.
    pub fn first(&self, t_max: f64, leaving: bool, has: impl Fn(DVec3) -> bool) -> Option<f64> {
        if leaving && self.middle() <= 0.0 {
            return None;
        }
        self.offsets[usize::from(leaving)..].iter().find_map(|offset| {
            let t = self.k + offset;
            (t > 0.0 && t <= t_max && has(self.near + self.d * *offset)).then_some(t)
        })
    }
}

/// Brings a point that is near a surface onto it along the gradient, by Newton's method. `f` gives the value of the
/// surface's function and half its gradient.
pub(super) fn project(p: DVec3, f: impl Fn(DVec3) -> (f64, DVec3)) -> DVec3 {
    let step = |p: DVec3| {
        let (value, gradient) = f(p);
        let moved = p - gradient * (0.5 * value / gradient.length_squared());
        if moved.is_finite() { moved } else { p }
    };
    step(step(p))
}

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
        let reaches = |radius: f64| {
            let is_clear = (r - radius).abs() > 1e-14 * radius;
            if is_clear { r > radius } else { exact_margin(o, d, radius) < 0.0 }
        };
        let has = !reaches(self.radius) && (self.inner_radius == 0.0 || !self.is_in_hole(r, o, d));
        (has && self.sweep.has(p, DVec2::X)).then_some(t)
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
    /// The height at which v is 0, which may be below the vertex.
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

    /// True if what is left of the surface holds a point of it.
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

/// The segment; the middle of its height is at z = 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct TurnedSegment {
    pub profile: Profile,
    /// The end of the segment at which v is 0.
    p1: DVec3,
    /// The vector from there to the end at which v is 1.
    along: DVec3,
    /// The intersection of the line of the segment with z = 0, and its sideways step per unit of height.
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

    /// True if what is left of the surface holds a point of it.
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

/// The angle by which a profile sweeps around the axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sweep {
    /// In radians, more than 0 and at most 2 pi.
    pub max: f64,
}

impl Sweep {
    pub fn new(max: f64) -> Self {
        Sweep { max }
    }

    pub fn is_whole(self) -> bool {
        self.max >= TAU
    }

    /// The angle from `start` to `p`, from 0 to 2 pi.
    pub fn angle(p: DVec2, start: DVec2) -> f64 {
        let angle = libm::atan2(start.perp_dot(p), start.dot(p));
        if angle < 0.0 { angle + TAU } else { angle }
    }

    /// True if it reaches `p`, of any distance from the axis.
    pub fn has(self, p: DVec2, start: DVec2) -> bool {
        self.is_whole() || Sweep::angle(p, start) <= self.max
    }
}

/// The direction away from the axis at `p`, of length one; any on the axis.
pub(super) fn radial(p: DVec3) -> DVec2 {
    p.truncate().normalize_or(DVec2::X)
}
