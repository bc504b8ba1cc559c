//! Ranges of numbers, and their wording.

/// A range of numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Range {
    least: f64,
    most: f64,
    /// True if the range does not contain its ends.
    is_open: bool,
}

impl Range {
    pub const ALL: Range = Range { least: f64::NEG_INFINITY, most: f64::INFINITY, is_open: false };

    pub const fn above(least: f64) -> Range {
        Range { least, most: f64::INFINITY, is_open: true }
    }

    pub const fn at_least(least: f64) -> Range {
        Range { least, ..Range::ALL }
    }

    pub const fn below(most: f64) -> Range {
        Range { least: f64::NEG_INFINITY, most, is_open: true }
    }

    /// Without the ends.
    pub const fn between(least: f64, most: f64) -> Range {
        Range { least, most, is_open: true }
    }

    /// With the ends.
    pub const fn from_to(least: f64, most: f64) -> Range {
        Range { least, most, is_open: false }
    }

    pub fn contains(self, value: f64) -> bool {
        let Range { least, most, is_open } = self;
        let is_end = |end: f64| is_open && end.is_finite() && value == end;
        least <= value && value <= most && !is_end(least) && !is_end(most)
    }

    /// As in "must be above 0 and below 180". Empty for all numbers.
    pub fn words(self) -> String {
        let [least, most] = [self.least, self.most].map(number);
        match (self.least.is_finite(), self.most.is_finite(), self.is_open) {
            (false, false, _) => String::new(),
            (true, false, true) => format!("above {least}"),
            (true, false, false) => format!("at least {least}"),
            (false, true, true) => format!("below {most}"),
            (false, true, false) => format!("at most {most}"),
            (true, true, true) => format!("above {least} and below {most}"),
            (true, true, false) => format!("from {least} to {most}"),
        }
    }
}

/// A number in few characters.
pub(crate) fn number(value: f64) -> String {
    match value.abs() {
        0.0 | 0.001..1e6 => value.to_string(),
        f64::INFINITY => "infinity".into(),
        _ => format!("{value:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_have_words() {
        let ranges = [Range::ALL, Range::above(0.0), Range::between(0.0, 180.0), Range::from_to(1e-6, 1e6)];
        let words = ranges.map(Range::words);
        assert_eq!(words, ["", "above 0", "above 0 and below 180", "from 1e-6 to 1e6"]);
        assert!(Range::from_to(0.0, 1.0).contains(1.0) && !Range::between(0.0, 1.0).contains(1.0));
        assert!(!Range::ALL.contains(f64::NAN) && !Range::above(0.0).contains(f64::NAN));
    }
}
