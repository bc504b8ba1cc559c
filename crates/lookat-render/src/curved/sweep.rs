//! Sweeps about the z axis.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

/// How far a form is turned about the axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sweep {
    /// In radians, more than 0 and at most 2 pi.
    pub max: f64,
}

impl Sweep {
    pub fn new(max: f64) -> Self {
        Sweep { max }
    }

    pub fn is_whole(self) -> bool {
        self.max >= TAU
    }

    /// The angle from `start` to `p`, from 0 to 2 pi.
    pub fn angle(p: DVec2, start: DVec2) -> f64 {
        let angle = libm::atan2(start.perp_dot(p), start.dot(p));
        if angle < 0.0 { angle + TAU } else { angle }
    }

    /// Whether it reaches `p`, of any distance from the axis.
    pub fn has(self, p: DVec2, start: DVec2) -> bool {
        self.is_whole() || Sweep::angle(p, start) <= self.max
    }
}

/// The direction away from the axis at `p`, of length one; any on the axis.
pub(super) fn radial(p: DVec3) -> DVec2 {
    p.truncate().normalize_or(DVec2::X)
}
