//! Vectors of double-double numbers: 106 bits.

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
}

/// `a / b`. The division of [`TwoFloat`] is no more exact than that of `f64`.
pub(super) fn quotient(a: TwoFloat, b: TwoFloat) -> TwoFloat {
    let first = a.hi() / b.hi();
    let rest = a - b * first;
    let second = rest.hi() / b.hi();
    let rest = rest - b * second;
    TwoFloat::new_add(first, second) + rest.hi() / b.hi()
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
}
