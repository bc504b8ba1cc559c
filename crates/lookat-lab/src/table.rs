//! Numbers and tables as text.

use std::fmt::Write;

/// A number in full, such as 0.005, 20 and 1e-5.
pub fn plain(x: f64) -> String {
    if (1e-4..1e5).contains(&x) { format!("{x}") } else { format!("{x:e}") }
}

/// A number with so many significant digits.
pub fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    // Rounded first, since 9.99 becomes 10.
    let rounded: f64 = format!("{x:.*e}", digits.saturating_sub(1)).parse().unwrap_or(x);
    let magnitude = rounded.abs().log10().floor() as i32;
    if !(-4..6).contains(&magnitude) {
        return format!("{rounded:e}");
    }
    let decimals = (digits as i32 - 1 - magnitude).max(0) as usize;
    format!("{rounded:.decimals$}")
}

/// Aligned columns: the first one left-aligned, the others right-aligned. A last column without a title is not padded.
/// All rows have the length of the first row.
pub fn aligned(rows: &[Vec<String>]) -> String {
    let width = |i: usize| rows.iter().map(|row| row[i].chars().count()).max().unwrap_or(0);
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (i, cell) in row.iter().enumerate() {
            let _ = match i {
                0 => write!(line, "{cell:width$}", width = width(0)),
                _ if rows[0][i].is_empty() => write!(line, "  {cell}"),
                _ => write!(line, "  {cell:>width$}", width = width(i)),
            };
        }
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned() {
        let rows = [["a", "long", ""], ["name", "1", "said"], ["b", "123456", ""]];
        let rows = rows.map(|row| row.map(String::from).to_vec());
        assert_eq!(aligned(&rows), "a       long\nname       1  said\nb     123456\n");
    }

    #[test]
    fn numbers_have_the_requested_digits() {
        let cases =
            [(0.012345, "0.0123"), (9.999, "10.0"), (1234.5, "1230"), (0.5, "0.500"), (-2.0, "-2.00")];
        for (x, expected) in cases {
            assert_eq!(significant(x, 3), expected);
        }
        assert_eq!([significant(1.234e-7, 3), significant(0.0, 3)], ["1.23e-7", "0"]);
    }
}
