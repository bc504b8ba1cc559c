//! Directions and frames around them.

pub(crate) mod lanes;

use glam::DVec3;

/// The direction, or the opposite one.
pub(crate) fn flipped(n: DVec3, flip: bool) -> DVec3 {
    if flip { -n } else { n }
}

/// An orthonormal frame with `n`, of length one, as its z axis (Duff et al., "Building an Orthonormal Basis,
/// Revisited", JCGT 6(1), 2017).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    pub x: DVec3,
    pub y: DVec3,
    pub z: DVec3,
}

impl Frame {
    pub fn from_z(z: DVec3) -> Self {
        let sign = 1.0_f64.copysign(z.z);
        let a = -1.0 / (sign + z.z);
        let b = z.x * z.y * a;
        let x = DVec3::new(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x);
        let y = DVec3::new(b, sign + z.y * z.y * a, -z.y);
        Frame { x, y, z }
    }

    pub fn to_world(self, v: DVec3) -> DVec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    #[cfg(test)]
    pub fn to_local(self, v: DVec3) -> DVec3 {
        DVec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }
}
