//! Capsules around pieces of curves: most rays in the box of a piece pass its capsule.

use glam::DVec3;

use super::bezier::Points;
use crate::number::V3;
use crate::real::Real;

/// All that is within a radius of a line between two ends, relative to the origin of the world.
pub(super) struct Capsule {
    ends: [[f32; 3]; 2],
    radius: f32,
}

/// The numbers of a [`Capsule`], or of eight.
pub(super) struct CapsuleNumbers<T> {
    pub ends: [V3<T>; 2],
    pub radius: T,
}

impl Capsule {
    /// One that holds the hull of points of these `radius`.
    pub fn around(points: &Points<f64>, radius: f64) -> Self {
        let [a, b, c, d] = *points;
        let distance = |p: V3<f64>| nearest_between(a - p, d - p).length_squared().sqrt();
        let farthest = distance(b).max(distance(c));
        let [a, d] = [DVec3::from(a), DVec3::from(d)];
        let magnitude = a.abs().max(d.abs()).max_element();
        let rounding = f64::from(f32::EPSILON) * magnitude;
        let radius = (farthest + radius) * (1.0 + 1e-6) + rounding + f64::from(f32::MIN_POSITIVE);
        Capsule { ends: [a, d].map(|p| p.as_vec3().to_array()), radius: radius as f32 }
    }

    #[inline(always)]
    pub fn numbers(&self) -> CapsuleNumbers<f64> {
        let [a, b] = &self.ends;
        let end = |[x, y, z]: [f32; 3]| V3 { x: f64::from(x), y: f64::from(y), z: f64::from(z) };
        CapsuleNumbers { ends: [end(*a), end(*b)], radius: f64::from(self.radius) }
    }
}

impl<T: Real> CapsuleNumbers<T> {
    /// Whether a ray may meet it at `t_max` or before. Never false if it does, for rays that start no farther away than about 1e9 of its radii.
    #[inline(always)]
    pub fn may_meet(&self, o: V3<T>, d: V3<T>, t_max: T) -> T::Mask {
        let (radius, [a, b]) = (self.radius, self.ends);
        let length_squared = d.length_squared();
        let inverse = radius.same(1.0) / length_squared;
        let (a, b) = (a - o, b - o);
        let (a_t, b_t) = (a.dot(d) * inverse, b.dot(d) * inverse);
        // Seen along the ray.
        let nearest = nearest_between(a - d * a_t, b - d * b_t);
        let reach = radius * inverse.sqrt();
        // Not a number where the ray is out of range.
        let is_missed = (radius * radius).is_less(nearest.length_squared())
            | t_max.is_less(a_t.min(b_t) - reach)
            | (a_t.max(b_t) + reach).is_less(radius.same(0.0));
        !is_missed
    }
}

/// The point nearest to the origin of the line from one end to the other.
#[inline(always)]
fn nearest_between<T: Real>(from: V3<T>, to: V3<T>) -> V3<T> {
    let along = to - from;
    let share = -from.dot(along) / along.length_squared();
    let (zero, one) = (share.same(0.0), share.same(1.0));
    // It is not a number if the ends are one point.
    from + along * T::select(zero.is_less(share), share.min(one), zero)
}
