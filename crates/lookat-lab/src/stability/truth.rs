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
