//! Lines against quadrics of revolution.

use glam::DVec3;
use twofloat::TwoFloat;

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
    /// And to the middle between them.
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

/// What may be left of the terms of the discriminant where digits are lost. With less it is computed in double-double
/// numbers, and so are the other terms.
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

    /// The same in double-double numbers.
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
