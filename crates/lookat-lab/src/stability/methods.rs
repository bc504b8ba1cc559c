//! Formulas that others use, written anew from books and papers. Each works in `f32` and in `f64`, where that makes sense.

pub(super) mod camera;
pub(super) mod offset;
pub(super) mod quadric;
pub(super) mod slab;
pub(super) mod sphere;
pub(super) mod triangle;

use num_traits::Float;

/// A vector of either precision.
pub(super) type Vector<T> = [T; 3];

pub(super) fn dot<T: Float>(a: Vector<T>, b: Vector<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn sub<T: Float>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    std::array::from_fn(|i| a[i] - b[i])
}

pub(super) fn cross<T: Float>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The point at a distance along a ray.
pub(super) fn along<T: Float>(o: Vector<T>, d: Vector<T>, t: T) -> Vector<T> {
    std::array::from_fn(|i| o[i] + d[i] * t)
}

/// Rounded to single precision.
pub(super) fn single(v: glam::DVec3) -> Vector<f32> {
    v.as_vec3().to_array()
}

/// What single precision holds.
pub(super) fn double(v: Vector<f32>) -> glam::DVec3 {
    glam::Vec3::from(v).as_dvec3()
}

/// What `n` roundings may add up to, relatively (PBR 3.9.1).
fn gamma<T: Float>(n: u8) -> T {
    let one = T::one();
    let error = (0..n).fold(T::zero(), |sum, _| sum + one) * T::epsilon() / (one + one);
    error / (one - error)
}
