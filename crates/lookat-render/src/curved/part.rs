//! The parts of forms of revolution that are left where these are cut.

use std::f64::consts::{PI, TAU};

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::{DVec2, DVec3};

use crate::number::Vec3x8;
use crate::warp::at_angle;

/// The part of a form between two heights and up to an angle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    pub z_min: f64,
    pub z_max: f64,
    pub seam: Seam,
    pub sweep: Sweep,
}

/// Where the sweep starts: the intersection of its line with z = 0, and the sideways step of that per unit of height.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seam {
    pub middle: DVec2,
    pub slope: DVec2,
}

impl Seam {
    /// In the plane y = 0.
    pub const ALONG_X: Seam = Seam { middle: DVec2::X, slope: DVec2::ZERO };

    /// The point at a height, without z.
    pub fn at(&self, z: f64) -> DVec2 {
        self.middle + self.slope * z
    }
}

/// How many numbers tests side by side need of a [`Part`].
pub(super) const PART: usize = 9;

/// The least angle between a point and an end of the sweep that tests side by side tell from none, in radians.
const CLEAR: f64 = 1e-12;

impl Part {
    /// All of a form.
    pub const WHOLE: Part = Part {
        z_min: f64::NEG_INFINITY,
        z_max: f64::INFINITY,
        seam: Seam::ALONG_X,
        sweep: Sweep { max: TAU, end: DVec2::X },
    };

    /// True if it has a point of the form.
    pub fn has(&self, p: DVec3) -> bool {
        self.z_min <= p.z && p.z <= self.z_max && self.sweep.has(p.truncate(), self.seam.at(p.z))
    }

    pub fn numbers(&self) -> [f64; PART] {
        let Part { z_min, z_max, seam: Seam { middle, slope }, sweep: Sweep { max, end } } = *self;
        [z_min, z_max, max, end.x, end.y, middle.x, slope.x, middle.y, slope.y]
    }
}

/// The points that parts with these numbers have, and those that [`Part::has`] must decide about.
#[inline(always)]
pub(super) fn have<S: Simd>(
    number: impl Fn(usize) -> f64x8<S>,
    p: Vec3x8<S>,
    active: mask64x8<S>,
) -> (mask64x8<S>, mask64x8<S>) {
    let has = active & p.z.simd_ge(number(0)) & p.z.simd_le(number(1));
    let max = number(2);
    let is_cut = max.simd_lt(TAU);
    if !(has & is_cut).any_true() {
        return (has, has & !has);
    }
    let (cos, sin) = (number(3), number(4));
    let (x, y) = (number(5) + number(6) * p.z, number(7) + number(8) * p.z);
    // The point turned back by the angle of the seam, times a length.
    let (ahead, aside) = (x * p.x + y * p.y, x * p.y - y * p.x);
    let left = sin * ahead - cos * aside;
    let least = (ahead.abs() + aside.abs()) * CLEAR;
    let (is_past_start, is_before_end) = (aside.simd_gt(0.0), left.simd_gt(0.0));
    let is_wide = max.simd_gt(PI);
    let reaches = (is_past_start & is_before_end) | (is_wide & (is_past_start | is_before_end));
    let is_clear = aside.abs().simd_gt(least) & left.abs().simd_gt(least);
    (has & (!is_cut | reaches), has & is_cut & !is_clear)
}

/// The angle by which a profile sweeps around the axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sweep {
    /// In radians, more than 0 and at most 2 pi.
    pub max: f64,
    /// The direction at that angle.
    end: DVec2,
}

impl Sweep {
    pub fn new(max: f64) -> Self {
        Sweep { max, end: at_angle(max) }
    }

    pub fn is_whole(self) -> bool {
        self.max >= TAU
    }

    /// The angle from `start` to `p`, from 0 to 2 pi.
    pub fn angle(p: DVec2, start: DVec2) -> f64 {
        let angle = libm::atan2(start.perp_dot(p), start.dot(p));
        if angle < 0.0 { angle + TAU } else { angle }
    }

    /// True if it reaches `p`, of any distance from the axis.
    pub fn has(self, p: DVec2, start: DVec2) -> bool {
        self.is_whole() || Sweep::angle(p, start) <= self.max
    }
}
