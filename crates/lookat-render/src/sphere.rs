//! Ray against sphere, by the point of the ray that is closest to the centre.

use glam::{DMat3, DVec3};
use lookat_scene::{Sphere, Transform};
use twofloat::TwoFloat;

use crate::ray::Ray;

/// A sphere in its place, relative to the eye.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlacedSphere {
    /// Its form, in object space.
    pub shape: Sphere,
    /// Its centre.
    pub center: DVec3,
    /// Takes offsets from the centre to object space.
    pub object_from_world: DMat3,
    /// And back.
    pub world_from_object: DMat3,
    /// The radius in the world, where the sphere is still one there.
    pub world_radius: Option<f64>,
}

impl PlacedSphere {
    pub fn new(shape: Sphere, eye: DVec3) -> Self {
        let Transform { m, inv } = shape.world_from_object;
        let (world_from_object, object_from_world) = (DMat3::from_mat4(m), DMat3::from_mat4(inv));
        PlacedSphere {
            shape,
            center: m.w_axis.truncate() - eye,
            object_from_world,
            world_from_object,
            world_radius: uniform_scale(world_from_object).map(|scale| scale * shape.radius),
        }
    }

    /// Half the extent of the whole sphere along each axis of the world.
    pub fn half_extent(&self) -> DVec3 {
        let rows = self.world_from_object.transpose();
        DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length()) * self.shape.radius
    }

    /// The largest coordinate of the box around it.
    pub fn magnitude(&self) -> f64 {
        (self.center.abs() + self.half_extent()).max_element()
    }

    /// The nearest distance at which the ray meets the sphere, more than 0 and at most `t_max`. A ray that leaves the
    /// sphere meets it again only on its far side.
    pub fn intersect(&self, ray: &Ray, t_max: f64, leaving: bool) -> Option<f64> {
        let o = self.object_from_world * (ray.o - self.center);
        let d = self.object_from_world * ray.d;
        let dd = d.length_squared();
        let foot = Foot::new(o, d, dd);
        let radius = self.shape.radius;
        let mut squared = (radius - foot.distance) * (radius + foot.distance);
        // Where rounding could turn a hit into a miss.
        if (radius - foot.distance).abs() <= 8.0 * f64::EPSILON * o.abs().max_element() {
            squared = exact_margin(o, d, radius) / dd;
        }
        if squared < 0.0 {
            return None;
        }
        let half = (squared / dd).sqrt();
        let middle = foot.k + foot.correction;
        // Added from the smallest to the largest.
        let roots = [-half, half].map(|offset| (foot.k + (foot.correction + offset), offset));
        let first = usize::from(leaving);
        if leaving && middle <= 0.0 {
            return None;
        }
        let counts = |&(t, offset): &(f64, f64)| t > 0.0 && t <= t_max && self.has(foot.near + d * offset);
        roots[first..].iter().find(|root| counts(root)).map(|(t, _)| *t)
    }

    /// Whether the end of the ray, a point of the sphere, lies behind another part of the sphere.
    pub fn hides_end_of(&self, ray: &Ray) -> bool {
        let (o, d) = (self.object_from_world * (ray.o - self.center), self.object_from_world * ray.d);
        let middle = -o.dot(d) / d.length_squared();
        ray.t_max > middle && self.intersect(ray, middle, ray.leaving == ray.target).is_some()
    }

    /// Whether nothing is cut off.
    pub fn is_whole(&self) -> bool {
        let Sphere { radius, z_min, z_max, phi_max, .. } = self.shape;
        z_min <= -radius && z_max >= radius && phi_max >= std::f64::consts::TAU
    }

    /// Whether the part that is left of the sphere holds a point of it, in object space.
    pub fn has(&self, p: DVec3) -> bool {
        let Sphere { radius, z_min, z_max, phi_max, .. } = self.shape;
        if (z_min > -radius && p.z < z_min) || (z_max < radius && p.z > z_max) {
            return false;
        }
        if phi_max >= std::f64::consts::TAU {
            return true;
        }
        let phi = p.y.atan2(p.x);
        let phi = if phi < 0.0 { phi + std::f64::consts::TAU } else { phi };
        phi <= phi_max
    }

    /// The point of the sphere nearest to `p`, and the unit normal there that points out of it; in the world.
    pub fn project(&self, p: DVec3) -> (DVec3, DVec3) {
        let on_unit = (self.object_from_world * (p - self.center)).normalize_or(DVec3::Z);
        self.point(on_unit)
    }

    /// The point in the direction `on_unit` of object space, and its outward unit normal; in the world.
    pub fn point(&self, on_unit: DVec3) -> (DVec3, DVec3) {
        let p = self.center + self.world_from_object * (on_unit * self.shape.radius);
        let n = (self.object_from_world.transpose() * on_unit).normalize_or(DVec3::Z);
        (p, n)
    }
}

/// Where a ray meets a sphere, as [`PlacedSphere::intersect`].
#[cfg(not(feature = "plain-f32"))]
#[inline]
pub(crate) fn meet(sphere: &PlacedSphere, ray: &Ray, t_max: f64, leaving: bool) -> Option<f64> {
    sphere.intersect(ray, t_max, leaving)
}

/// The closest approach of a ray to the origin: no digits cancel, whatever the distance (after Haines et al., Ray Tracing
/// Gems 7, 2019; see docs/conventions.md).
struct Foot {
    /// How far along the ray, in lengths of `d`, and what that was corrected by.
    k: f64,
    correction: f64,
    near: DVec3,
    /// From the origin.
    distance: f64,
}

impl Foot {
    fn new(o: DVec3, d: DVec3, dd: f64) -> Foot {
        let k = -o.dot(d) / dd;
        let near = o + d * k;
        let correction = -near.dot(d) / dd;
        let near = near + d * correction;
        Foot { k, correction, near, distance: near.length() }
    }
}

/// The squared radius minus the squared distance of the ray, times the squared length of `d`; in double-double numbers.
#[cold]
fn exact_margin(o: DVec3, d: DVec3, radius: f64) -> f64 {
    let minor = |a: usize, b: usize| TwoFloat::new_mul(o[a], d[b]) - TwoFloat::new_mul(o[b], d[a]);
    let moment = [minor(1, 2), minor(2, 0), minor(0, 1)];
    let squares = moment.iter().fold(TwoFloat::from(0.0), |sum, x| sum + *x * *x);
    let dd = d.to_array().iter().fold(TwoFloat::from(0.0), |sum, x| sum + TwoFloat::new_mul(*x, *x));
    f64::from(TwoFloat::new_mul(radius, radius) * dd - squares)
}

/// The factor of a matrix that scales all directions alike, within rounding.
fn uniform_scale(m: DMat3) -> Option<f64> {
    let scale = m.x_axis.length();
    let product = m.transpose() * m;
    let error = (product * (1.0 / (scale * scale)) - DMat3::IDENTITY).to_cols_array();
    error.iter().all(|x| x.abs() < 1e-9).then_some(scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sphere(radius: f64, transform: Transform) -> PlacedSphere {
        let shape = Sphere {
            radius,
            z_min: -radius,
            z_max: radius,
            phi_max: std::f64::consts::TAU,
            world_from_object: transform,
        };
        PlacedSphere::new(shape, DVec3::ZERO)
    }

    #[test]
    fn tangent_rays_are_told_apart_at_any_distance() {
        for exponent in [1, 4, 7] {
            let far = 10_f64.powi(exponent);
            let ball = sphere(1.0, Transform::translate(DVec3::new(0.0, 0.0, far)));
            for (offset, expected) in [(1.0 - 1e-9, true), (1.0 + 1e-9, false)] {
                let ray = Ray::new(DVec3::new(offset, 0.0, 0.0), DVec3::Z);
                assert_eq!(ball.intersect(&ray, f64::INFINITY, false).is_some(), expected, "{far} {offset}");
            }
        }
    }

    #[test]
    fn a_ray_that_leaves_the_sphere_does_not_meet_where_it_starts() {
        let ball = sphere(2.0, Transform::IDENTITY);
        let start = DVec3::new(0.0, 0.0, 2.0);
        assert_eq!(ball.intersect(&Ray::new(start, DVec3::Z), f64::INFINITY, true), None);
        assert_eq!(ball.intersect(&Ray::new(start, -DVec3::Z), f64::INFINITY, true), Some(4.0));
        assert_eq!(ball.intersect(&Ray::new(DVec3::ZERO, DVec3::X), f64::INFINITY, false), Some(2.0));
    }

    #[test]
    fn only_similar_transformations_keep_a_sphere() {
        let turn = Transform::rotate(30.0, DVec3::ONE).unwrap();
        let double = Transform::scale(DVec3::splat(2.0)).unwrap();
        let stretch = Transform::scale(DVec3::new(1.0, 1.0, 1.01)).unwrap();
        let radius = sphere(1.5, turn * double).world_radius.unwrap();
        assert!((radius - 3.0).abs() < 1e-14);
        assert_eq!(sphere(1.5, turn * stretch).world_radius, None);
    }
}
