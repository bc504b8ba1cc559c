//! What a display is given: values clipped to 0..1 on the sRGB curve.

use rayon::prelude::*;

/// The pixels that are worked on at a time.
const GRAIN: usize = 1 << 14;

/// A picture as an 8-bit file would hold it, but not rounded. PSNR and SSIM work on such values.
#[derive(Debug, Clone, PartialEq)]
pub struct Encoded {
    /// Red, green and blue, 0..1, on the sRGB curve.
    pub pixels: Vec<[f32; 3]>,
}

impl Encoded {
    /// Clips linear values to 0..1 and encodes them with the sRGB curve of IEC 61966-2-1. NaN becomes 0.
    pub fn from_linear(pixels: &[[f32; 3]]) -> Self {
        let mut encoded = vec![[0.0; 3]; pixels.len()];
        encoded.par_chunks_mut(GRAIN).zip(pixels.par_chunks(GRAIN)).for_each(|(encoded, pixels)| {
            for (encoded, &linear) in encoded.as_flattened_mut().iter_mut().zip(pixels.as_flattened()) {
                *encoded = encode(linear);
            }
        });
        Encoded { pixels: encoded }
    }
}

fn encode(linear: f32) -> f32 {
    let linear = clip(linear);
    // The power 1 / 2.4 = 1 / 3 + 1 / 12 is a cube root and its fourth root.
    let root = cube_root(linear.max(0.003));
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * root * root.sqrt().sqrt() - 0.055 }
}

/// The nearest value in 0..1; 0 for NaN.
#[expect(clippy::manual_clamp, reason = "clamp keeps NaN")]
pub(crate) fn clip(value: f32) -> f32 {
    value.max(0.0).min(1.0)
}

/// The cube root of a number above 1e-30, to an ulp or two. Unlike [`f32::cbrt`] it is a few operations
/// without a branch, so that a loop over pixels is vectorized.
pub(crate) fn cube_root(value: f32) -> f32 {
    // A third of the exponent, within four percent; each step of Halley's method cubes the error.
    let guess = f32::from_bits(value.to_bits() / 3 + 0x2a51_4067);
    let step = |root: f32| {
        let cube = root * root * root;
        root + root * (value - cube) / (2.0 * cube + value)
    };
    step(step(guess))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cube_roots_are_right() {
        for i in 0..=10_000 {
            let value = 1e-4 + i as f32 / 8000.0;
            let expected = f64::from(value).cbrt();
            assert!((f64::from(cube_root(value)) / expected - 1.0).abs() < 2e-7, "{value}");
        }
    }

    #[test]
    fn follows_the_srgb_curve() {
        for i in 0..=10_000 {
            let linear = i as f32 / 10_000.0;
            let exact = f64::from(linear);
            let expected =
                if linear <= 0.003_130_8 { 12.92 * exact } else { 1.055 * exact.powf(1.0 / 2.4) - 0.055 };
            assert!((f64::from(encode(linear)) - expected).abs() < 3e-7, "{linear}");
        }
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY].map(encode);
        assert_eq!((odd[0], odd[2]), (0.0, 0.0));
        assert!((odd[1] - 1.0).abs() < 1e-6);
    }
}
