//! Frames side by side.

use fearless_simd::{Simd, f32x8};
use glam::DVec3;

use super::Frame;
use crate::lanes::{Number, V3};

/// As [`Frame`].
#[derive(Clone, Copy)]
pub(crate) struct Frames<T> {
    pub x: V3<T>,
    y: V3<T>,
    z: V3<T>,
}

impl<T> Frames<T> {
    /// As [`Frame::from_z`].
    #[inline(always)]
    pub fn from_z<S: Simd>(z: V3<T>) -> Self
    where
        T: Number<S>,
    {
        let one = T::of(z.z.token(), 1.0);
        let sign = one.copysign(z.z);
        let a = -one / (sign + z.z);
        let b = z.x * z.y * a;
        let x = V3 { x: one + sign * z.x * z.x * a, y: sign * b, z: -sign * z.x };
        let y = V3 { x: b, y: sign + z.y * z.y * a, z: -z.y };
        Frames { x, y, z }
    }

    #[inline(always)]
    pub fn to_local<S: Simd>(self, v: V3<T>) -> V3<T>
    where
        T: Number<S>,
    {
        V3 { x: self.x.dot(v), y: self.y.dot(v), z: self.z.dot(v) }
    }

    #[inline(always)]
    pub fn to_world<S: Simd>(self, v: V3<T>) -> V3<T>
    where
        T: Number<S>,
    {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

impl<S: Simd> Frames<f32x8<S>> {
    /// Puts another one in a lane.
    pub fn put(&mut self, lane: usize, frame: &Frame) {
        let put = |own: &mut V3<f32x8<S>>, v: DVec3| {
            (own.x[lane], own.y[lane], own.z[lane]) = v.as_vec3().into();
        };
        put(&mut self.x, frame.x);
        put(&mut self.y, frame.y);
        put(&mut self.z, frame.z);
    }
}
