//! Boxes along the axes, in `f32`, that are never too small.

use glam::{DVec3, Vec3A};

/// An axis-aligned box. Its corners are rounded outward, so it holds whatever `f64` box it was made from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub min: Vec3A,
    pub max: Vec3A,
}

impl Bounds {
    /// Holds nothing.
    pub const EMPTY: Bounds = Bounds { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    pub fn new(min: DVec3, max: DVec3) -> Self {
        Bounds { min: min.to_array().map(round_down).into(), max: max.to_array().map(round_up).into() }
    }

    /// A box whose corners were computed from coordinates of a magnitude: wider by what rounding may have taken.
    pub fn padded(min: DVec3, max: DVec3, magnitude: f64) -> Self {
        let error = magnitude * 1e-14;
        Bounds::new(min - error, max + error)
    }

    /// Whether it holds nothing.
    pub fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }

    /// A box around two.
    #[inline(always)]
    pub fn union(self, other: Bounds) -> Self {
        Bounds { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Half the surface; 0 for an empty box.
    #[inline(always)]
    pub fn half_area(&self) -> f64 {
        let side = (self.max.min(Vec3A::MAX) - self.min.max(Vec3A::MIN)).as_dvec3();
        if side.x < 0.0 { 0.0 } else { side.x * side.y + side.y * side.z + side.z * side.x }
    }

    /// The middle, within the finite numbers.
    #[inline(always)]
    pub fn center(&self) -> Vec3A {
        self.min.max(Vec3A::MIN) * 0.5 + self.max.min(Vec3A::MAX) * 0.5
    }

    /// The corners, as `f64`.
    pub fn corners(&self) -> (DVec3, DVec3) {
        (self.min.as_dvec3(), self.max.as_dvec3())
    }
}

pub(crate) fn round_down(x: f64) -> f32 {
    let rounded = x as f32;
    if f64::from(rounded) > x { rounded.next_down() } else { rounded }
}

pub(crate) fn round_up(x: f64) -> f32 {
    -round_down(-x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_rounded_outward() {
        for x in [0.1, -0.1, 1.0, 1e-40, -1e-300, 16_777_217.0, 1e300] {
            let bounds = Bounds::new(DVec3::splat(x), DVec3::splat(x));
            assert!(f64::from(bounds.min[0]) <= x && x <= f64::from(bounds.max[0]), "{x}");
        }
        assert_eq!(Bounds::new(DVec3::ONE, DVec3::ONE), Bounds { min: Vec3A::ONE, max: Vec3A::ONE });
    }
}
