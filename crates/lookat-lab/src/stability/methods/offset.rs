//! Where rays start that leave a surface, so that they do not meet it again.

use num_traits::Float;

use super::sphere::haines_roots;
use super::{Vector, along, cross, dot, gamma, sub};

/// pbrt-v3, `OffsetRayOrigin`: along the normal by the bound of the error, and one step more (PBR 3.9.5). `n` points to the
/// side of the ray.
pub(in crate::stability) fn pbrt_v3(p: Vector<f32>, error: Vector<f32>, n: Vector<f32>) -> Vector<f32> {
    let distance = dot(n.map(f32::abs), error);
    std::array::from_fn(|i| {
        let offset = distance * n[i];
        let moved = p[i] + offset;
        if offset > 0.0 {
            moved.next_up()
        } else if offset < 0.0 {
            moved.next_down()
        } else {
            moved
        }
    })
}

/// Wächter and Binder, "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing Gems, chapter 6, 2019.
pub(in crate::stability) fn waechter_binder(p: Vector<f32>, n: Vector<f32>) -> Vector<f32> {
    const NEAR_ORIGIN: f32 = 1.0 / 32.0;
    std::array::from_fn(|i| {
        if p[i].abs() < NEAR_ORIGIN {
            return p[i] + n[i] / 65536.0;
        }
        let steps = (256.0 * n[i]) as i32;
        f32::from_bits(p[i].to_bits().wrapping_add_signed(if p[i] < 0.0 { -steps } else { steps }))
    })
}

/// Mitsuba 3, `Interaction::offset_p`, with `RayEpsilon` of single precision, before its change of 2026.
pub(in crate::stability) fn mitsuba(p: Vector<f32>, n: Vector<f32>) -> Vector<f32> {
    let size = p.into_iter().fold(0.0, |size: f32, x| size.max(x.abs()));
    let distance = (1.0 + size) * (1500.0 * (f32::EPSILON / 2.0));
    std::array::from_fn(|i| n[i].mul_add(distance, p[i]))
}

/// What rays leave and may meet again.
#[derive(Clone, Copy)]
pub(in crate::stability) enum Body<T> {
    /// Three corners.
    Triangle([Vector<T>; 3]),
    /// Center and radius.
    Sphere(Vector<T>, T),
}

/// A point where a ray has hit, and how far each coordinate may be off.
#[derive(Clone, Copy)]
pub(in crate::stability) struct HitPoint<T> {
    pub p: Vector<T>,
    pub error: Vector<T>,
}

impl<T: Float> Body<T> {
    /// The nearest hit beyond `t_min`: Woop et al. of triangles, Haines et al. of spheres, each as pbrt uses them (PBR
    /// 3.6.2, PBR4 6.2.2).
    pub fn distance(&self, o: Vector<T>, d: Vector<T>, t_min: T) -> Option<T> {
        match *self {
            Body::Triangle(corners) => watertight(o, d, corners).map(|(t, _)| t).filter(|t| *t > t_min),
            Body::Sphere(center, radius) => {
                haines_roots(sub(o, center), d, radius)?.into_iter().find(|t| *t > t_min)
            }
        }
    }

    /// The point of the body that a ray hits, brought back to the surface, with the bounds of PBR 3.9.4.
    pub fn hit(&self, o: Vector<T>, d: Vector<T>) -> Option<HitPoint<T>> {
        match *self {
            Body::Triangle(corners) => {
                let (_, weights) = watertight(o, d, corners).filter(|(t, _)| *t > T::zero())?;
                let sum = |of: fn(T) -> T| {
                    std::array::from_fn(|i| {
                        (0..3).fold(T::zero(), |sum, k| sum + of(weights[k] * corners[k][i]))
                    })
                };
                Some(HitPoint { p: sum(|x| x), error: sum(T::abs).map(|x| x * gamma(7)) })
            }
            Body::Sphere(center, radius) => {
                let t = self.distance(o, d, T::zero())?;
                let place = along(sub(o, center), d, t);
                let scale = radius / dot(place, place).sqrt();
                let own = place.map(|x| x * scale);
                // Of the sphere, and of the way from its space to the world.
                let error = |i: usize| {
                    (gamma::<T>(3) + T::one()) * gamma(5) * own[i].abs()
                        + gamma::<T>(3) * (own[i].abs() + center[i].abs())
                };
                Some(HitPoint {
                    p: std::array::from_fn(|i| own[i] + center[i]),
                    error: std::array::from_fn(error),
                })
            }
        }
    }
}

/// Distance and weights of the corners (Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013).
fn watertight<T: Float>(o: Vector<T>, d: Vector<T>, corners: [Vector<T>; 3]) -> Option<(T, Vector<T>)> {
    let z = (0..3).fold(0, |z, i| if d[i].abs() > d[z].abs() { i } else { z });
    let (x, y) = ((z + 1) % 3, (z + 2) % 3);
    let [a, b, c] = corners.map(|p| {
        let p = sub(p, o);
        [p[x] - d[x] / d[z] * p[z], p[y] - d[y] / d[z] * p[z], p[z] / d[z]]
    });
    let side = |p: Vector<T>, q: Vector<T>| p[0] * q[1] - p[1] * q[0];
    let sides = [side(b, c), side(c, a), side(a, b)];
    let zero = T::zero();
    if sides.iter().any(|s| *s < zero) && sides.iter().any(|s| *s > zero) {
        return None;
    }
    let sum = sides[0] + sides[1] + sides[2];
    if sum == zero {
        return None;
    }
    let weights = sides.map(|s| s / sum);
    Some((weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2], weights))
}

/// The unit normal of a triangle.
pub(in crate::stability) fn normal(corners: [Vector<f64>; 3]) -> Vector<f64> {
    let n = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
    let length = dot(n, n).sqrt();
    n.map(|x| x / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [Vector<f64>; 3] = [[-1.0, -1.0, 2.0], [2.0, -1.0, 2.0], [0.0, 2.0, 2.0]];

    #[test]
    fn bodies_are_hit_where_they_are() {
        let triangle = Body::Triangle(TRIANGLE);
        let hit = triangle.hit([0.25, 0.5, 0.0], [0.0, 0.0, 1.0]).unwrap();
        assert!(dot(sub(hit.p, [0.25, 0.5, 2.0]), [1.0; 3]).abs() < 1e-14);
        assert!(triangle.hit([0.25, 0.5, 0.0], [0.0, 0.0, -1.0]).is_none());
        assert!(triangle.hit([3.0, 0.5, 0.0], [0.0, 0.0, 1.0]).is_none());
        let ball = Body::Sphere([5.0, 0.0, 0.0], 2.0);
        assert_eq!(ball.distance([0.0; 3], [1.0, 0.0, 0.0], 0.0), Some(3.0));
        assert_eq!(ball.distance([0.0; 3], [1.0, 0.0, 0.0], 4.0), Some(7.0));
        assert_eq!(ball.hit([0.0; 3], [1.0, 0.0, 0.0]).unwrap().p, [3.0, 0.0, 0.0]);
        assert_eq!(normal(TRIANGLE), [0.0, 0.0, 1.0]);
    }

    /// Each goes along the normal, by as much as its authors say.
    #[test]
    fn offsets_are_as_large_as_they_should_be() {
        let (p, n) = ([1.0_f32, -0.5, 4.0], [0.0, 0.0, 1.0]);
        let moved = pbrt_v3(p, [1e-6; 3], n);
        assert_eq!([moved[0], moved[1]], [p[0], p[1]]);
        assert_eq!(moved[2], (4.0_f32 + 1e-6).next_up());
        assert_eq!(pbrt_v3(p, [1e-6; 3], [0.0, 0.0, -1.0])[2], (4.0_f32 - 1e-6).next_down());
        let moved = waechter_binder(p, n);
        assert_eq!([moved[0], moved[1]], [p[0], p[1]]);
        assert_eq!(moved[2], 4.0 + 256.0 * 4.0 * f32::EPSILON);
        assert_eq!(waechter_binder([0.0; 3], n)[2], 1.0 / 65536.0);
        assert_eq!(waechter_binder([1.0, -2.0, 0.5], [0.0, -1.0, 0.0])[1], -2.0 - 256.0 * 2.0 * f32::EPSILON);
        assert!((mitsuba(p, n)[2] - (4.0 + 5.0 * 8.940_697e-5)).abs() < 1e-6);
    }
}
