//! False colors.

/// Colors of signed differences, from the most negative (dark blue) over zero (nearly white) to the most
/// positive (dark red), at equal distances; between them, sRGB values are interpolated. Lightness falls
/// evenly with the magnitude on both sides, and people with color vision deficiencies can tell the sides
/// apart.
///
/// This is `vik` of the Scientific color maps 8.0 of Fabio Crameri, 33 points of the middle 80 %: the rest
/// is so dark that the sides look alike in single pixels. Copyright (c) 2023 Fabio Crameri, MIT License,
/// <https://doi.org/10.5281/zenodo.1243862>.
pub const DIFFERENCE_COLORS: [[u8; 3]; 33] = [
    [2, 58, 122],
    [3, 68, 129],
    [4, 78, 135],
    [8, 88, 142],
    [17, 100, 150],
    [31, 112, 158],
    [47, 124, 166],
    [66, 138, 175],
    [86, 151, 184],
    [106, 164, 193],
    [126, 176, 201],
    [146, 189, 210],
    [167, 201, 218],
    [187, 213, 226],
    [207, 224, 232],
    [224, 230, 233],
    [236, 229, 225],
    [238, 221, 211],
    [235, 209, 194],
    [230, 196, 177],
    [225, 184, 160],
    [220, 171, 143],
    [215, 159, 127],
    [210, 147, 111],
    [205, 136, 96],
    [200, 125, 81],
    [195, 114, 67],
    [190, 102, 52],
    [183, 90, 38],
    [174, 75, 24],
    [161, 60, 12],
    [147, 46, 6],
    [134, 35, 6],
];

/// The color of a pixel that is not finite. It is far from all of [`DIFFERENCE_COLORS`].
pub const NOT_FINITE_COLOR: [u8; 3] = [255, 0, 255];

/// The color, in 8-bit sRGB, of a difference as a share of the largest one, -1..1. What is beyond gets the
/// color of the end; NaN gets [`NOT_FINITE_COLOR`].
pub fn difference_color(share: f64) -> [u8; 3] {
    if share.is_nan() {
        return NOT_FINITE_COLOR;
    }
    let last = DIFFERENCE_COLORS.len() - 1;
    let place = (share.clamp(-1.0, 1.0) + 1.0) / 2.0 * last as f64;
    let before = (place as usize).min(last - 1);
    let (a, b) = (DIFFERENCE_COLORS[before], DIFFERENCE_COLORS[before + 1]);
    std::array::from_fn(|i| mix(a[i], b[i], place - before as f64))
}

/// `a` for the share 0, `b` for 1.
pub(super) fn mix(a: u8, b: u8, share: f64) -> u8 {
    (f64::from(a) + (f64::from(b) - f64::from(a)) * share).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_are_interpolated_and_clamped() {
        assert_eq!(difference_color(0.0), [236, 229, 225]);
        assert_eq!(difference_color(1.0), [134, 35, 6]);
        assert_eq!(difference_color(f64::INFINITY), [134, 35, 6]);
        assert_eq!(difference_color(-7.0), [2, 58, 122]);
        assert_eq!(difference_color(1.0 / 16.0), DIFFERENCE_COLORS[17]);
        assert_eq!(difference_color(-1.0 / 32.0), [230, 230, 229]);
        assert_eq!(difference_color(f64::NAN), NOT_FINITE_COLOR);
    }

    #[test]
    fn a_larger_difference_is_darker() {
        let luma = |share: f64| {
            let [r, g, b] = difference_color(share).map(f64::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for i in 1..32 {
            let (less, more) = (f64::from(i) / 32.0, f64::from(i + 1) / 32.0);
            assert!(luma(less) > luma(more) && luma(-less) > luma(-more), "{i}");
        }
    }
}
