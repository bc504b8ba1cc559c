//! Frames side by side.

use fearless_simd::{Simd, f64x8, prelude::*};

use super::Frame;
use crate::lanes::Vec3x8;

/// As [`Frame`].
#[derive(Clone, Copy)]
pub(crate) struct Frames<S: Simd> {
    x: Vec3x8<S>,
    y: Vec3x8<S>,
    pub z: Vec3x8<S>,
}

impl<S: Simd> Frames<S> {
    /// As [`Frame::from_z`], to the bit.
    #[inline(always)]
    pub fn from_z(z: Vec3x8<S>) -> Self {
        let one: f64x8<S> = 1.0.simd_into(z.z.token());
        let sign = one.copysign(z.z);
        let a = -1.0 / (sign + z.z);
        let b = z.x * z.y * a;
        let x = Vec3x8 { x: 1.0 + sign * z.x * z.x * a, y: sign * b, z: -sign * z.x };
        let y = Vec3x8 { x: b, y: sign + z.y * z.y * a, z: -z.y };
        Frames { x, y, z }
    }

    /// Puts another one in a lane.
    pub fn put(&mut self, lane: usize, frame: &Frame) {
        self.x.put(lane, frame.x);
        self.y.put(lane, frame.y);
        self.z.put(lane, frame.z);
    }

    #[inline(always)]
    pub fn to_local(self, v: Vec3x8<S>) -> Vec3x8<S> {
        Vec3x8 { x: self.x.dot(v), y: self.y.dot(v), z: self.z.dot(v) }
    }

    #[inline(always)]
    pub fn to_world(self, v: Vec3x8<S>) -> Vec3x8<S> {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}
