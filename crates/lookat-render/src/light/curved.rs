//! Light from curved shapes.

use glam::{DVec2, DVec3};

use crate::curved::{Ball, Curved};
use crate::frame::Frame;
use crate::surface::Surface;
use crate::warp::{square_to_uniform_cone, square_to_uniform_cone_pdf};

/// A point of a light.
pub(super) struct LightPoint {
    pub p: DVec3,
    /// The normal there.
    pub n: DVec3,
    /// Density by solid angle, if the point is one of those that can be seen; `None` if it is any of the whole light.
    pub visible_pdf: Option<f64>,
}

/// A point of a light of a curved shape, to be seen from `p`. Of a whole sphere seen from outside, one of those that can be
/// seen.
pub(super) fn sample(shape: &Curved, p: DVec3, u: DVec2) -> LightPoint {
    let Some(cone) = VisibleCone::new(shape, p) else {
        let (p, n) = shape.placed(shape.sample(u));
        return LightPoint { p, n, visible_pdf: None };
    };
    let local = square_to_uniform_cone(u, cone.one_minus_cos_max);
    let wi = Frame::from_z(cone.axis).to_world(local);
    // Where the ray first meets the sphere, by the law of sines.
    let sin_squared = (1.0 - local.z) * (1.0 + local.z);
    let (radius, distance) = (cone.radius, cone.distance);
    let half = (radius * radius - distance * distance * sin_squared).max(0.0).sqrt();
    // From the centre through that point, so that it lies on the sphere to the last digits.
    let n = (wi * (distance * local.z - half) - cone.axis * distance).normalize_or(-cone.axis);
    let visible_pdf = Some(square_to_uniform_cone_pdf(cone.one_minus_cos_max));
    LightPoint { p: shape.center + n * radius, n, visible_pdf }
}

/// Density of [`sample`] by solid angle from `p`.
pub(super) fn pdf(shape: &Curved, p: DVec3, on_light: &Surface) -> Option<f64> {
    match VisibleCone::new(shape, p) {
        Some(cone) => Some(square_to_uniform_cone_pdf(cone.one_minus_cos_max)),
        None => on_light.pdf_from(p, shape.stretch(on_light.p)),
    }
}

/// The directions in which a sphere is seen.
struct VisibleCone {
    axis: DVec3,
    /// Of the centre.
    distance: f64,
    radius: f64,
    /// One minus the cosine of half the angle.
    one_minus_cos_max: f64,
}

impl VisibleCone {
    /// Of a whole sphere, that is one in the world, from outside.
    fn new(shape: &Curved, p: DVec3) -> Option<Self> {
        let radius =
            shape.as_ball().filter(|ball| ball.is_whole()).and_then(|ball: &Ball| ball.world_radius)?;
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
}
