//! What the false colors stand for.

use rayon::prelude::*;

use crate::rank::{nearest_rank, ranked};

/// The share of the differences, of those that are not 0, that the scale is to hold.
const HELD: f64 = 0.995;
/// A difference in 32-bit floats that should be 0.002 may be a little more.
const SLACK: f64 = 1.0 + 1e-6;

/// The range of differences that has colors of its own: -limit..limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ColorScale {
    /// 1, 2 or 5 times a power of ten.
    pub limit: f64,
    /// Whether some difference is below the range, and whether one is above it.
    pub beyond: [bool; 2],
}

impl ColorScale {
    /// The scale for these differences, of which those that are NaN do not count. `None` if all are 0.
    pub fn of(differences: &[f32]) -> Option<ColorScale> {
        let limit = difference_limit(differences)?;
        let beyond = |sign: f64| differences.par_iter().any(|&x| sign * f64::from(x) > limit * SLACK);
        Some(ColorScale { limit, beyond: [beyond(-1.0), beyond(1.0)] })
    }

    /// The given number of ticks, odd and at least 3, from end to end.
    pub fn ticks(&self, count: usize) -> Vec<Tick> {
        let half = (count / 2) as f64;
        let tick = |i: usize| {
            let share = i as f64 / half - 1.0;
            let relation = match share {
                -1.0 if self.beyond[0] => "<= ",
                1.0 if self.beyond[1] => ">= ",
                _ => "",
            };
            let text = format!("{relation}{}", short(share * self.limit));
            Tick { place: (share + 1.0) / 2.0, text }
        };
        (0..count).map(tick).collect()
    }
}

/// A place on the scale and what is written there.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    /// 0 at the negative end, 1 at the positive one.
    pub place: f64,
    pub text: String,
}

/// The difference that has the last color, 1, 2 or 5 times a power of ten: no less than 99.5 % of these, of
/// which those that are 0 or NaN do not count. `None` if all are.
pub fn difference_limit(differences: &[f32]) -> Option<f64> {
    let count = |test: fn(&f32) -> bool| differences.par_iter().filter(|x| test(x)).count();
    let (zero, other) = (count(|x| *x == 0.0), count(|x| *x != 0.0 && !x.is_nan()));
    let rank = zero + nearest_rank(HELD, other);
    (other > 0).then(|| round_up(ranked(differences.len(), |i| [differences[i]], rank).into()))
}

/// The least of 1, 2 and 5 times a power of ten that is not smaller than a positive number.
fn round_up(value: f64) -> f64 {
    let power = value.log10().floor() as i32;
    let steps = (power - 1..=power + 1).flat_map(|power| [1, 2, 5].map(|digit| (digit, power)));
    // From text, because no other way gives the float that is nearest to the decimal number.
    let mut limits = steps.filter_map(|(digit, power)| format!("{digit}e{power}").parse::<f64>().ok());
    limits.find(|limit| value <= limit * SLACK).unwrap_or(f64::MAX)
}

/// A number in the shorter of the usual notations.
fn short(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 {
        "0".into()
    } else if (0.001..10_000.0).contains(&magnitude) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_rounded_up() {
        let check = |value: f64, expected: f64| assert_eq!(round_up(value), expected, "{value}");
        check(0.9, 1.0);
        check(1.0, 1.0);
        check(1.001, 2.0);
        check(2.1, 5.0);
        check(5.1, 10.0);
        check(999.0, 1000.0);
        check(0.002_f32.into(), 0.002);
        check(0.1_f32.into(), 0.1);
        check(4e-7, 5e-7);
        check(1e-45, 1e-45);
        check(f32::MAX.into(), 5e38);
    }

    #[test]
    fn the_scale_holds_all_but_the_largest_differences() {
        let differences = |few: f32| {
            let many = (1..=995).map(|i| i as f32 / 1000.0);
            many.chain([few; 5]).chain([0.0; 9000]).chain([f32::NAN; 10]).collect::<Vec<_>>()
        };
        let scale = |few| ColorScale::of(&differences(few)).unwrap();
        assert_eq!(scale(3.0), ColorScale { limit: 1.0, beyond: [false, true] });
        assert_eq!(scale(-3.0), ColorScale { limit: 1.0, beyond: [true, false] });
        assert_eq!(scale(1.0), ColorScale { limit: 1.0, beyond: [false, false] });
        // Of few, it holds all.
        assert_eq!(
            ColorScale::of(&[0.0, 0.001, -70.0]).unwrap(),
            ColorScale { limit: 100.0, beyond: [false; 2] }
        );
        assert_eq!(ColorScale::of(&[0.0, -0.0, f32::NAN]), None);
    }

    #[test]
    fn ticks_are_short() {
        let texts = |limit, beyond, count| {
            let ticks = ColorScale { limit, beyond }.ticks(count);
            ticks.into_iter().map(|tick| tick.text).collect::<Vec<_>>()
        };
        assert_eq!(texts(0.005, [false; 2], 5), ["-0.005", "-0.0025", "0", "0.0025", "0.005"]);
        assert_eq!(texts(1e-5, [true, false], 3), ["<= -1e-5", "0", "1e-5"]);
        assert_eq!(texts(20_000.0, [false, true], 3), ["-2e4", "0", ">= 2e4"]);
        let places: Vec<_> =
            ColorScale { limit: 1.0, beyond: [false; 2] }.ticks(5).iter().map(|t| t.place).collect();
        assert_eq!(places, [0.0, 0.25, 0.5, 0.75, 1.0]);
    }
}
