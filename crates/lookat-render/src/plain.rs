//! Intersections in single precision by textbook formulas, which lose geometry: what the exact ones cost is measured
//! against them.

use glam::{DVec3, Vec3};

use crate::curved::Curved;
use crate::ray::Ray;

/// A ray in single precision.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlainRay {
    o: Vec3,
    d: Vec3,
}

impl PlainRay {
    pub fn new(ray: &Ray) -> Self {
        PlainRay { o: ray.o.as_vec3(), d: ray.d.as_vec3() }
    }

    /// Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
    pub fn intersect(&self, triangle: &[DVec3; 3]) -> Option<(f64, [f64; 3])> {
        let [a, b, c] = triangle.map(|p| p.as_vec3());
        let (e1, e2) = (b - a, c - a);
        let p = self.d.cross(e2);
        let det = e1.dot(p);
        if det == 0.0 {
            return None;
        }
        let inverse = 1.0 / det;
        let s = self.o - a;
        let v = s.dot(p) * inverse;
        if !(0.0..=1.0).contains(&v) {
            return None;
        }
        let q = s.cross(e1);
        let w = self.d.dot(q) * inverse;
        if w < 0.0 || v + w > 1.0 {
            return None;
        }
        Some((f64::from(e2.dot(q) * inverse), [1.0 - v - w, v, w].map(f64::from)))
    }
}

/// Spheres by the quadratic equation; others as exactly as without this feature.
pub(crate) fn curved(shape: &Curved, ray: &Ray, t_max: f64, leaving: bool) -> Option<f64> {
    let Some(sphere) = shape.as_sphere() else { return shape.intersect(ray, t_max, leaving) };
    let o = (shape.own_from_world * (ray.o - shape.center)).as_vec3();
    let d = (shape.own_from_world * ray.d).as_vec3();
    let radius = sphere.radius as f32;
    let (a, b, c) = (d.length_squared(), 2.0 * o.dot(d), o.length_squared() - radius * radius);
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return None;
    }
    let q = -0.5 * (b + b.signum() * discriminant.sqrt());
    let (x, y) = (q / a, c / q);
    let roots = [x.min(y), x.max(y)];
    let counts = |&t: &f32| t > 0.0 && f64::from(t) <= t_max && sphere.has((o + d * t).as_dvec3());
    roots[usize::from(leaving)..].iter().copied().find(counts).map(f64::from)
}
