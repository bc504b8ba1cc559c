//! Light from a sky that is everywhere alike.

use glam::{DVec2, DVec3};

use crate::frame::Frame;
use crate::surface::Surface;
use crate::warp::{
    square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf, square_to_uniform_hemisphere,
    square_to_uniform_hemisphere_pdf,
};

/// A direction to a sky that is everywhere alike, on the side of `wo`, and its density by solid angle.
///
/// In proportion to the cosine; but where the shading normal is not the geometric one, light also comes from directions
/// below the horizon of the shading normal, so there all directions above the surface are alike.
pub(super) fn sample(from: &Surface, wo: DVec3, u: DVec2) -> (DVec3, f64) {
    let frame = Frame::from_z(side_of(from, wo));
    let local =
        if from.n == from.ns { square_to_cosine_hemisphere(u) } else { square_to_uniform_hemisphere(u) };
    let wi = frame.to_world(local);
    (wi, pdf(from, wo, wi))
}

/// Density of [`sample`].
pub(super) fn pdf(from: &Surface, wo: DVec3, wi: DVec3) -> f64 {
    let cos_theta = side_of(from, wo).dot(wi);
    if from.n == from.ns {
        square_to_cosine_hemisphere_pdf(cos_theta)
    } else if cos_theta > 0.0 {
        square_to_uniform_hemisphere_pdf()
    } else {
        0.0
    }
}

/// The geometric normal on the side of `wo`.
fn side_of(surface: &Surface, wo: DVec3) -> DVec3 {
    if surface.n.dot(wo) < 0.0 { -surface.n } else { surface.n }
}
