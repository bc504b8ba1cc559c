//! Numbers for people.

/// A number with so many significant digits, and with an exponent if it is very large or very small.
pub fn digits(value: f64, count: usize) -> String {
    let rounded: f64 = format!("{value:.0$e}", count - 1).parse().unwrap_or(value);
    match rounded.abs() {
        0.0 | 1e-3..1e5 => rounded.to_string(),
        _ => format!("{rounded:e}"),
    }
}

/// A share in percent, with so many decimals at most. Only 0 and 1 are shown as 0 % and 100 %.
pub fn percent(share: f64, decimals: usize) -> String {
    let units = 10_f64.powi(decimals as i32);
    let (percent, least) = (100.0 * share, 1.0 / units);
    if percent > 0.0 && percent < least {
        format!("under {least} %")
    } else if percent > 100.0 - least && percent < 100.0 {
        format!("over {} %", 100.0 - least)
    } else {
        format!("{} %", (units * percent).round() / units)
    }
}

/// A number with commas and a noun.
pub fn count(number: u64, noun: &str) -> String {
    plural(number, noun, &format!("{noun}s"))
}

/// A number with commas and a noun in one of two forms.
pub fn plural(number: u64, one: &str, many: &str) -> String {
    format!("{} {}", grouped(number), if number == 1 { one } else { many })
}

/// A number with commas.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().filter_map(|group| str::from_utf8(group).ok()).collect();
    groups.join(",")
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
        assert_eq!([1, 999, 1000, 1_234_567].map(grouped), ["1", "999", "1,000", "1,234,567"]);
    }

    #[test]
    fn shares_are_rounded_but_never_to_all_or_nothing() {
        let shares = [0.0, 1e-6, 0.003, 0.12345, 0.5, 0.999_99, 1.0].map(|share| percent(share, 1));
        assert_eq!(shares, ["0 %", "under 0.1 %", "0.3 %", "12.3 %", "50 %", "over 99.9 %", "100 %"]);
        assert_eq!([0.5, 0.98765, 1e-5].map(|share| percent(share, 2)), ["50 %", "98.77 %", "under 0.01 %"]);
    }
}
