//! Lines against curved forms of revolution.

use glam::DVec3;
use twofloat::TwoFloat;

use crate::number::V3;
use crate::real::Real;

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

/// The numbers of a [`Profile`], for tests side by side.
pub(super) type ProfileNumbers<T> = [T; 6];

/// The two places where a line meets a form, or where eight lines do.
pub(super) struct Crossings<V = DVec3, N = f64> {
    pub d: V,
    /// A point of the line, which is near the form.
    pub near: V,
    /// From there to both places, in order, in lengths of `d`. Infinite where there is only one.
    pub offsets: [N; 2],
    /// The distances along the line to both places.
    pub t: [N; 2],
    /// The distance of the middle between both.
    pub middle: N,
}

/// Half the discriminant and the other terms of the quadratic equation alpha t² + 2 beta t + gamma = 0.
pub(super) struct Equation<T = f64> {
    pub alpha: T,
    pub beta: T,
    pub gamma: T,
    /// (beta² - alpha gamma) / w.
    pub margin: T,
}

/// The least discriminant relative to its terms. Below it too many digits are lost, and all terms are computed in
/// double-double arithmetic.
pub(super) const DOUBT: f64 = 1e-4;

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
        let (plain, size) = Equation::new(&self.numbers(), near.into(), d.into());
        let is_safe = plain.margin.abs() > DOUBT * size;
        let Equation { alpha, beta, gamma, margin } = if is_safe { plain } else { self.wide(near_wide, d) };
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
        Some(Crossings { d, near, offsets, t: offsets.map(|x| k + x), middle: k + -beta / alpha })
    }

    pub fn numbers(&self) -> ProfileNumbers<f64> {
        [self.w.hi(), self.a.hi(), self.b.hi(), self.c.hi(), self.e.hi(), self.reach_squared]
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

impl<T: Real> Equation<T> {
    /// In `f64`, which is safe if the margin is large in proportion to the size of its terms, which comes second. The discriminant comes
    /// from the moment of the line, n x d, whose products do not grow with the distance along it.
    #[inline(always)]
    pub fn new([w, a, b, c, e, _]: &ProfileNumbers<T>, n: V3<T>, d: V3<T>) -> (Self, T) {
        let (w, a, b, c, e) = (*w, *a, *b, *c, *e);
        let (xy, xy_size) = minor([n.x, n.y], [d.x, d.y]);
        let (xz, xz_size) = minor([n.x, n.z], [d.x, d.z]);
        let (yz, yz_size) = minor([n.y, n.z], [d.y, d.z]);
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
            beta: w * (n.x * d.x + n.y * d.y) - (a * n.z + b * 0.5) * d.z,
            gamma: w * (n.x * n.x + n.y * n.y) - (a * n.z + b) * n.z - c,
            margin,
        };
        (equation, size)
    }
}

/// The determinant of two vectors, and the size of its terms.
#[inline(always)]
fn minor<T: Real>(n: [T; 2], d: [T; 2]) -> (T, T) {
    let (a, b) = (n[0] * d[1], n[1] * d[0]);
    (a - b, a.abs() + b.abs())
}

impl Crossings {
    /// The distance of the first place that `has` holds, more than 0 and at most `t_max`. The one at which the ray starts
    /// does not count if it is `leaving`.
    #[inline(always)]
    pub fn first(&self, t_max: f64, leaving: bool, has: impl Fn(DVec3) -> bool) -> Option<f64> {
        if leaving && self.middle <= 0.0 {
            return None;
        }
        let Crossings { d, near, .. } = *self;
        let places = || self.t.into_iter().zip(self.offsets).skip(usize::from(leaving));
        let counts = |&(t, offset): &(f64, f64)| t > 0.0 && t <= t_max && has(near + d * offset);
        places().find(counts).map(|(t, _)| t)
    }
}

/// Brings points that are near a surface onto it along the gradient, by Newton's method. `f` gives the value of the
/// surface's function and half its gradient.
#[inline(always)]
pub(super) fn project<T: Real>(p: V3<T>, f: impl Fn(V3<T>) -> (T, V3<T>)) -> V3<T> {
    let first = newton(p, f(p));
    newton(first, f(first))
}

#[inline(always)]
fn newton<T: Real>(p: V3<T>, (value, gradient): (T, V3<T>)) -> V3<T> {
    T::if_finite(p - gradient * (value * 0.5 / gradient.length_squared()), p)
}
