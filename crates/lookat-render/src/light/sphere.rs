//! Light from spheres.

use glam::{DVec2, DVec3};

use crate::curved::{Curved, Sphere};
use crate::frame::Frame;
use crate::warp::{square_to_uniform_cone, square_to_uniform_cone_pdf};

/// The directions in which a sphere is seen from a point outside.
pub(super) struct VisibleCone {
    axis: DVec3,
    /// Of the center.
    distance: f64,
    radius: f64,
    /// One minus the cosine of half the angle.
    one_minus_cos_max: f64,
}

impl VisibleCone {
    /// Of a whole sphere, that is one in the world.
    pub fn new(shape: &Curved, p: DVec3) -> Option<Self> {
        let radius = shape
            .as_sphere()
            .filter(|sphere| sphere.is_whole())
            .and_then(|sphere: &Sphere| sphere.world_radius)?;
        let to_center = shape.center - p;
        let distance = to_center.length();
        if distance <= radius * (1.0 + 1e-9) {
            return None;
        }
        let sin_squared = (radius / distance).powi(2);
        // 1 - cos without cancellation.
        let one_minus_cos_max = sin_squared / (1.0 + (1.0 - sin_squared).sqrt());
        Some(VisibleCone { axis: to_center / distance, distance, radius, one_minus_cos_max })
    }

    /// One of the directions, all alike, and how far away the sphere is there.
    pub fn sample(&self, u: DVec2) -> (DVec3, f64) {
        let local = square_to_uniform_cone(u, self.one_minus_cos_max);
        // By the law of sines.
        let sin_squared = (1.0 - local.z) * (1.0 + local.z);
        let half = (self.radius * self.radius - self.distance * self.distance * sin_squared).max(0.0).sqrt();
        (Frame::from_z(self.axis).to_world(local), self.distance * local.z - half)
    }

    /// Density of the directions by solid angle.
    pub fn pdf(&self) -> f64 {
        square_to_uniform_cone_pdf(self.one_minus_cos_max)
    }
}
