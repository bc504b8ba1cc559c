//! Boxes along the axes, in `f32`, that are never too small.

use glam::DVec3;

/// An axis-aligned box. Its corners are rounded outward, so it holds whatever `f64` box it was made from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub min: [f32; 3],
    pub max: [f32; 3],
}

impl Bounds {
    /// Holds nothing; the union with it changes nothing.
    pub const EMPTY: Bounds = Bounds { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    pub fn new(min: DVec3, max: DVec3) -> Self {
        Bounds { min: min.to_array().map(round_down), max: max.to_array().map(round_up) }
    }

    pub fn union(self, other: Bounds) -> Bounds {
        let axis = [0, 1, 2];
        Bounds {
            min: axis.map(|i| self.min[i].min(other.min[i])),
            max: axis.map(|i| self.max[i].max(other.max[i])),
        }
    }

    /// Twice the middle, within the finite numbers.
    pub fn center2(&self, axis: usize) -> f64 {
        f64::from(self.min[axis].max(f32::MIN)) + f64::from(self.max[axis].min(f32::MAX))
    }

    /// Half the surface; 0 for an empty box. Finite: sides are cut to the finite numbers.
    pub fn half_area(&self) -> f64 {
        let side = |i: usize| f64::from(self.max[i].min(f32::MAX)) - f64::from(self.min[i].max(f32::MIN));
        let [x, y, z] = [side(0), side(1), side(2)];
        if x < 0.0 { 0.0 } else { x * y + y * z + z * x }
    }

    /// The corners, as `f64`.
    pub fn corners(&self) -> (DVec3, DVec3) {
        (DVec3::from(self.min.map(f64::from)), DVec3::from(self.max.map(f64::from)))
    }
}

fn round_down(x: f64) -> f32 {
    let rounded = x as f32;
    if f64::from(rounded) > x { rounded.next_down() } else { rounded }
}

fn round_up(x: f64) -> f32 {
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
