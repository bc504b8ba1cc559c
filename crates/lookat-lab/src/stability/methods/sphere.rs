//! Ray against the sphere around the origin: the distance of the nearest hit.

use num_traits::Float;

use super::{Vector, along, dot};

/// The nearer distance that is not behind the origin.
fn nearest<T: Float>(a: T, b: T) -> Option<T> {
    let (near, far) = if a > b { (b, a) } else { (a, b) };
    [near, far].into_iter().find(|t| *t > T::zero())
}

fn two<T: Float>() -> T {
    T::one() + T::one()
}

/// The quadratic equation as in school books.
pub(in crate::stability) fn naive<T: Float>(o: Vector<T>, d: Vector<T>, radius: T) -> Option<T> {
    let (a, b, c) = (dot(d, d), two::<T>() * dot(o, d), dot(o, o) - radius * radius);
    let discriminant = b * b - two::<T>() * two::<T>() * a * c;
    if discriminant < T::zero() {
        return None;
    }
    let root = discriminant.sqrt();
    nearest((-b - root) / (two::<T>() * a), (-b + root) / (two::<T>() * a))
}

/// The quadratic equation without cancellation in its roots (Press et al., "Numerical Recipes", 5.6).
pub(in crate::stability) fn stable<T: Float>(o: Vector<T>, d: Vector<T>, radius: T) -> Option<T> {
    let (a, b, c) = (dot(d, d), two::<T>() * dot(o, d), dot(o, o) - radius * radius);
    let discriminant = b * b - two::<T>() * two::<T>() * a * c;
    if discriminant < T::zero() {
        return None;
    }
    let q = -(b + b.signum() * discriminant.sqrt()) / two();
    nearest(q / a, c / q)
}

/// pbrt-v3 (PBR 3.2.2): coefficients in `f32`, their discriminant in `f64`. Without its error bounds, which only move hits.
pub(in crate::stability) fn pbrt_v3(o: Vector<f32>, d: Vector<f32>, radius: f32) -> Option<f32> {
    let (a, b, c) = (dot(d, d), 2.0 * dot(o, d), dot(o, o) - radius * radius);
    let discriminant = f64::from(b) * f64::from(b) - 4.0 * f64::from(a) * f64::from(c);
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt() as f32;
    let q = if b < 0.0 { -0.5 * (b - root) } else { -0.5 * (b + root) };
    nearest(q / a, c / q)
}

/// Haines, Günther and Akenine-Möller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems, chapter 7,
/// 2019.
pub(in crate::stability) fn haines<T: Float>(o: Vector<T>, d: Vector<T>, radius: T) -> Option<T> {
    haines_roots(o, d, radius)?.into_iter().find(|t| *t > T::zero())
}

/// The distances of both hits by that formula, in order.
pub(super) fn haines_roots<T: Float>(o: Vector<T>, d: Vector<T>, radius: T) -> Option<[T; 2]> {
    let (a, b) = (dot(d, d), -dot(o, d));
    let closest = along(o, d, b / a);
    let squared = radius * radius - dot(closest, closest);
    if squared < T::zero() {
        return None;
    }
    let root = (a * squared).sqrt();
    let q = if b < T::zero() { b - root } else { b + root };
    let (x, y) = ((dot(o, o) - radius * radius) / q, q / a);
    Some(if x > y { [y, x] } else { [x, y] })
}

/// pbrt-v4 (PBR4 6.2.2): the discriminant of Haines et al. in intervals of `f32`; a hit counts if all of its interval does.
pub(in crate::stability) fn pbrt_v4(o: Vector<f32>, d: Vector<f32>, radius: f32) -> Option<f32> {
    // What the transformation to object space may have done to them.
    let (o, d) = (o.map(Interval::around), d.map(Interval::around));
    let dot = |a: [Interval; 3], b: [Interval; 3]| a[0].mul(b[0]).add(a[1].mul(b[1])).add(a[2].mul(b[2]));
    let square = |v: [Interval; 3]| v[0].square().add(v[1].square()).add(v[2].square());
    let radius = Interval(radius, radius);
    let (a, b, c) = (square(d), dot(o, d).scale(2.0), square(o).sub(radius.square()));
    let k = b.div(a.scale(2.0));
    let closest: [Interval; 3] = std::array::from_fn(|i| o[i].sub(k.mul(d[i])));
    let distance = square(closest).sqrt();
    let discriminant = a.scale(4.0).mul(radius.add(distance)).mul(radius.sub(distance));
    if discriminant.0 < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let q = if b.middle() < 0.0 { b.sub(root).scale(-0.5) } else { b.add(root).scale(-0.5) };
    let (near, far) = (q.div(a), c.div(q));
    let (near, far) = if near.0 > far.0 { (far, near) } else { (near, far) };
    [near, far].into_iter().find(|t| t.0 > 0.0).map(Interval::middle)
}

/// Lower and upper bound.
#[derive(Clone, Copy)]
struct Interval(f32, f32);

impl Interval {
    fn around(x: f32) -> Interval {
        let error = 3.0 * (f32::EPSILON / 2.0) * x.abs();
        if error == 0.0 { Interval(x, x) } else { Interval((x - error).next_down(), (x + error).next_up()) }
    }

    fn outward(low: f32, high: f32) -> Interval {
        Interval(low.next_down(), high.next_up())
    }

    fn of(values: [f32; 4]) -> Interval {
        let low = values.into_iter().fold(f32::INFINITY, f32::min);
        Interval::outward(low, values.into_iter().fold(f32::NEG_INFINITY, f32::max))
    }

    fn add(self, other: Interval) -> Interval {
        Interval::outward(self.0 + other.0, self.1 + other.1)
    }

    fn sub(self, other: Interval) -> Interval {
        Interval::outward(self.0 - other.1, self.1 - other.0)
    }

    fn mul(self, other: Interval) -> Interval {
        Interval::of([self.0 * other.0, self.0 * other.1, self.1 * other.0, self.1 * other.1])
    }

    fn div(self, other: Interval) -> Interval {
        if other.0 <= 0.0 && other.1 >= 0.0 {
            return Interval(f32::NEG_INFINITY, f32::INFINITY);
        }
        Interval::of([self.0 / other.0, self.0 / other.1, self.1 / other.0, self.1 / other.1])
    }

    fn square(self) -> Interval {
        let (a, b) = (self.0.abs(), self.1.abs());
        let low = if self.0 <= 0.0 && self.1 >= 0.0 { 0.0 } else { (a.min(b) * a.min(b)).next_down() };
        Interval(low, (a.max(b) * a.max(b)).next_up())
    }

    fn scale(self, factor: f32) -> Interval {
        let (a, b) = (self.0 * factor, self.1 * factor);
        Interval::outward(a.min(b), a.max(b))
    }

    fn sqrt(self) -> Interval {
        Interval(self.0.max(0.0).sqrt().next_down().max(0.0), self.1.max(0.0).sqrt().next_up())
    }

    fn middle(self) -> f32 {
        (self.0 + self.1) / 2.0
    }
}
