//! Light from spheres.

use glam::{DVec2, DVec3};
use lookat_scene::Sphere;

use crate::sphere::PlacedSphere;
use crate::surface::Surface;
use crate::warp::{Frame, square_to_uniform_cone, square_to_uniform_cone_pdf};

/// A point of a sphere light and the outward normal there. Of a whole sphere seen from outside, one of those that can be
/// seen.
pub(super) fn sample(sphere: &PlacedSphere, p: DVec3, u: DVec2) -> (DVec3, DVec3) {
    let on_unit = match visible_cone(sphere, p) {
        Some((axis, distance, radius, one_minus_cos_max)) => {
            let local = square_to_uniform_cone(u, one_minus_cos_max);
            let wi = Frame::from_z(axis).to_world(local);
            // Where the ray first meets the sphere, by the law of sines.
            let sin_squared = (1.0 - local.z) * (1.0 + local.z);
            let closest = distance * local.z;
            let half = (radius * radius - distance * distance * sin_squared).max(0.0).sqrt();
            sphere.object_from_world * (p + wi * (closest - half) - sphere.center)
        }
        None => on_part(sphere, u),
    };
    sphere.point(on_unit.normalize_or(DVec3::Z))
}

/// A point of the part that there is of the unit sphere, all alike.
fn on_part(sphere: &PlacedSphere, u: DVec2) -> DVec3 {
    let Sphere { radius, z_min, z_max, phi_max, .. } = sphere.shape;
    let z = (z_min + (z_max - z_min) * u.x) / radius;
    let (sin, cos) = (phi_max * u.y).sin_cos();
    let sin_theta = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(cos * sin_theta, sin * sin_theta, z)
}

/// The area of the part that there is of the unit sphere.
fn part_area(sphere: &Sphere) -> f64 {
    (sphere.z_max - sphere.z_min) / sphere.radius * sphere.phi_max
}

/// Where a whole sphere, that is one in the world, is seen from outside: axis, distance of the centre, radius, and one minus the
/// cosine of half the angle that it covers.
fn visible_cone(sphere: &PlacedSphere, p: DVec3) -> Option<(DVec3, f64, f64, f64)> {
    let radius = sphere.world_radius.filter(|_| sphere.is_whole())?;
    let to_center = sphere.center - p;
    let distance = to_center.length();
    if distance <= radius * (1.0 + 1e-9) {
        return None;
    }
    let sin_squared = (radius / distance).powi(2);
    // 1 - cos without cancellation.
    let one_minus_cos_max = sin_squared / (1.0 + (1.0 - sin_squared).sqrt());
    Some((to_center / distance, distance, radius, one_minus_cos_max))
}

/// Density of [`sample`] by solid angle from `p`.
pub(super) fn pdf(sphere: &PlacedSphere, p: DVec3, on_light: &Surface) -> Option<f64> {
    if let Some((_, _, _, one_minus_cos_max)) = visible_cone(sphere, p) {
        return Some(square_to_uniform_cone_pdf(one_minus_cos_max));
    }
    // Evenly on the part of the unit sphere, carried over to the world.
    let on_unit = (sphere.object_from_world * (on_light.p - sphere.center)).normalize_or(DVec3::Z);
    on_light.pdf_from(p, part_area(&sphere.shape) * area_factor(sphere, on_unit))
}

/// How much larger a small area at `on_unit` is on the sphere in the world than on the unit sphere: the cofactors of the
/// transformation applied to the normal.
fn area_factor(sphere: &PlacedSphere, on_unit: DVec3) -> f64 {
    let scaled = sphere.world_from_object * sphere.shape.radius;
    scaled.determinant().abs() * (sphere.object_from_world.transpose() * on_unit).length()
        / sphere.shape.radius
}

/// The area; of a sphere that is stretched, about.
pub(super) fn area(sphere: &PlacedSphere) -> f64 {
    part_area(&sphere.shape) * area_factor(sphere, DVec3::Z)
}
