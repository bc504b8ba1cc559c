//! Vectors of double-double numbers (106 bits), for results that are exact to `f64`.

use glam::DVec3;
use twofloat::TwoFloat;

/// A vector.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wide(pub [TwoFloat; 3]);

impl Wide {
    pub fn new(v: DVec3) -> Wide {
        Wide(v.to_array().map(TwoFloat::from))
    }

    pub fn dot(self, other: Wide) -> TwoFloat {
        self.0[0] * other.0[0] + self.0[1] * other.0[1] + self.0[2] * other.0[2]
    }

    pub fn cross(self, other: Wide) -> Wide {
        let ([ax, ay, az], [bx, by, bz]) = (self.0, other.0);
        Wide([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
    }

    pub fn minus(self, other: Wide) -> Wide {
        Wide(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }

    pub fn plus(self, other: Wide) -> Wide {
        Wide(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }

    pub fn times(self, factor: TwoFloat) -> Wide {
        Wide(self.0.map(|x| x * factor))
    }

    pub fn length(self) -> TwoFloat {
        self.dot(self).sqrt()
    }

    /// Scales the largest component to 1 first, so that squares neither overflow nor vanish.
    pub fn unit(self) -> Wide {
        let largest = self.0.iter().fold(0.0_f64, |max, x| max.max(x.hi().abs()));
        let v = Wide(self.0.map(|x| x / largest));
        v.times(quotient(1.0.into(), v.length()))
    }
}

/// `a / b`. The division of [`TwoFloat`] is no more exact than that of `f64`.
pub(super) fn quotient(a: TwoFloat, b: TwoFloat) -> TwoFloat {
    let first = a.hi() / b.hi();
    let rest = a - b * first;
    let second = rest.hi() / b.hi();
    let rest = rest - b * second;
    TwoFloat::new_add(first, second) + rest.hi() / b.hi()
}

/// The intersection of a line with the plane of a triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    /// Distance in lengths of the direction.
    pub t: f64,
    /// The least barycentric coordinate: positive inside the triangle.
    pub inside: f64,
}

/// The intersection of a line with the plane of a triangle. `None` for a line in the plane.
///
/// Barycentric coordinates are the volumes between the line and the edges, as in Plücker coordinates.
pub(super) fn crossing(o: DVec3, d: DVec3, triangle: [DVec3; 3]) -> Option<Crossing> {
    let (o, d) = (Wide::new(o), Wide::new(d));
    let [a, b, c] = triangle.map(|corner| Wide::new(corner).minus(o));
    let volumes = [d.dot(c.cross(b)), d.dot(a.cross(c)), d.dot(b.cross(a))];
    let sum = volumes[0] + volumes[1] + volumes[2];
    if sum == TwoFloat::from(0.0) {
        return None;
    }
    let weights = volumes.map(|volume| f64::from(quotient(volume, sum)));
    let normal = c.minus(a).cross(b.minus(a));
    let t = f64::from(quotient(a.dot(normal), d.dot(normal)));
    Some(Crossing { t, inside: weights.into_iter().fold(f64::INFINITY, f64::min) })
}

/// The cosine between a direction and the normal of a triangle.
pub(super) fn cosine(d: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    (b - a).cross(c - a).normalize_or_zero().dot(d).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotients_have_twice_the_digits() {
        for (a, b) in [(1.0, 3.0), (4.1e13, 1.1), (-0.7, 1e-9)] {
            let (a, b) = (TwoFloat::new_add(a, 1e-17 * a), TwoFloat::from(b));
            let error = quotient(a, b) * b - a;
            assert!((f64::from(error) / f64::from(a)).abs() < 1e-30, "{error:?}");
        }
    }

    #[test]
    fn a_crossing_is_at_its_target() {
        let triangle =
            [DVec3::new(1.0, 0.25, 0.5), DVec3::new(-0.75, 1.0, 0.25), DVec3::new(-0.5, -1.0, -0.5)];
        let o = DVec3::new(0.5, -3.0, 2.0);
        for weights in [[0.25, 0.25, 0.5], [0.5, 0.0, 0.5], [0.75, 0.5, -0.25]] {
            let target: DVec3 = (0..3).map(|i| triangle[i] * weights[i]).sum();
            let found = crossing(o, (target - o) * 0.5, triangle).unwrap();
            assert_eq!(found.t, 2.0);
            assert_eq!(found.inside, weights.into_iter().fold(1.0, f64::min));
        }
        assert!(crossing(triangle[0], triangle[1] - triangle[2], triangle).is_none());
    }

    #[test]
    fn digits_suffice_far_away() {
        let triangle =
            [DVec3::new(-0.5, -0.5, 1e9), DVec3::new(0.5, -0.5, 1e9), DVec3::new(0.0, 0.5, 1e9 + 1.0)];
        let found = crossing(DVec3::ZERO, DVec3::new(0.125, 0.0, 1e9 + 0.5), triangle).unwrap();
        assert_eq!(found.t, 1.0);
        assert!((found.inside - 0.125).abs() < 1e-15, "{}", found.inside);
    }
}
