//! Numbers in messages.

use lookat_scene::glam::DVec3;

/// A number with so many significant digits, and with an exponent if it is very large or very small.
pub fn digits(value: f64, count: usize) -> String {
    let rounded: f64 = format!("{value:.0$e}", count - 1).parse().unwrap_or(value);
    match rounded.abs() {
        0.0 | 1e-3..1e5 => rounded.to_string(),
        _ => format!("{rounded:e}"),
    }
}

/// A number with four digits.
pub fn short(number: f64) -> String {
    digits(number, 4)
}

/// Three numbers, as in a scene file.
pub(crate) fn point(p: DVec3) -> String {
    let DVec3 { x, y, z } = p;
    format!("{} {} {}", short(x), short(y), short(z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let two = [0.0, 0.2149, 3.44, 1234.0, 9.99e4, 1e5, 8.64e-7, 0.000_999].map(|it| digits(it, 2));
        assert_eq!(two, ["0", "0.21", "3.4", "1200", "1e5", "1e5", "8.6e-7", "0.001"]);
        let four = [256.0, 0.012_345_6, -36.521_7, 3e-9, 0.5].map(|it| digits(it, 4));
        assert_eq!(four, ["256", "0.01235", "-36.52", "3e-9", "0.5"]);
    }
}
