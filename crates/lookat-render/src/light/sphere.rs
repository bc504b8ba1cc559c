//! Light from spheres.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::sphere::PlacedSphere;
use crate::surface::Surface;
use crate::warp::{Frame, square_to_uniform_cone, square_to_uniform_cone_pdf, square_to_uniform_sphere};

/// A point of a sphere light and the outward normal there. From outside, of those that can be seen.
pub(super) fn sample(sphere: &PlacedSphere, p: DVec3, u: DVec2) -> Option<(DVec3, DVec3)> {
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
        None => square_to_uniform_sphere(u),
    };
    let on_unit = on_unit.normalize_or(DVec3::Z);
    sphere.has(on_unit * sphere.shape.radius).then(|| sphere.point(on_unit))
}

/// Where a sphere that is one in the world is seen from outside: axis, distance of the centre, radius, and one minus the
/// cosine of half the angle that it covers.
fn visible_cone(sphere: &PlacedSphere, p: DVec3) -> Option<(DVec3, f64, f64, f64)> {
    let radius = sphere.world_radius?;
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
    // Evenly on the unit sphere, carried over to the world.
    let on_unit = (sphere.object_from_world * (on_light.p - sphere.center)).normalize_or(DVec3::Z);
    on_light.pdf_from(p, 4.0 * PI * area_factor(sphere, on_unit))
}

/// How much larger a small area at `on_unit` is on the sphere in the world than on the unit sphere: the cofactors of the
/// transformation applied to the normal.
fn area_factor(sphere: &PlacedSphere, on_unit: DVec3) -> f64 {
    let scaled = sphere.world_from_object * sphere.shape.radius;
    scaled.determinant().abs() * (sphere.object_from_world.transpose() * on_unit).length()
        / sphere.shape.radius
}

pub(super) fn area(sphere: &PlacedSphere) -> f64 {
    let shape = &sphere.shape;
    let share = (shape.z_max - shape.z_min) / (2.0 * shape.radius) * shape.phi_max / (2.0 * PI);
    4.0 * PI * area_factor(sphere, DVec3::Z) * share
}
