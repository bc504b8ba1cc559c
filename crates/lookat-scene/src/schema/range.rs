//! Ranges of numbers, and their wording.

/// A range of numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Range {
    least: f64,
    most: f64,
    /// True for each end that the range does not contain.
    is_open: [bool; 2],
}

impl Range {
    pub const ALL: Range = Range { least: f64::NEG_INFINITY, most: f64::INFINITY, is_open: [false; 2] };

    pub const fn above(least: f64) -> Range {
        Range { least, most: f64::INFINITY, is_open: [true; 2] }
    }

    pub const fn at_least(least: f64) -> Range {
        Range { least, ..Range::ALL }
    }

    pub const fn below(most: f64) -> Range {
        Range { least: f64::NEG_INFINITY, most, is_open: [true; 2] }
    }

    /// Without the ends.
    pub const fn between(least: f64, most: f64) -> Range {
        Range { least, most, is_open: [true; 2] }
    }

    /// Without the least, with the most.
    pub const fn above_to(least: f64, most: f64) -> Range {
        Range { least, most, is_open: [true, false] }
    }

    /// With the ends.
    pub const fn from_to(least: f64, most: f64) -> Range {
        Range { least, most, is_open: [false; 2] }
    }

    pub fn contains(self, value: f64) -> bool {
        let Range { least, most, is_open: [without_least, without_most] } = self;
        let is_end = |is_open: bool, end: f64| is_open && end.is_finite() && value == end;
        least <= value && value <= most && !is_end(without_least, least) && !is_end(without_most, most)
    }

    /// As in "must be above 0 and below 180". Empty for all numbers.
    pub fn words(self) -> String {
        let [least, most] = [self.least, self.most].map(number);
        let [above, below] = self.is_open;
        match (self.least.is_finite(), self.most.is_finite()) {
            (false, false) => String::new(),
            (true, true) if !above && !below => format!("from {least} to {most}"),
            (has_least, has_most) => {
                let least = format!("{} {least}", if above { "above" } else { "at least" });
                let most = format!("{} {most}", if below { "below" } else { "at most" });
                let ends = [(has_least, least), (has_most, most)];
                ends.into_iter()
                    .filter(|(has, _)| *has)
                    .map(|(_, words)| words)
                    .collect::<Vec<_>>()
                    .join(" and ")
            }
        }
    }
}

/// A number in few characters.
pub(crate) fn number(value: f64) -> String {
    // The nearest `f32` of a short decimal number, unless it is a count.
    let is_count = value.fract() == 0.0 && value.abs() < 9e15;
    let value = match (value as f32).to_string().parse::<f64>() {
        Ok(short) if f64::from(value as f32) == value && !is_count => short,
        _ => value,
    };
    match value.abs() {
        0.0 | 0.001..1e6 => value.to_string(),
        f64::INFINITY => "infinity".into(),
        _ => {
            let (plain, power) = (value.to_string(), format!("{value:e}"));
            if plain.len() < power.len() { plain } else { power }
        }
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
        let words = [Range::above_to(0.0, 180.0), Range::at_least(1.0), Range::below(90.0)].map(Range::words);
        assert_eq!(words, ["above 0 and at most 180", "at least 1", "below 90"]);
        assert_eq!(
            [f64::from(1e18_f32), f64::from(0.1_f32), 0.1, -2.5].map(number),
            ["1e18", "0.1", "0.1", "-2.5"]
        );
        assert_eq!(Range::from_to(1.0, 1073741824.0).words(), "from 1 to 1073741824");
        assert!(Range::above_to(0.0, 1.0).contains(1.0) && !Range::above_to(0.0, 1.0).contains(0.0));
        assert!(Range::from_to(0.0, 1.0).contains(1.0) && !Range::between(0.0, 1.0).contains(1.0));
        assert!(!Range::ALL.contains(f64::NAN) && !Range::above(0.0).contains(f64::NAN));
    }
}
