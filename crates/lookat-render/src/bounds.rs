//! Boxes along the axes, in `f32`, that are never too small.

use std::array::from_fn;

use glam::DVec3;

/// An axis-aligned box. Its corners are rounded outward, so it holds whatever `f64` box it was made from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub min: [f32; 3],
    pub max: [f32; 3],
}

impl Bounds {
    /// Holds nothing.
    pub const EMPTY: Bounds = Bounds { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    pub fn new(min: DVec3, max: DVec3) -> Self {
        Bounds { min: min.to_array().map(round_down), max: max.to_array().map(round_up) }
    }

    /// A box whose corners were computed from coordinates of a magnitude: wider by what rounding may have taken.
    pub fn padded(min: DVec3, max: DVec3, magnitude: f64) -> Self {
        let error = magnitude * 1e-14;
        Bounds::new(min - error, max + error)
    }

    /// Whether it holds nothing.
    pub fn is_empty(&self) -> bool {
        self.min[0] > self.max[0]
    }

    /// A box around two.
    pub fn union(self, other: Bounds) -> Self {
        Bounds {
            min: from_fn(|axis| self.min[axis].min(other.min[axis])),
            max: from_fn(|axis| self.max[axis].max(other.max[axis])),
        }
    }

    /// The corners, as `f64`.
    pub fn corners(&self) -> (DVec3, DVec3) {
        (DVec3::from(self.min.map(f64::from)), DVec3::from(self.max.map(f64::from)))
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
        assert_eq!(Bounds::new(DVec3::ONE, DVec3::ONE), Bounds { min: [1.0; 3], max: [1.0; 3] });
    }
}
