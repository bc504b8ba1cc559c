//! Linear RGB: its luminance, and its values in files.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

use std::array::from_fn;
use std::sync::LazyLock;

use glam::{DVec3, Vec3};

/// The luminance weights of linear RGB (ITU-R BT.709), with the digits of pbrt-v3.
pub const LUMINANCE: DVec3 = DVec3::new(0.212671, 0.715160, 0.072169);

/// The luminance of linear RGB, in single precision.
pub fn luminance(rgb: [f32; 3]) -> f32 {
    Vec3::from(rgb).dot(LUMINANCE.as_vec3())
}

/// The inverse of the sRGB curve of IEC 61966-2-1, for any number.
pub fn linear_from_srgb(encoded: f32) -> f32 {
    static OF_BYTES: LazyLock<[f32; 256]> =
        LazyLock::new(|| from_fn(|byte| inverse_curve(of_byte(byte as u8))));
    // Most values come from bytes.
    let byte = (encoded * 255.0 + 0.5) as u8;
    if of_byte(byte).to_bits() == encoded.to_bits() {
        OF_BYTES[usize::from(byte)]
    } else {
        inverse_curve(encoded)
    }
}

/// The value that decoders give a byte.
pub(crate) fn of_byte(byte: u8) -> f32 {
    f32::from(byte) / 255.0
}

/// The inverse of the sRGB curve, by its formula.
fn inverse_curve(encoded: f32) -> f32 {
    let encoded = f64::from(encoded);
    let linear = if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) };
    linear as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_as_linear_as_other_numbers() {
        let bytes = (0..=2550).map(|step| step as f32 / 2550.0).chain((0..=255).map(of_byte));
        for encoded in bytes.chain([-0.0, -1.0, 2.0, f32::MAX, f32::INFINITY, f32::NEG_INFINITY, f32::NAN]) {
            assert_eq!(linear_from_srgb(encoded).to_bits(), inverse_curve(encoded).to_bits(), "{encoded}");
        }
        assert_eq!([0.0, 1.0].map(linear_from_srgb), [0.0, 1.0]);
        assert!((linear_from_srgb(0.5) - 0.214_041_14).abs() < 1e-7);
    }
}
