//! Rounding down.

/// The largest integer that is not above `x`; beyond the range of `i64` one of its ends, and 0 for what is no number.
///
/// Processors of the baseline cannot round; there `f64::floor` is the call of a function.
#[inline]
pub fn floor(x: f64) -> i64 {
    let toward_zero = x as i64;
    toward_zero.saturating_sub(i64::from(toward_zero as f64 > x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_that_of_the_standard_library() {
        let near_whole = [-3.0_f64, -1.0, -0.0, 0.0, 1.0, 2.0, 4503599627370495.0, -4503599627370497.0];
        for x in near_whole.iter().flat_map(|x| [x.next_down(), *x, x.next_up(), x + 0.5]) {
            assert_eq!(floor(x), x.floor() as i64, "{x}");
        }
    }

    #[test]
    fn what_no_integer_holds() {
        assert_eq!(
            [floor(1e300), floor(f64::INFINITY), floor(-(2.0_f64.powi(63)))],
            [i64::MAX, i64::MAX, i64::MIN]
        );
        assert_eq!([-1e19, -1e300, f64::NEG_INFINITY].map(floor), [i64::MIN; 3]);
        assert_eq!(floor(f64::NAN), 0);
    }
}
