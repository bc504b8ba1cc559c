//! Colors: linear RGB.

use glam::Vec3;
use lookat_scene::LUMINANCE;

/// The luminance of linear RGB (ITU-R BT.709).
pub(crate) fn luminance(rgb: Vec3) -> f64 {
    rgb.as_dvec3().dot(LUMINANCE)
}

/// How bright a color is; negative channels count as positive ones, so that no light with any is 0.
pub(crate) fn strength(rgb: Vec3) -> f64 {
    luminance(rgb.abs())
}
