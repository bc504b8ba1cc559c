//! Colors as FLIP compares them.

use crate::display::{clip, cube_root};

/// Linear sRGB to CIE XYZ, each row divided by its sum, so that white is (1, 1, 1). Whatever FLIP does with XYZ
/// begins with a division by white.
const XYZ_FROM_RGB: [[f32; 3]; 3] = [
    [0.433_895_4, 0.376_242_37, 0.189_862_24],
    [0.212_636_82, 0.715_182_98, 0.072_180_2],
    [0.017_752_42, 0.109_465_63, 0.872_781_95],
];
const RGB_FROM_XYZ: [[f32; 3]; 3] = [
    [3.080_342, -1.537_399, -0.542_943],
    [-0.921_178_4, 1.875_93, 0.045_248_41],
    [0.052_881_29, -0.204_011_2, 1.151_129_9],
];

/// Exponent of the color difference (q_c), and the point (p_c of its maximum, p_t) at which its scale has a
/// knee.
const EXPONENT: f32 = 0.7;
const KNEE: f32 = 0.4;
const KNEE_VALUE: f32 = 0.95;

/// Luminance, red-green and blue-yellow: the space YCxCz less its factors 116, 500 and 200 and its offset
/// -16. They would cancel, since only weighted means are taken in that space.
pub(super) fn opponent(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = transform(&XYZ_FROM_RGB, rgb);
    [y, x - y, y - z]
}

/// CIELAB of an opponent color, clipped to what a display can show, after the Hunt effect: a and b scaled by
/// L / 100. Inlined, so that the loop over pixels is vectorized.
#[inline(always)]
pub(super) fn hunt_lab([y, red_green, blue_yellow]: [f32; 3]) -> [f32; 3] {
    let rgb = transform(&RGB_FROM_XYZ, [y + red_green, y, y - blue_yellow]).map(clip);
    let [x, y, z] = transform(&XYZ_FROM_RGB, rgb).map(|t| {
        let root = cube_root(t.max(0.008));
        if t > 216.0 / 24389.0 { root } else { t * (841.0 / 108.0) + 4.0 / 29.0 }
    });
    let l = 116.0 * y - 16.0;
    [l, 0.01 * l * 500.0 * (x - y), 0.01 * l * 200.0 * (y - z)]
}

/// The distance HyAB: city block between lightness and the rest, euclidean within the rest.
pub(super) fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [l, red_green, blue_yellow] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    l.abs() + (red_green * red_green + blue_yellow * blue_yellow).sqrt()
}

/// Brings distances to 0..1.
#[derive(Clone, Copy)]
pub(super) struct Scale {
    largest: f32,
}

impl Scale {
    /// The largest distance is that from green to blue.
    pub(super) fn new() -> Self {
        let lab = |rgb| hunt_lab(opponent(rgb));
        Scale { largest: hyab(lab([0.0, 1.0, 0.0]), lab([0.0, 0.0, 1.0])).powf(EXPONENT) }
    }

    /// The color difference, 0..1, of a distance HyAB. Small differences get most of the range.
    pub(super) fn difference(self, distance: f32) -> f32 {
        let power = distance.powf(EXPONENT);
        let knee = KNEE * self.largest;
        if power < knee {
            power * (KNEE_VALUE / knee)
        } else {
            KNEE_VALUE + (power - knee) / (self.largest - knee) * (1.0 - KNEE_VALUE)
        }
    }
}

fn transform(matrix: &[[f32; 3]; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    matrix.map(|[a, b, c]| a * x + b * y + c * z)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(actual: [f32; 3], expected: [f32; 3], within: f32) {
        let near = actual.iter().zip(expected).all(|(a, b)| (a - b).abs() <= within);
        assert!(near, "{actual:?}, not {expected:?}");
    }

    #[test]
    fn the_matrices_are_inverse() {
        for rgb in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.3, 0.9, 0.1]] {
            check(transform(&RGB_FROM_XYZ, transform(&XYZ_FROM_RGB, rgb)), rgb, 1e-6);
        }
    }

    #[test]
    fn grays_have_no_color() {
        check(opponent([1.0; 3]), [1.0, 0.0, 0.0], 1e-6);
        check(hunt_lab([0.0; 3]), [0.0; 3], 1e-4);
        check(hunt_lab(opponent([0.001; 3])), [0.9033, 0.0, 0.0], 1e-4);
        check(hunt_lab(opponent([0.184_187; 3])), [50.0, 0.0, 0.0], 1e-3);
        check(hunt_lab(opponent([7.0; 3])), [100.0, 0.0, 0.0], 1e-3);
    }

    #[test]
    fn differences_are_from_0_to_1() {
        let scale = Scale::new();
        assert_eq!(scale.difference(0.0), 0.0);
        let largest = scale.largest.powf(1.0 / EXPONENT);
        assert!((scale.difference(largest) - 1.0).abs() < 1e-5);
        let knee = (KNEE * scale.largest).powf(1.0 / EXPONENT);
        assert!((scale.difference(knee * 0.999_99) - scale.difference(knee * 1.000_01)).abs() < 1e-4);
    }
}
